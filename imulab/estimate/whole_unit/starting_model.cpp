#include "imulab/estimate/whole_unit/starting_model.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/gauge.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using PointList = std::vector<const Point*>;

PointList list_of(const Points& points) {
  PointList list;
  for (const Point& p : points.all) list.push_back(&p);
  return list;
}

bool counts(const Session& session, std::size_t triad) {
  const RecordingSource& source = session.recordings.front();
  return (triad == 0 ? source.accel : source.gyro).unit == "count";
}

Motion motion_of(const Step& step, const Session& session) {
  const SteadyMotion<double> m = steady_motion<double>(step, {}, place_of(session.site));
  return {m.force, m.rate};
}

/// Reference temperature: the mean of the points outside of the chamber, where most of them are; the middle of the range where there is a chamber
/// alone. A whole number.
double reference_temperature(const Points& points, const Session& session, std::size_t triad) {
  double sum = 0, n = 0;
  for (const Point& p : points.all) {
    if (session.rig_of(session.recordings[p.recording])->kind == RigKind::chamber) continue;
    sum += p.temperature.segment<3>(static_cast<Index>(3 * triad)).mean(), n += 1;
  }
  return std::round(n > 0 ? sum / n : 0.5 * (points.thermal[triad].low + points.thermal[triad].high));
}

/// out = offset + matrix (raw - center)
struct Linear {
  Vector3d offset = Vector3d::Zero();
  Matrix3d matrix = Matrix3d::Identity();
};

/// By least squares of what the machines did; absent where they did not move each axis.
std::optional<Linear> linear_fit(const PointList& points, const Session& session, const Vector6d& center, std::size_t triad) {
  MatrixXd x(std::ssize(points), 4), y(std::ssize(points), 3);
  for (Index k = 0; const Point* p : points) {
    const Motion m = motion_of(p->step, session);
    x.row(k) << 1, (p->raw - center).segment<3>(static_cast<Index>(3 * triad)).transpose();
    y.row(k++) = triad == 0 ? m.force : m.rate;
  }
  if (points.size() < 4) return std::nullopt;
  const Eigen::RowVectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  constexpr double threshold = 1e-3;  // what temperature and noise leave of a direction that was not excited is below this
  const LeastSquares scaled = least_squares(x * scale.cwiseInverse().asDiagonal(), y, threshold);
  if (scaled.rank < 4) return std::nullopt;
  const MatrixXd fit = scale.cwiseInverse().asDiagonal() * scaled.x;
  return Linear{fit.row(0), fit.bottomRows(3).transpose()};
}

/// What points measure and where they stand, of one mounting.
using Readings = std::vector<std::pair<const Point*, Motion>>;

/// Mean squared misfit of readings to a mount and a sense of rotation, in units of what uncalibrated sensors miss: a tenth of g and 5 %, 3 deg/s and
/// 5 %.
double misfit(const Readings& readings, const Session& session, const Mount& mount, double sign) {
  double sum = 0;
  for (const auto& [point, measured] : readings) {
    Step step = point->step;
    step.mount = mount;
    step.rate *= sign;
    const Motion expected = motion_of(step, session);
    sum += std::pow((measured.force - expected.force).norm() / (0.1 * unit::g + 0.05 * expected.force.norm()), 2) +
           std::pow((measured.rate - expected.rate).norm() / (3 * unit::deg + 0.05 * expected.rate.norm()), 2);
  }
  return sum / static_cast<double>(readings.size());
}

