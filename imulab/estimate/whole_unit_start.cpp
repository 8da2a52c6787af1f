#include "imulab/estimate/whole_unit_start.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/rig/machine.hpp"

#include <Eigen/QR>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

bool counts(const Session& session, std::size_t triad) {
  const RecordingSource& source = session.recordings.front();
  return (triad == 0 ? source.accel : source.gyro).unit == "count";
}

Place<double> place_of(const Session& session) {
  return {session.site.gravity(), session.site.latitude ? earth_rate_enu(*session.site.latitude) : Vector3d::Zero()};
}

SteadyMotion<double> motion_of(const Step& step, const Session& session) { return steady_motion<double>(step, {}, place_of(session)); }

/// Reference temperature: a whole number at which most of the points stand; the middle of the range where there is a chamber alone.
double reference_temperature(const WholeUnitPoints& points, const Session& session, std::size_t triad) {
  double sum = 0, n = 0;
  for (const WholeUnitPoint& p : points.points) {
    if (rig_of(session, session.recordings[p.recording])->kind == RigKind::chamber) continue;
    sum += p.temperature.segment<3>(static_cast<Index>(3 * triad)).mean(), n += 1;
  }
  return std::round(n > 0 ? sum / n : 0.5 * (points.thermal_range_low[triad] + points.thermal_range_high[triad]));
}

/// out = offset + matrix (raw - center), by least squares of the points that `used` says.
struct Linear {
  Vector3d offset;
  Matrix3d matrix;
};
template <class Used>
std::optional<Linear> linear_fit(const WholeUnitPoints& points, const Session& session, const Vector6d& center, std::size_t triad, const Used& used) {
  std::vector<const WholeUnitPoint*> chosen;
  for (const WholeUnitPoint& p : points.points)
    if (used(p)) chosen.push_back(&p);
  const auto n = static_cast<Index>(chosen.size());
  MatrixXd x(n, 4), y(n, 3);
  for (Index k = 0; k < n; ++k) {
    const WholeUnitPoint& p = *chosen[static_cast<std::size_t>(k)];
    const auto channels = static_cast<Index>(3 * triad);
    x.row(k) << 1, (p.raw - center).segment<3>(channels).transpose();
    const SteadyMotion<double> m = motion_of(p.step, session);
    y.row(k) = triad == 0 ? m.force : m.rate;
  }
  if (n < 4) return std::nullopt;
  const Eigen::RowVectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(x * scale.cwiseInverse().asDiagonal());
  qr.setThreshold(1e-3);  // what temperature and noise leave of a direction that was not excited is below this
  if (qr.rank() < 4) return std::nullopt;
  const MatrixXd fit = scale.cwiseInverse().asDiagonal() * MatrixXd(qr.solve(y));
  return Linear{fit.row(0), fit.bottomRows(3).transpose()};
}

}  // namespace

Vector6d reading_center(const WholeUnitPoints& points) {
  Vector6d low = points.points.front().raw, high = low;
  for (const WholeUnitPoint& p : points.points) low = low.cwiseMin(p.raw), high = high.cwiseMax(p.raw);
  const Vector6d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  Vector6d center;
  for (Index k = 0; k < 6; ++k) center[k] = std::abs(middle[k]) > half[k] && std::abs(middle[k]) > 1000 ? std::round(middle[k]) : 0;  // counts
  return center;
}

SensorModel start_model(const WholeUnitPoints& points, const Session& session, const Vector6d& center) {
  SensorModel start;
  for (std::size_t triad = 0; triad < 2; ++triad) {
    TriadModel& m = triad == 0 ? start.accel : start.gyro;
    m.raw_unit = counts(session, triad) ? "count" : triad == 0 ? "m/s^2" : "rad/s";
    if (points.thermal[triad])
      m.temperature = ThermalReading{points.thermal_unit[triad],
                                     reference_temperature(points, session, triad),
                                     {points.thermal_range_low[triad], points.thermal_range_high[triad]}};
    if (!counts(session, triad)) continue;
    const auto fit = linear_fit(points, session, center, triad, [](const WholeUnitPoint&) { return true; });
    if (!fit)
      throw Unsupported(fmt::format("{}: the {} read counts, and the machines do not move each of them: their scales cannot be found", session.file,
                                    triad == 0 ? "accelerometers" : "gyros"));
    m.offset = fit->offset, m.matrix = fit->matrix;
  }
  return start;
}

