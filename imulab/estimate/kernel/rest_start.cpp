#include "imulab/estimate/kernel/rest_start.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/coarse.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

namespace {

/// The declared unit is wrong if gravity reads as in another one. Offsets of uncalibrated accelerometers are below 20 % of g.
void check_accel_unit(const Recording& recording, const std::vector<Rest>& rests, double gravity) {
  if (recording.accel_unit == "count") return;
  std::vector<double> sizes;
  for (const Rest& rest : rests) sizes.push_back(rest.accel.norm());
  const double size = median(sizes);
  const auto near = [&](double expected) { return std::abs(size / expected - 1) < 0.2; };
  const std::string where =
      fmt::format("{}: accel: at rest the readings have the size {:.4g} with the declared unit {}", recording.name, size, recording.accel_unit);
  if (near(1.0)) throw Error(fmt::format("{}, expected {:.4g} m/s^2: they look like g", where, gravity));
  if (near(gravity * unit::g)) throw Error(fmt::format("{}, expected {:.4g} m/s^2: they look like m/s^2", where, gravity));
  if (!(size > 0.5 * gravity && size < 2 * gravity))
    throw Error(fmt::format("{}, expected about {:.4g} m/s^2: are the columns and the unit right?", where, gravity));
}

/// Do the rests change every axis's reading by a part of gravity? Else the quadric would be fitted to noise.
bool gravity_on_every_axis(const RestStart& start) {
  Vector3d low = start.rests.front().accel, high = low;
  for (const Rest& rest : start.rests) {
    low = low.cwiseMin(rest.accel);
    high = high.cwiseMax(rest.accel);
  }
  const Vector3d range = high - low;
  // Uncalibrated scales differ by less than a factor of 5, and a sample's noise is below a fiftieth of g.
  return range.minCoeff() > 0.2 * range.maxCoeff() && (range.array() > 20 * start.noise.accel.array()).all();
}

/// Why these rests do not determine everything, if there is a simple reason.
void warn_of_poor_rests(RestStart& start) {
  constexpr std::size_t enough = 9;  // as many as the accelerometers have coefficients
  const std::size_t n = start.rests.size();
  if (n < enough)
    start.findings.warn(
        fmt::format("only {} rest{}: at least {} in different directions are needed, about 20 are good", n, n == 1 ? "" : "s", enough));
  Matrix3d scatter = Matrix3d::Zero();
  for (const Rest& rest : start.rests) scatter += start.up(rest) * start.up(rest).transpose() / static_cast<double>(n);
  // A third in every direction is even; at a thirtieth every rest is within about 10 deg of one plane.
  if (n > 1 && Eigen::SelfAdjointEigenSolver<Matrix3d>(scatter).eigenvalues()[0] < 1.0 / 30)
    start.findings.warn("all rests have gravity near one axis or plane of the unit: turn it so that each of its axes points up and down");
}

/// Raw noise of a declared density, and a warning where the rests show another. A raw axis feeds its column of the matrix.
Vector3d declared_sigma(std::string_view triad, double density, const Matrix3d& raw_matrix, double interval_s, const Vector3d& measured,
                        Findings& findings) {
  const Vector3d declared = (density / std::sqrt(interval_s)) * raw_matrix.colwise().norm().transpose().cwiseInverse();
  check_declared_noise(findings, triad, measured.norm() / declared.norm());
  return declared;
}

/// The accelerometers of `start.model` and `start.prior`.
void start_accel(RestStart& start, const Recording& recording, double gravity) {
  std::vector<Vector3d> readings;
  for (const Rest& rest : start.rests) readings.push_back(start.accel(rest));
  const bool counts = recording.accel_unit == "count";
  auto coarse = gravity_on_every_axis(start) ? coarse_accel(readings, gravity) : std::nullopt;
  if (coarse && !counts && !near_identity(coarse->matrix)) coarse.reset();  // fitted to the noise of rests that are too similar
  if (!coarse && counts)
    throw Unsupported(
        fmt::format("{}: {} rests do not determine the accelerometers' offsets and scales: at least six rests with each axis up and down, or nine in "
                    "different directions, are needed",
                    recording.name, start.rests.size()));
  if (!coarse) {
    start.findings.note("the rests alone do not give offsets and scales: the fit started from the declared units");
    return;
  }
  start.model.accel.offset = coarse->offset;
  start.model.accel.matrix = coarse->matrix;
  if (!coarse->misalignment)
    start.findings.note("the linear solution does not determine the accelerometers' misalignments: the fit started from zero");
  if (!counts) return;
  start.prior.accel.offset = coarse->offset;
  start.prior.accel.matrix = coarse->matrix.diagonal().asDiagonal();
}

}  // namespace

