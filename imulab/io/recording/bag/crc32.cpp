#include "imulab/io/recording/bag/crc32.hpp"

#include "imulab/io/recording/bag/bytes.hpp"

#include <array>
#include <cstddef>
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#endif

namespace imulab::bag {
namespace {

/// tables[k][b]: what the byte b does to the checksum when k more bytes follow it.
constexpr auto crc_tables = [] {
  std::array<std::array<std::uint32_t, 256>, 16> tables{};
  for (std::uint32_t b = 0; b < 256; ++b) {
    std::uint32_t c = b;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? (c >> 1) ^ 0xEDB88320u : c >> 1;
    tables[0][b] = c;
  }
  for (std::size_t k = 1; k < 16; ++k)
    for (std::size_t b = 0; b < 256; ++b) tables[k][b] = (tables[k - 1][b] >> 8) ^ tables[0][tables[k - 1][b] & 255];
  return tables;
}();

/// The register after more bytes: sixteen at once, whose look-ups do not wait for each other.
std::uint32_t crc_by_tables(std::string_view bytes, std::uint32_t c) {
  const char* p = bytes.data();
  std::size_t left = bytes.size();
  const auto part = [](std::uint32_t word, std::size_t k) {
    return crc_tables[k][word & 255] ^ crc_tables[k - 1][(word >> 8) & 255] ^ crc_tables[k - 2][(word >> 16) & 255] ^ crc_tables[k - 3][word >> 24];
  };
  for (; left >= 16; p += 16, left -= 16)
    c = part(number_at<std::uint32_t>(p) ^ c, 15) ^ part(number_at<std::uint32_t>(p + 4), 11) ^ part(number_at<std::uint32_t>(p + 8), 7) ^
        part(number_at<std::uint32_t>(p + 12), 3);
  for (; left > 0; ++p, --left) c = (c >> 8) ^ crc_tables[0][(c ^ static_cast<unsigned char>(*p)) & 255];
  return c;
}

#if defined(__x86_64__) && defined(__GNUC__)

/// The same by multiplication without carry, where the processor has it: 64 bytes are folded onto the next 64 until 16 remain, which have the same
/// remainder (V. Gopal et al., Fast CRC computation for generic polynomials using PCLMULQDQ, Intel 2009; the factors are x^n mod P, reflected).
__attribute__((target("pclmul,sse4.1"))) std::uint32_t crc_by_folding(std::string_view bytes, std::uint32_t c) {
  const char* p = bytes.data();
  const auto load = [](const char* from) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)); };
  __m128i x0 = _mm_xor_si128(load(p), _mm_cvtsi32_si128(static_cast<int>(c))), x1 = load(p + 16), x2 = load(p + 32), x3 = load(p + 48);
  const __m128i by_64 = _mm_set_epi64x(0x1c6e41596, 0x154442bd4), by_16 = _mm_set_epi64x(0x0ccaa009e, 0x1751997d0);
  std::size_t left = bytes.size() - 64;
#define IMULAB_FOLD(x, by, next) _mm_xor_si128(_mm_xor_si128(_mm_clmulepi64_si128(x, by, 0x00), _mm_clmulepi64_si128(x, by, 0x11)), next)
  for (p += 64; left >= 64; p += 64, left -= 64) {
    x0 = IMULAB_FOLD(x0, by_64, load(p));
    x1 = IMULAB_FOLD(x1, by_64, load(p + 16));
    x2 = IMULAB_FOLD(x2, by_64, load(p + 32));
    x3 = IMULAB_FOLD(x3, by_64, load(p + 48));
  }
  x1 = IMULAB_FOLD(x0, by_16, x1);
  x2 = IMULAB_FOLD(x1, by_16, x2);
  x3 = IMULAB_FOLD(x2, by_16, x3);
#undef IMULAB_FOLD
  char last[16];
  _mm_storeu_si128(reinterpret_cast<__m128i*>(last), x3);
  return crc_by_tables({p, left}, crc_by_tables({last, sizeof last}, 0));
}

bool can_fold() {
  static const bool can = __builtin_cpu_supports("pclmul") && __builtin_cpu_supports("sse4.1");
  return can;
}

#else

std::uint32_t crc_by_folding(std::string_view bytes, std::uint32_t c) { return crc_by_tables(bytes, c); }
bool can_fold() { return false; }

#endif

}  // namespace

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) {
  return ~(bytes.size() >= 64 && can_fold() ? crc_by_folding(bytes, ~before) : crc_by_tables(bytes, ~before));
}

}  // namespace imulab::bag