namespace {

/// Mean squared misfit of points in units of what uncalibrated sensors miss: a tenth of g and 5 %, 3 deg/s and 5 %.
struct Misfit {
  double force = 0, rate = 0;
  double both() const { return force + rate; }
};
Misfit misfit(const std::vector<std::pair<const WholeUnitPoint*, Motion>>& group, const Session& session, const Mount& mount, double sign) {
  Misfit m;
  for (const auto& [point, measured] : group) {
    Step step = point->step;
    step.mount = mount;
    step.rate *= sign;
    const SteadyMotion<double> expected = motion_of(step, session);
    const double n = static_cast<double>(group.size());
    m.force += std::pow((measured.force - expected.force).norm() / (0.1 * unit::g + 0.05 * expected.force.norm()), 2) / n;
    m.rate += std::pow((measured.rate - expected.rate).norm() / (3 * unit::deg + 0.05 * expected.rate.norm()), 2) / n;
  }
  return m;
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

void check_mounts(const WholeUnitPoints& points, const Session& session, const SensorModel& start, const Vector6d& center) {
  // A mounting: points one after the other.
  for (std::size_t begin = 0, end = 0; begin < points.points.size(); begin = end) {
    const WholeUnitPoint& first = points.points[begin];
    const std::pair key{first.recording, mount_of(first.step)};
    while (end < points.points.size() && points.points[end].recording == key.first && mount_of(points.points[end].step) == key.second) ++end;
    const auto here = [&, b = begin, e = end](const WholeUnitPoint& p) { return &p >= &points.points[b] && &p < points.points.data() + e; };
    const auto elsewhere = [&](const WholeUnitPoint& p) { return !here(p); };
    // Counts mean nothing without a fit; one of all other mounts is not bent by this one.
    Linear accel{Vector3d::Zero(), Matrix3d::Identity()}, gyro = accel;
    if (counts(session, 0)) accel = linear_fit(points, session, center, 0, elsewhere).value_or(Linear{start.accel.offset, start.accel.matrix});
    if (counts(session, 1)) gyro = linear_fit(points, session, center, 1, elsewhere).value_or(Linear{start.gyro.offset, start.gyro.matrix});
    std::vector<std::pair<const WholeUnitPoint*, Motion>> group;
    for (const WholeUnitPoint& p : points.points) {
      if (!here(p)) continue;
      const Vector6d raw = p.raw - center;
      group.emplace_back(&p, Motion{accel.offset + accel.matrix * raw.head<3>(), gyro.offset + gyro.matrix * raw.tail<3>()});
    }
    constexpr double wrong = 25, right = 4;  // five sigma of what uncalibrated sensors miss, and two
    const Misfit declared = misfit(group, session, key.second, 1);
    if (declared.both() < wrong) continue;
    Mount best = key.second;
    double best_sign = 1, least = declared.both();
    for (const Mount& mount : all_mounts())
      for (const double sign : {1.0, -1.0})
        if (const double m = misfit(group, session, mount, sign).both(); m < 0.999 * least) best = mount, best_sign = sign, least = m;
    if (least > right) continue;
    const std::string where =
        fmt::format("{}: {} steps of {}, the first of them step {}", session.file, group.size(), session.recordings[key.first].file, first.number);
    if (best == key.second)
      throw Error(
          fmt::format("{}: the gyros read the opposite of rate_dps about the axis that points up; expected its sign right-handed about up", where));
    throw Error(fmt::format("{}: mount {} (up, outward) is declared, but the readings are those of {}{}: was the unit mounted otherwise?", where,
                            mount_name(key.second), mount_name(best), best_sign < 0 ? " turned the other way" : ""));
  }
}

SensorModel uncentered(const SensorModel& model, const Vector6d& center) {
  SensorModel out = model;
  out.accel = of_shifted_readings(model.accel, center.head<3>());
  out.gyro = of_shifted_readings(model.gyro, center.tail<3>());
  return out;
}

}  // namespace imulab
