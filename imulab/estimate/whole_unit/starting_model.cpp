#include "imulab/estimate/whole_unit/starting_model.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/recording/scaling.hpp"
#include "imulab/rig/machine_points.hpp"

#include <fmt/core.h>

#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Reference temperature: the mean of the points outside of the chamber, where most of them are; the middle of the range where there is a chamber
/// alone. A whole number.
double reference_temperature(const MachinePoints& points, std::size_t triad) {
  double sum = 0, n = 0;
  for (const MachinePoint& p : points.all)
    if (p.machine != RigKind::chamber) sum += p.temperature.segment<3>(static_cast<Index>(3 * triad)).mean(), n += 1;
  return std::round(n > 0 ? sum / n : 0.5 * (points.thermal[triad].low + points.thermal[triad].high));
}

/// Offset and matrix for readings less `center`, by least squares of what the machines did, without some points; absent where they did not move
/// each axis.
std::optional<TriadModel> linear_fit(const std::vector<MachinePoint>& points, const Range& without, const Session& session, const Vector6d& center,
                                     std::size_t triad) {
  const auto rows = static_cast<Index>(points.size() - without.size());
  MatrixXd x(rows, 4), y(rows, 3);
  Index row = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k >= without.begin && k < without.end) continue;
    const Motion m = steady_motion(points[k].step, session.site);
    x.row(row) << 1, (points[k].raw - center).segment<3>(static_cast<Index>(3 * triad)).transpose();
    y.row(row++) = triad == 0 ? m.force : m.rate;
  }
  if (rows < 4) return std::nullopt;
  const Eigen::RowVectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  constexpr double threshold = 1e-3;  // what temperature and noise leave of a direction that was not excited is below this
  const LeastSquares scaled = least_squares(x * scale.cwiseInverse().asDiagonal(), y, threshold);
  if (scaled.rank < 4) return std::nullopt;
  const MatrixXd fit = scale.cwiseInverse().asDiagonal() * scaled.x;
  TriadModel out;
  out.offset = fit.row(0), out.matrix = fit.bottomRows(3).transpose();
  return out;
}

}  // namespace

Vector6d reading_center(const MachinePoints& points) {
  Vector6d low = points.all.front().raw, high = low;
  for (const MachinePoint& p : points.all) low = low.cwiseMin(p.raw), high = high.cwiseMax(p.raw);
  const Vector6d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  return (middle.array().abs() > half.array().max(1000)).select(middle.array().round(), 0);  // counts
}

SensorModel starting_model(const MachinePoints& points, const Session& session, const Vector6d& center) {
  const RecordingSource& source = session.recordings.front();
  SensorModel start;
  for (std::size_t triad = 0; triad < 2; ++triad) {
    TriadModel& m = triad == 0 ? start.accel : start.gyro;
    const ThermalRange& thermal = points.thermal[triad];
    const bool counts = (triad == 0 ? source.accel : source.gyro).unit == "count";
    if (counts) {
      const auto fit = linear_fit(points.all, {}, session, center, triad);
      if (!fit)
        throw Unsupported(fmt::format("{}: the {} read counts, and the machines do not move each axis; their scales cannot be determined",
                                      session.file, triad == 0 ? "accelerometers" : "gyros"));
      m = *fit;
    }
    m.raw_unit = counts ? "count" : triad == 0 ? "m/s^2" : "rad/s";
    if (thermal.known) m.temperature = ThermalReading{thermal.unit, reference_temperature(points, triad), {thermal.low, thermal.high}};
  }
  return start;
}

void check_mounts(const MachinePoints& points, const Session& session, const SensorModel& start, const Vector6d& center) {
  const std::vector<MachinePoint>& all = points.all;
  const auto same_mounting = [](const MachinePoint& a, const MachinePoint& b) {
    return a.recording == b.recording && mount_of(a.step) == mount_of(b.step);
  };
  for (Range here; here.begin < all.size(); here.begin = here.end) {  // a mounting: points one after the other
    while (here.end < all.size() && same_mounting(all[here.begin], all[here.end])) ++here.end;
    TriadModel accel = start.accel, gyro = start.gyro;
    // Counts mean nothing without a fit; one of the other points is not bent by these.
    if (accel.raw_unit == "count") accel = linear_fit(all, here, session, center, 0).value_or(accel);
    if (gyro.raw_unit == "count") gyro = linear_fit(all, here, session, center, 1).value_or(gyro);
    std::vector<Motion> measured;
    for (std::size_t k = here.begin; k < here.end; ++k) {
      const Vector6d raw = all[k].raw - center;
      measured.push_back({linear_output(accel, raw.head<3>()), linear_output(gyro, raw.tail<3>())});
    }
    expect_declared_mount(std::span(all).subspan(here.begin, here.size()), measured, session);
  }
}

}  // namespace imulab::whole_unit
