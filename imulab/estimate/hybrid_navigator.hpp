// Velocity and attitude of a unit as its compensated readings say, block by block, with their derivatives by the filter's states.
#pragma once

#include "imulab/estimate/hybrid_filter.hpp"
#include "imulab/navigation/increment.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace imulab {

/// The compensated recording, the size effect of the model's lever arms removed.
struct HybridSamples {
  Columns3 rate, force;
  Vector3d rate_at(std::size_t i) const { return {rate[0][i], rate[1][i], rate[2][i]}; }
  Vector3d force_at(std::size_t i) const { return {force[0][i], force[1][i], force[2][i]}; }
  /// By differences of the neighbours: over a block these add up to the rate's change from its beginning to its end.
  Vector3d angular_acceleration(std::size_t i, double interval) const {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, rate[0].size() - 1);
    return (rate_at(after) - rate_at(before)) / (static_cast<double>(after - before) * interval);
  }
};

HybridSamples compensated(const Recording& recording, const std::vector<HybridBlock>& blocks, const SensorModel& model);

/// What a block adds to velocity and attitude, with its derivatives by the states.
struct HybridSums {
  double duration = 0;
  Vector3d velocity = Vector3d::Zero();     // computed, gravity included
  Matrix3d force = Matrix3d::Zero();        // integral of [f_n x]
  std::array<Matrix3d, 7> gyro{};           // integrals of C b for b = 1, w, f: what an error of the rate turns
  std::array<Matrix3d, 7> gyro_velocity{};  // and moves: integrals of [f_n x] times the former
  std::array<Matrix3d, 4> accel{};          // integrals of C b for b = 1, f
  Matrix3d quadratic = Matrix3d::Zero();
  Eigen::Matrix<double, 3, 9> lever_arm = Eigen::Matrix<double, 3, 9>::Zero();
  Vector3d delay = Vector3d::Zero();
};

class HybridNavigator {
 public:
  HybridNavigator(const HybridSamples& samples, const Recording& recording, const HybridSite& site, const HybridLayout& layout);

  Matrix3d C_nb = Matrix3d::Identity();

  /// Levels from the mean force, heading from the mean rate where its horizontal part shows the Earth's.
  void align(const Range& range);

  /// `first`: the sample since which the motion was seen without a break.
  HybridSums over(const HybridBlock& block, std::size_t first);

 private:
  void add(HybridSums& sum, std::size_t i, std::size_t first, const HybridBlock& block);
  double interval(std::size_t i, const HybridBlock& block) const;

  const HybridSamples& samples_;
  const Recording& recording_;
  const HybridLayout& layout_;
  Vector3d earth_rate_, gravity_;
  Increment previous_;
};

}  // namespace imulab
