#include "imulab/core/random.hpp"

#ifndef __SIZEOF_INT128__
#define R123_USE_MULHILO64_C99 1  // 32-bit processors: the same words from products of 32 bits
#endif
#include <Random123/philox.h>
#include <Random123/uniform.hpp>

#include <array>
#include <cmath>

namespace imulab {

namespace {

r123::Philox2x64::ctr_type philox(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  return r123::Philox2x64{}({{index, stream}}, {{seed}});
}

/// Four words; draw i takes word i % 4 of block i / 4, attempt 0, and if it needs more, words of its own blocks i, attempt 1, 2, ...
r123::Philox4x64::ctr_type block(std::uint64_t seed, std::uint64_t stream, std::uint64_t number, std::uint64_t attempt) {
  return r123::Philox4x64{}({{number, stream, attempt, 0}}, {{seed, 0}});
}

// Marsaglia & Tsang 2000: the area under exp(-x^2 / 2), x > 0, as 256 layers of one area; the first contains the tail.
constexpr double tail_begin = 3.6541528853610088, area = 0.00492867323399142;
struct Ziggurat {
  std::array<double, 257> x, f;  // right edges, and the density there
  Ziggurat() {
    const auto density = [](double at) { return std::exp(-0.5 * at * at); };
    x[0] = area / density(tail_begin), x[1] = tail_begin, x[256] = 0;
    for (std::size_t i = 2; i < 256; ++i) x[i] = std::sqrt(-2 * std::log(area / x[i - 1] + density(x[i - 1])));
    for (std::size_t i = 0; i < 257; ++i) f[i] = density(x[i]);
  }
};
const Ziggurat& ziggurat() {
  static const Ziggurat table;
  return table;
}

/// The proposal of a word: a layer (8 bits) and a place in it (53 others, signed).
struct Candidate {
  std::size_t layer;
  double x;
  bool inside;  // of the layer above as well, so certainly under the density
  Candidate(const Ziggurat& z, std::uint64_t word)
      : layer(word & 255),
        x(static_cast<double>(static_cast<std::int64_t>(word) >> 11) * 0x1p-52 * z.x[layer]),
        inside(std::abs(x) < z.x[layer + 1]) {}
};

/// Completes the one candidate in about 80 that falls into the tail or on the edge of a layer.
double outside(const Ziggurat& z, Candidate c, std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  for (std::uint64_t attempt = 1;; ++attempt) {
    const auto words = block(seed, stream, index, attempt);
    const double u = r123::u01<double>(words[0]), v = r123::u01<double>(words[1]);
    if (c.layer == 0) {  // Marsaglia 1964: exponential, accepted by a second one; the tail is kept until it is accepted
      const double beyond = -std::log(u) / tail_begin;
      if (-2 * std::log(v) > beyond * beyond) return c.x < 0 ? -tail_begin - beyond : tail_begin + beyond;
    } else {
      if (z.f[c.layer] + u * (z.f[c.layer + 1] - z.f[c.layer]) < std::exp(-0.5 * c.x * c.x)) return c.x;
      c = Candidate(z, words[2]);
      if (c.inside) return c.x;
    }
  }
}

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view purpose) : RandomStream(seed, fnv1a(purpose)) {}

void RandomStream::normals(std::uint64_t begin, std::span<double> out) const {
  const Ziggurat& z = ziggurat();
  for (std::size_t k = 0; k < out.size();) {
    const std::uint64_t index = begin + k;
    const auto words = block(seed_, stream_, index / 4, 0);
    for (std::size_t word = index % 4; word < 4 && k < out.size(); ++word, ++k) {
      const Candidate c(z, words[word]);
      out[k] = c.inside ? c.x : outside(z, c, seed_, stream_, begin + k);
    }
  }
}

double RandomStream::normal(std::uint64_t index) const {
  double x;
  normals(index, {&x, 1});
  return x;
}

double RandomStream::uniform(std::uint64_t index) const { return r123::u01<double>(philox(seed_, stream_, index)[0]); }

}  // namespace imulab
