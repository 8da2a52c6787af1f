// The innovations and residuals of an aided navigation by the kind of motion.
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/results/aided.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab {

std::vector<AidedMotion> innovations_by_motion(const AidedNavigation& n) {
  std::vector<AidedMotion> all;
  for (const char* kind : aided::motion_kinds) all.push_back({.kind = kind});
  if (n.track.size() < 2 || n.solution.time.empty()) return {};
  const double begin = n.solution.time.front(), step = (n.solution.time.back() - begin) / static_cast<double>(n.track.size() - 1);
  for (const AidedInnovation& i : n.innovations) {
    const double at = std::clamp((i.time - begin) / step, 0.0, static_cast<double>(n.track.size()) - 1.001);
    const auto k = static_cast<std::size_t>(at);
    AidedMotion& motion = all[aided::motion_kind(n.track[k], n.track[k + 1], step)];
    ++motion.innovations, motion.rms += i.sigmas * i.sigmas;
  }
  for (std::size_t kind = 0; kind < n.residuals.size(); ++kind) {
    const auto seen = [](const AidedResiduals& r) { return r.resolved >= 1 ? std::optional(r) : std::nullopt; };
    all[kind].gyro = seen(n.residuals[kind].gyro), all[kind].accel = seen(n.residuals[kind].accel);
  }
  std::erase_if(all, [](const AidedMotion& motion) { return motion.innovations == 0 && !motion.gyro && !motion.accel; });
  for (AidedMotion& motion : all)
    if (motion.innovations > 0) motion.rms = std::sqrt(motion.rms / static_cast<double>(motion.innovations));
  return all;
}

}  // namespace imulab
