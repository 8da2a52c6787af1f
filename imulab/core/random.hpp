// Repeatable random numbers: a draw depends on seed, stream and index alone (counter-based, Random123 Philox), so results are
// bit-equal on any number of threads.
#pragma once

#include <cstdint>
#include <span>
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
  /// Standard normal draws number `begin` and following: the same as one by one, at a fraction of the cost.
  void normals(std::uint64_t begin, std::span<double> out) const;
  /// Uniform in (0, 1).
  double uniform(std::uint64_t index) const;

 private:
  std::uint64_t seed_, stream_;
};

}  // namespace imulab
