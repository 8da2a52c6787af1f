#include "imulab/core/random.hpp"

#include <Random123/philox.h>

#include <Random123/uniform.hpp>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

r123::Philox2x64::ctr_type philox(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  return r123::Philox2x64{}({{index, stream}}, {{seed}});
}

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const unsigned char c : text) hash = (hash ^ c) * 1099511628211u;
  return hash;
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::string_view purpose) : RandomStream(seed, fnv1a(purpose)) {}

std::array<double, 2> RandomStream::normal_pair(std::uint64_t pair) const {
  const auto u = philox(seed_, stream_, pair);
  const double radius = std::sqrt(-2 * std::log(r123::u01<double>(u[0])));
  const double angle = 2 * std::numbers::pi * r123::u01<double>(u[1]);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

double RandomStream::normal(std::uint64_t index) const { return normal_pair(index / 2)[index % 2]; }

double RandomStream::uniform(std::uint64_t index) const { return r123::u01<double>(philox(seed_, stream_, index)[0]); }

}  // namespace imulab