Vector3d RestStart::mean_gyro() const {
  Vector3d mean = Vector3d::Zero();
  for (const Rest& rest : rests) mean += rest.gyro / static_cast<double>(rests.size());
  return mean;
}

RestStart start_from_rests(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, double gravity) {
  if (ranges.empty())
    throw Unsupported(fmt::format("{}: no rests: the unit was never still for long enough; hold it still in many orientations", recording.name));
  expect_alive(recording.accel, recording.name, "accel", "without it nothing can be calibrated");
  RestStart start;
  start.rests = summarize_rests(recording, ranges);
  check_accel_unit(recording, start.rests, gravity);
  start.scaling = choose_scaling(recording, start.rests);
  start.noise = measure_noise(recording, start.rests);
  for (SensorModel* model : {&start.model, &start.prior}) {
    model->accel.raw_unit = recording.accel_unit;
    model->gyro.raw_unit = recording.gyro_unit;
  }
  start_accel(start, recording, gravity);
  warn_of_poor_rests(start);
  if (imu.accel_noise_density)
    start.noise.accel = declared_sigma("accelerometers", *imu.accel_noise_density, to_raw(start.model, start.scaling).accel.matrix,
                                       recording.interval_s, start.noise.accel, start.findings);
  limit_noise(start);
  return start;
}

bool near_identity(const Matrix3d& matrix) { return (matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.2; }

void limit_noise(RestStart& start) {
  start.noise.accel = start.noise.accel.cwiseMax(1e-8 * start.scaling.accel_scale);
  start.noise.gyro = start.noise.gyro.cwiseMax(1e-8 * start.scaling.gyro_scale);
}

void use_declared_gyro_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu) {
  if (!imu.gyro_noise_density) return;
  start.noise.gyro = declared_sigma("gyros", *imu.gyro_noise_density, to_raw(start.model, start.scaling).gyro.matrix, recording.interval_s,
                                    start.noise.gyro, start.findings);
}

void keep_prior_of_others(RestStart& start, const std::vector<CoefficientIndex>& estimated, const std::vector<CoefficientIndex>& supplied) {
  for (const CoefficientIndex index : supplied) {
    if (contains(estimated, index)) continue;
    const Coefficient& c = coefficient(index);
    const bool counts = (c.triad == Triad::accel ? start.prior.accel : start.prior.gyro).raw_unit == "count";
    if (counts && (c.term == Term::offset || (c.term == Term::matrix && c.row == c.column)))
      throw TermsError(fmt::format("{} is not among the terms to estimate: readings in counts have no offset and scale to start from", c.name));
    set_coefficient(start.model, index, coefficient_value(start.prior, index));
  }
}

void expect_alive(const Columns3& triad, std::string_view file, std::string_view name, std::string_view consequence) {
  for (std::size_t j = 0; j < 3; ++j)
    if (!triad[j].empty() && std::all_of(triad[j].begin(), triad[j].end(), [&](double v) { return v == triad[j].front(); }))
      throw Unsupported(fmt::format("{}: {} {} reads {:g} in every sample: {}", file, name, "xyz"[j], triad[j].front(), consequence));
}

std::vector<CoefficientIndex> accel_coefficients() {
  std::vector<CoefficientIndex> indices = select_coefficients("accel.offset");
  for (const CoefficientIndex index : select_coefficients("accel.matrix"))
    if (coefficient(index).column <= coefficient(index).row) indices.push_back(index);
  return indices;
}

std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method) {
  if (wanted.empty()) return supplied;
  std::vector<CoefficientIndex> chosen;
  for (const CoefficientIndex index : supplied)
    if (contains(wanted, index)) chosen.push_back(index);
  for (const CoefficientIndex index : wanted) {
    const Coefficient& c = coefficient(index);
    const bool upper = c.triad == Triad::accel && c.term == Term::matrix && c.column > c.row;  // zero by the frame
    if (!upper && !contains(supplied, index)) throw TermsError(fmt::format("{} is not a coefficient that the method {} estimates", c.name, method));
  }
  if (chosen.empty())
    throw TermsError(fmt::format("the terms select no coefficient of the method {}; the accelerometer matrix is lower triangular", method));
  return chosen;
}

}  // namespace imulab::kernel
