#include "imulab/navigation/aided/aid_motion.hpp"

#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/rests.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::aided {

bool shows_motion(const Aid& aid, std::size_t row, std::optional<Eigen::Vector3d>& first) {
  constexpr double sigmas = 6, slow = 0.3, near = 3;  // m/s, m: tolerances added to the sigmas
  const AidRecord& r = aid.record;
  if (aid.kind == AidKind::wheels) return std::abs(r.value[row]) > sigmas * value_sigma(aid, row) + slow;
  if (aid.kind != AidKind::gnss) return false;
  if (!r.velocity.empty() && r.velocity[row].norm() > sigmas * velocity_sigma(aid, row).norm() + slow) return true;
  if (r.position.empty() || !r.position[row].allFinite()) return false;
  const Vector3d& here = r.position[row];
  if (!first) first = here;
  const LocalEarth earth = local_earth(here.x(), here.z());
  const double east = (here.y() - first->y()) * earth.transverse_radius * earth.cos_latitude, north = (here.x() - first->x()) * earth.meridian_radius;
  return std::hypot(east, north) > 2 * sigmas * position_sigma(aid, row).head<2>().norm() + near;
}

bool any_moves(const std::vector<Aid>& aids, const std::string& recording, double begin, double end) {
  return std::ranges::any_of(aids, [&](const Aid& aid) {
    if (!aid.recording.empty() && aid.recording != recording) return false;
    std::optional<Eigen::Vector3d> first;
    for (std::size_t row = 0; row < aid.record.time.size(); ++row)
      if (const double t = 1e-9 * static_cast<double>(aid.record.time[row]); t >= begin && t <= end && shows_motion(aid, row, first)) return true;
    return false;
  });
}

std::vector<Range> rests_in_place(const Recording& recording, const Session& session) {
  std::vector<Range> rests = rests_of(recording, session).ranges;
  std::erase_if(rests,
                [&](const Range& r) { return any_moves(session.aids, recording.name, recording.time_s(r.begin), recording.time_s(r.end - 1)); });
  return rests;
}

}  // namespace imulab::aided
