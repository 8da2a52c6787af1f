#include "imulab/rig/mount_check.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::rig {

namespace {

/// Mean squared misfit of readings to a mount and a sense of rotation, in units of what uncalibrated sensors miss: a tenth of g and 5 %, 3 deg/s and
/// 5 %.
double misfit(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session, const Mount& mount, double sign) {
  double sum = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    Step step = points[k].step;
    step.mount = mount;
    step.rate *= sign;
    const Motion expected = steady_motion(step, session.site);
    sum += std::pow((measured[k].force - expected.force).norm() / (0.1 * unit::g + 0.05 * expected.force.norm()), 2) +
           std::pow((measured[k].rate - expected.rate).norm() / (3 * unit::deg + 0.05 * expected.rate.norm()), 2);
  }
  return sum / static_cast<double>(points.size());
}

std::vector<Mount> all_mounts() {
  std::vector<Mount> mounts;
  for (int u = 0; u < 3; ++u)
    for (int o = 0; o < 3; ++o)
      for (const int su : {1, -1})
        for (const int so : {1, -1})
          if (u != o) mounts.push_back({{u, su}, {o, so}});
  return mounts;
}

}  // namespace

void expect_declared_mount(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session) {
  constexpr double wrong = 25, right = 4;  // five sigma of what uncalibrated sensors miss, and two
  const MachinePoint& first = points.front();
  const Mount declared = mount_of(first.step);
  Mount best = declared;
  double best_sign = 1, least = misfit(points, measured, session, declared, 1);
  if (least < wrong) return;
  for (const Mount& mount : all_mounts())
    for (const double sign : {1.0, -1.0})
      if (const double m = misfit(points, measured, session, mount, sign); m < 0.999 * least) best = mount, best_sign = sign, least = m;
  if (least > right) return;
  const std::string where = fmt::format("{}: {} steps of {}, the first of them step {}", session.file, points.size(),
                                        session.recordings[first.recording].file, first.number);
  if (best == declared)
    throw Error(where + ": the gyros read the opposite of the declared rate about the axis that points up; expected a sign right-handed about up");
  throw Error(fmt::format("{}: mount {} (up, outward) is declared, but the readings are those of {}{}: was the IMU mounted otherwise?", where,
                          mount_name(declared), mount_name(best), best_sign < 0 ? " turned the other way" : ""));
}

}  // namespace imulab::rig