/// What the unit measured in `here`. Counts mean nothing without a fit; one of the points `elsewhere` is not bent by these.
Readings readings_of(const PointList& here, const PointList& elsewhere, const Session& session, const SensorModel& start, const Vector6d& center) {
  Linear accel, gyro;
  if (counts(session, 0)) accel = linear_fit(elsewhere, session, center, 0).value_or(Linear{start.accel.offset, start.accel.matrix});
  if (counts(session, 1)) gyro = linear_fit(elsewhere, session, center, 1).value_or(Linear{start.gyro.offset, start.gyro.matrix});
  Readings readings;
  for (const Point* p : here) {
    const Vector6d raw = p->raw - center;
    readings.emplace_back(p, Motion{accel.offset + accel.matrix * raw.head<3>(), gyro.offset + gyro.matrix * raw.tail<3>()});
  }
  return readings;
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

/// Throws Error where another mount or sense explains the readings and the declared one does not.
void check_mount(const Readings& readings, const Session& session) {
  constexpr double wrong = 25, right = 4;  // five sigma of what uncalibrated sensors miss, and two
  const Point& first = *readings.front().first;
  const Mount declared = mount_of(first.step);
  Mount best = declared;
  double best_sign = 1, least = misfit(readings, session, declared, 1);
  if (least < wrong) return;
  for (const Mount& mount : all_mounts())
    for (const double sign : {1.0, -1.0})
      if (const double m = misfit(readings, session, mount, sign); m < 0.999 * least) best = mount, best_sign = sign, least = m;
  if (least > right) return;
  const std::string where = fmt::format("{}: {} steps of {}, the first of them step {}", session.file, readings.size(),
                                        session.recordings[first.recording].file, first.number);
  if (best == declared)
    throw Error(where + ": the gyros read the opposite of the declared rate about the axis that points up; expected a sign right-handed about up");
  throw Error(fmt::format("{}: mount {} (up, outward) is declared, but the readings are those of {}{}: was the unit mounted otherwise?", where,
                          mount_name(declared), mount_name(best), best_sign < 0 ? " turned the other way" : ""));
}

}  // namespace

Vector6d reading_center(const Points& points) {
  Vector6d low = points.all.front().raw, high = low;
  for (const Point& p : points.all) low = low.cwiseMin(p.raw), high = high.cwiseMax(p.raw);
  const Vector6d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  Vector6d center;
  for (Index k = 0; k < 6; ++k) center[k] = std::abs(middle[k]) > half[k] && std::abs(middle[k]) > 1000 ? std::round(middle[k]) : 0;  // counts
  return center;
}

SensorModel starting_model(const Points& points, const Session& session, const Vector6d& center) {
  SensorModel start;
  for (std::size_t triad = 0; triad < 2; ++triad) {
    TriadModel& m = triad == 0 ? start.accel : start.gyro;
    const ThermalRange& thermal = points.thermal[triad];
    m.raw_unit = counts(session, triad) ? "count" : triad == 0 ? "m/s^2" : "rad/s";
    if (thermal.known) m.temperature = ThermalReading{thermal.unit, reference_temperature(points, session, triad), {thermal.low, thermal.high}};
    if (!counts(session, triad)) continue;
    const auto fit = linear_fit(list_of(points), session, center, triad);
    if (!fit)
      throw Unsupported(fmt::format("{}: the {} read counts, and the machines do not move each axis; their scales cannot be determined", session.file,
                                    triad == 0 ? "accelerometers" : "gyros"));
    m.offset = fit->offset, m.matrix = fit->matrix;
  }
  return start;
}

void check_mounts(const Points& points, const Session& session, const SensorModel& start, const Vector6d& center) {
  const PointList all = list_of(points);
  const auto same_mounting = [](const Point* a, const Point* b) { return a->recording == b->recording && mount_of(a->step) == mount_of(b->step); };
  for (auto begin = all.begin(); begin != all.end();) {  // a mounting: points one after the other
    const auto end = std::find_if(begin, all.end(), [&](const Point* p) { return !same_mounting(*begin, p); });
    PointList elsewhere(all.begin(), begin);
    elsewhere.insert(elsewhere.end(), end, all.end());
    check_mount(readings_of({begin, end}, elsewhere, session, start, center), session);
    begin = end;
  }
}

SensorModel uncentered(const SensorModel& model, const Vector6d& center) {
  SensorModel out = model;
  out.accel = of_shifted_readings(model.accel, center.head<3>());
  out.gyro = of_shifted_readings(model.gyro, center.tail<3>());
  return out;
}

}  // namespace imulab::whole_unit
