// SHA-256 (FIPS 180-4), for naming sessions and recordings by their content.
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#ifdef __x86_64__
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace imulab {
namespace {

using HashState = std::array<std::uint32_t, 8>;

// First 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2).
constexpr std::array<std::uint32_t, 64> k{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5, 0xd807aa98, 0x12835b01, 0x243185be,
    0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174, 0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa,
    0x5cb0a9dc, 0x76f988da, 0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967, 0x27b70a85,
    0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85, 0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3,
    0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070, 0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f,
    0x682e6ff3, 0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

constexpr std::size_t sha_block = 64;

void compress_block(HashState& h, const char* block) {
  std::array<std::uint32_t, 64> w;
  for (std::size_t t = 0; t < 16; ++t) {
    w[t] = 0;
    for (std::size_t i = 0; i < 4; ++i) w[t] = (w[t] << 8) | static_cast<unsigned char>(block[4 * t + i]);
  }
  for (std::size_t t = 16; t < 64; ++t) {
    const std::uint32_t s0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ (w[t - 15] >> 3);
    const std::uint32_t s1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ (w[t - 2] >> 10);
    w[t] = w[t - 16] + s0 + w[t - 7] + s1;
  }
  HashState v = h;
  for (std::size_t t = 0; t < 64; ++t) {
    const auto [a, b, c, d, e, f, g, last] = v;
    const std::uint32_t t1 = last + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) + ((e & f) ^ (~e & g)) + k[t] + w[t];
    const std::uint32_t t2 = (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
    v = {t1 + t2, a, b, c, d + t1, e, f, g};
  }
  for (std::size_t i = 0; i < 8; ++i) h[i] += v[i];
}

void compress(HashState& h, const char* blocks, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) compress_block(h, blocks + sha_block * i);
}

#ifdef __x86_64__

/// The compression by the processor's own instructions: four steps of the schedule or two rounds each, on a, b, e, f and c, d, g, h.
__attribute__((target("sha,sse4.1"))) void compress_by_instructions(HashState& h, const char* blocks, std::size_t count) {
  const auto words = [](std::uint32_t lane3, std::uint32_t lane2, std::uint32_t lane1, std::uint32_t lane0) {
    return _mm_set_epi32(static_cast<int>(lane3), static_cast<int>(lane2), static_cast<int>(lane1), static_cast<int>(lane0));
  };
  const __m128i big_endian = _mm_set_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3);
  __m128i abef = words(h[0], h[1], h[4], h[5]), cdgh = words(h[2], h[3], h[6], h[7]);
  for (; count > 0; --count, blocks += sha_block) {
    const __m128i abef_before = abef, cdgh_before = cdgh;
    __m128i w[16];
    for (std::size_t i = 0; i < 16; ++i) {
      if (i < 4) {
        w[i] = _mm_shuffle_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(blocks + 16 * i)), big_endian);
      } else {
        const __m128i sum = _mm_add_epi32(_mm_sha256msg1_epu32(w[i - 4], w[i - 3]), _mm_alignr_epi8(w[i - 1], w[i - 2], 4));
        w[i] = _mm_sha256msg2_epu32(sum, w[i - 1]);
      }
      const __m128i added = _mm_add_epi32(w[i], _mm_loadu_si128(reinterpret_cast<const __m128i*>(&k[4 * i])));
      cdgh = _mm_sha256rnds2_epu32(cdgh, abef, added);
      abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(added, 0x0E));
    }
    abef = _mm_add_epi32(abef, abef_before);
    cdgh = _mm_add_epi32(cdgh, cdgh_before);
  }
  std::array<std::uint32_t, 4> first, second;
  _mm_storeu_si128(reinterpret_cast<__m128i*>(first.data()), abef);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(second.data()), cdgh);
  h = {first[3], first[2], second[3], second[2], first[1], first[0], second[1], second[0]};
}

bool has_instructions() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  const bool sha = __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & bit_SHA) != 0;
  return sha && __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_SSE4_1) != 0 && (c & bit_SSSE3) != 0;
}

auto compression(bool by_instructions) {
  static const bool has = has_instructions();
  return has && by_instructions ? compress_by_instructions : compress;
}

#else

auto compression(bool) { return compress; }

#endif

/// A sum to which text is added.
class Sha256 {
 public:
  explicit Sha256(bool by_instructions = true) : compress_(compression(by_instructions)) {}
  /// All but the last piece in multiples of 64 bytes.
  void add(std::string_view text) {
    bytes_ += text.size();
    const std::size_t blocks = text.size() / sha_block;
    compress_(h_, text.data(), blocks);
    tail_ = text.substr(sha_block * blocks);
  }
  std::string digits() {
    std::string padded(tail_);  // 5.1.1: a one bit, zeros, the length in bits
    padded += '\x80';
    while (padded.size() % sha_block != 56) padded += '\0';
    for (int shift = 56; shift >= 0; shift -= 8) padded += static_cast<char>(8 * bytes_ >> shift);
    compress_(h_, padded.data(), padded.size() / sha_block);
    std::string digits;
    for (const std::uint32_t word : h_)
      for (int shift = 28; shift >= 0; shift -= 4) digits += "0123456789abcdef"[(word >> shift) & 15];
    return digits;
  }

 private:
  // First 32 bits of the fractional parts of the square roots of the first 8 primes (5.3.3).
  HashState h_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::uint64_t bytes_ = 0;
  std::string tail_;
  void (*compress_)(HashState&, const char*, std::size_t);
};

}  // namespace

std::string sha256(std::string_view text, bool by_instructions) {
  Sha256 sum(by_instructions);
  sum.add(text);
  return sum.digits();
}

namespace {

FileSum sum_of_one(const std::filesystem::path& path) {
  constexpr std::size_t piece = 1 << 22;
  const MappedFile mapped(path);
  const std::string_view text = mapped.text();
  Sha256 sum;
  const ReadingMeter meter(text.size());
  for (std::size_t at = 0; at < text.size(); at += piece) {
    sum.add(text.substr(at, piece));
    meter.add(std::min(piece, text.size() - at));
    mapped.release(at + piece);
  }
  return {sum.digits(), text.size()};
}

}  // namespace

FileSum file_sum(const std::filesystem::path& path) {
  if (!is_several_files(path)) return sum_of_one(path);
  FileSum all;
  std::string lines;  // of each file, as sha256sum prints them
  for (const std::filesystem::path& file : files_of(path)) {
    const FileSum one = sum_of_one(file);
    lines += one.sha256 + "  " + file.lexically_relative(path.parent_path()).string() + "\n";
    all.bytes += one.bytes;
  }
  all.sha256 = sha256(lines);
  return all;
}

}  // namespace imulab
