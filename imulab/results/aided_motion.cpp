// The innovations of an aided navigation by the kind of motion.
#include "imulab/results/aided.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

constexpr std::array<const char*, 4> motion_kinds{"at rest", "straight", "turning", "accelerating"};

/// The kind of motion from one state of the track to the next, as an index of `motion_kinds`.
std::size_t motion_kind(const NavigationState& a, const NavigationState& b, double seconds) {
  constexpr double slow_mps = 0.3, turning = 5 * unit::deg, accelerating_mps2 = 0.5;
  if (a.q_nb.angularDistance(b.q_nb) > turning * seconds) return 2;
  if ((b.velocity - a.velocity).norm() > accelerating_mps2 * seconds) return 3;
  return a.velocity.norm() < slow_mps ? 0 : 1;
}

}  // namespace

std::vector<AidedMotion> innovations_by_motion(const AidedNavigation& n) {
  std::vector<AidedMotion> all;
  for (const char* kind : motion_kinds) all.push_back({kind});
  if (n.track.size() < 2 || n.solution.time.empty()) return {};
  const double begin = n.solution.time.front(), step = (n.solution.time.back() - begin) / static_cast<double>(n.track.size() - 1);
  for (const AidedInnovation& i : n.innovations) {
    const double at = std::clamp((i.time - begin) / step, 0.0, static_cast<double>(n.track.size()) - 1.001);
    const auto k = static_cast<std::size_t>(at);
    AidedMotion& motion = all[motion_kind(n.track[k], n.track[k + 1], step)];
    ++motion.innovations, motion.rms += i.sigmas * i.sigmas;
  }
  std::erase_if(all, [](const AidedMotion& motion) { return motion.innovations == 0; });
  for (AidedMotion& motion : all) motion.rms = std::sqrt(motion.rms / static_cast<double>(motion.innovations));
  return all;
}

}  // namespace imulab
