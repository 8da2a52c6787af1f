#include "imulab/simulate/simulate_motion.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/simulate/sensor_noise.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {

Recording simulate_motion(const std::vector<Increment>& ideal, double interval, const Truth& unit, std::uint64_t seed) {
  if (!unit.model.lever_arm.isZero(0)) throw Error("the unit has lever arms: a motion gives what one point feels, expected none");
  const bool thermal = !unit.model.accel.thermal.isZero(0) || !unit.model.gyro.thermal.isZero(0);
  if (thermal) throw Error("the unit has thermal terms: a motion has no temperature, expected none");
  Recording r;
  r.name = "recording.csv";
  r.interval_s = interval;
  r.gyro_unit = unit.model.gyro.raw_unit.empty() ? "rad/s" : unit.model.gyro.raw_unit;  // a drawn unit does not say
  r.accel_unit = unit.model.accel.raw_unit.empty() ? "m/s^2" : unit.model.accel.raw_unit;
  for (std::size_t i = 0; i < ideal.size(); ++i) r.time_ns.push_back(std::llround(1e9 * interval * static_cast<double>(i + 1)));
  MotionColumns columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    for (const Increment& sample : ideal) {
      r.gyro[axis].push_back(sample.angle[row] / interval);
      r.accel[axis].push_back(sample.velocity[row] / interval);
    }
    columns.rate[axis] = r.gyro[axis];
    columns.force[axis] = r.accel[axis];
    for (const bool gyro : {true, false}) {
      const std::span<double> column = gyro ? columns.rate[axis] : columns.force[axis];
      const AxisNoise noise(gyro ? unit.gyro_noise : unit.accel_noise, interval, seed, fmt::format("{} {} on a motion", gyro ? "gyro" : "accel", axis));
      if (noise.slow()) noise.add_slow(column);
      noise.add_fast(0, column);
    }
  }
  decompensate(unit.model, {}, {}, columns);
  return r;
}

}  // namespace imulab
