#include "imulab/navigation/motion/track.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/navigation/motion/spline.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace imulab::motion {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d, Eigen::Vector4d;
using Eigen::Quaterniond;

void check(const Solution& rows) {
  if (rows.size() < 4) throw Error(fmt::format("track: {} row{}, expected at least 4", rows.size(), rows.size() == 1 ? "" : "s"));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NavigationState& s = rows.states[i];
    const auto refuse = [&](const std::string& what) { throw Error(fmt::format("track at {:.3f} s: {}", rows.time[i], what)); };
    if (!std::isfinite(rows.time[i] + s.latitude + s.longitude + s.height) || !s.q_nb.coeffs().allFinite()) refuse("expected finite numbers");
    if (i > 0 && !(rows.time[i] > rows.time[i - 1])) refuse("time does not ascend");
    try {
      integration::expect_latitude(s.latitude);
    } catch (const Error& e) {
      refuse(e.what());
    }
    const double turned = i > 0 ? s.q_nb.angularDistance(rows.states[i - 1].q_nb) : 0;
    if (turned >= 90 * unit::deg)
      refuse(fmt::format("the attitude is {:.0f} deg from the row before, expected less than 90: rows closer in time", turned / unit::deg));
  }
}

/// Meters east, north, up of the first row, one unit for all splines; longitude continues across 180 deg.
struct Splines {
  Splines(const Solution& rows, const TrackSmoothing& smoothing);
  Kinematics at(double t) const;

  double latitude, longitude, height;  // of the first row
  double east_radius, north_radius;    // m to a radian
  std::unique_ptr<Spline<3>> position;
  std::unique_ptr<Spline<4>> attitude;  // of the quaternion's components, not yet of length one
};

template <int N>
std::unique_ptr<Spline<N>> spline(const std::vector<double>& knots, const std::vector<typename Spline<N>::Point>& points, double mean_square) {
  return std::make_unique<Spline<N>>(mean_square > 0 ? Spline<N>::smoothing(knots, points, mean_square) : Spline<N>(knots, points));
}

Splines::Splines(const Solution& rows, const TrackSmoothing& smoothing) {
  const NavigationState& first = rows.states.front();
  const LocalEarth earth = local_earth(first.latitude, first.height);
  latitude = first.latitude, longitude = first.longitude, height = first.height;
  east_radius = earth.transverse_radius * earth.cos_latitude, north_radius = earth.meridian_radius;
  std::vector<double> knots;
  std::vector<Vector3d> points;
  std::vector<Vector4d> quaternions;
  double eastwards = 0;  // rad
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const NavigationState& s = rows.states[i];
    if (i > 0) eastwards += std::remainder(s.longitude - rows.states[i - 1].longitude, 2 * std::numbers::pi);
    knots.push_back(rows.time[i] - rows.time.front());
    points.emplace_back(eastwards * east_radius, (s.latitude - latitude) * north_radius, s.height - height);
    const Vector4d q = s.q_nb.normalized().coeffs();
    quaternions.push_back(i > 0 && q.dot(quaternions.back()) < 0 ? Vector4d(-q) : q);
  }
  position = spline<3>(knots, points, 3 * smoothing.position * smoothing.position);
  attitude = spline<4>(knots, quaternions, 0.75 * smoothing.attitude * smoothing.attitude);  // a rotation by d moves a quaternion by d/2
}

Kinematics Splines::at(double t) const {
  const auto p = position->at(t);
  const double latitude_rate = p.first.y() / north_radius, longitude_rate = p.first.x() / east_radius;
  Kinematics k;
  k.latitude = latitude + p.value.y() / north_radius;
  k.longitude = longitude + p.value.x() / east_radius;
  k.height = height + p.value.z();
  const LocalEarth earth = local_earth(k.latitude, k.height);
  const double s = earth.sin_latitude, c = earth.cos_latitude;
  k.velocity = {earth.transverse_radius * c * longitude_rate, earth.meridian_radius * latitude_rate, p.first.z()};
  // How the radii change with latitude: d(RN cos L) = -RM sin L, hence dRN = (RN - RM) tan L, and dRM = 3 RM dRN / RN.
  const double rn = earth.transverse_radius - k.height, rm = earth.meridian_radius - k.height, rm_slope = 3 * rm * (rn - rm) / rn * s / c;
  k.acceleration = {(k.velocity.z() * c - k.velocity.y() * s) * longitude_rate + earth.transverse_radius * c * p.second.x() / east_radius,
                    (rm_slope * latitude_rate + k.velocity.z()) * latitude_rate + earth.meridian_radius * p.second.y() / north_radius, p.second.z()};

  const auto q = attitude->at(t);
  const Quaterniond value(q.value), first(q.first);
  k.C_nb = value.normalized().toRotationMatrix();
  k.rate_nb_b = 2 * (value.conjugate() * first).vec() / q.value.squaredNorm();
  return k;
}

}  // namespace

Trajectory track(const Solution& rows, const TrackSmoothing& smoothing) {
  check(rows);
  const auto splines = std::make_shared<const Splines>(rows, smoothing);
  Trajectory out;
  out.breaks = splines->position->knots();
  out.duration = out.breaks.back();
  out.at = [splines](double t) { return splines->at(t); };
  return out;
}

}  // namespace imulab::motion
