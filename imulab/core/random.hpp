// Repeatable random numbers: a draw depends on seed, stream and index alone (counter-based, Random123 Philox), so results are
// bit-equal on any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace imulab {

/// Counter-based random numbers of one purpose: each purpose (a sensor axis's noise, a truth's draw) has its own stream number.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}
  /// A stream named by its purpose.
  RandomStream(std::uint64_t seed, std::string_view purpose);

  /// Standard normal draw number `index`.
  double normal(std::uint64_t index) const;
  /// Draws 2 `pair` and 2 `pair` + 1 at the cost of one.
  std::array<double, 2> normal_pair(std::uint64_t pair) const;
  /// Uniform in (0, 1).
  double uniform(std::uint64_t index) const;

 private:
  std::uint64_t seed_, stream_;
};

}  // namespace imulab
