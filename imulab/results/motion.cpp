#include "imulab/results/motion.hpp"

#include "imulab/core/units.hpp"
#include "imulab/navigation/integration/strapdown.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

double largest(const std::vector<double>& column) {
  double size = 0;
  for (const double value : column) size = std::max(size, std::abs(value));
  return size;
}

std::string largest_of(const Columns3& c, double unit) {
  return fmt::format("{:.4g}, {:.4g}, {:.4g}", largest(c[0]) / unit, largest(c[1]) / unit, largest(c[2]) / unit);
}

}  // namespace

std::string motion_table(const Recording& recording, const Solution& truth) {
  double distance = 0, fastest = 0, bank = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double speed = truth.states[i].velocity.norm();
    if (i > 0) distance += (truth.time[i] - truth.time[i - 1]) * (speed + truth.states[i - 1].velocity.norm()) / 2;
    fastest = std::max(fastest, speed);
    bank = std::max(bank, std::abs(euler_angles(truth.states[i].q_nb.toRotationMatrix()).roll));
  }
  std::string text = fmt::format("  distance       {:.6g} km, at most {:.5g} m/s\n", distance / 1000, fastest);
  text += fmt::format("  largest bank   {:.4g} deg\n", bank / unit::deg);
  if (recording.gyro_unit != "rad/s" || recording.accel_unit != "m/s^2") return text;  // counts
  text += fmt::format("  largest rate   {} deg/s about x, y, z\n", largest_of(recording.gyro, unit::deg));
  return text + fmt::format("  largest force  {} m/s^2 along x, y, z\n", largest_of(recording.accel, 1));
}

}  // namespace imulab
