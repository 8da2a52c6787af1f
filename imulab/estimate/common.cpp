#include "imulab/estimate/common.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/coarse.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

/// The declared unit is wrong if gravity reads as in another one. Offsets of uncalibrated accelerometers are below 20 % of g.
void check_accel_unit(const Recording& recording, const std::vector<Rest>& rests, double gravity) {
  if (recording.accel_unit == "count") return;
  std::vector<double> sizes;
  for (const Rest& rest : rests) sizes.push_back(rest.accel.norm());
  const double size = median(sizes);
  const auto near = [&](double expected) { return std::abs(size / expected - 1) < 0.2; };
  if (near(1.0))
    throw Error(fmt::format(
        "{}: accel: at rest the readings have the size {:.4g} where {} is declared: they look like g; declare unit = \"g\" (expected {:.4g} m/s^2)",
        recording.name, size, recording.accel_unit, gravity));
  if (near(gravity * unit::g))
    throw Error(fmt::format(
        "{}: accel: at rest the readings have the size {:.4g} m/s^2 with the declared unit {}: they look like m/s^2; declare unit = \"m/s^2\"",
        recording.name, size, recording.accel_unit));
  if (!(size > 0.5 * gravity && size < 2 * gravity))
    throw Error(fmt::format("{}: accel: at rest the readings have the size {:.4g} m/s^2, expected about {:.4g}: are the columns and the unit right?",
                            recording.name, size, gravity));
}

/// Do the rests move every axis's reading by a part of gravity? Else the quadric would be fitted to noise.
bool every_axis_feels_gravity(const Start& start) {
  Vector3d low = start.rests.front().accel, high = low;
  for (const Rest& rest : start.rests) {
    low = low.cwiseMin(rest.accel);
    high = high.cwiseMax(rest.accel);
  }
  const Vector3d range = high - low;
  // Uncalibrated scales differ by less than a factor of 5, and a sample's noise is below a fiftieth of g.
  return range.minCoeff() > 0.2 * range.maxCoeff() && (range.array() > 20 * start.noise.accel.array()).all();
}

/// What keeps these rests from telling everything, where it can be seen at a glance.
void warn_of_poor_rests(Start& start) {
  constexpr std::size_t enough = 9;  // as many as the accelerometers have coefficients
  if (start.rests.size() < enough)
    start.warnings.push_back(fmt::format("only {} rest{}: at least {} in different directions are needed, about 20 are good", start.rests.size(),
                                         start.rests.size() == 1 ? "" : "s", enough));
  Matrix3d scatter = Matrix3d::Zero();
  for (const Rest& rest : start.rests) {
    const TriadModel& accel = start.scaled_model.accel;
    const Vector3d up =
        (accel.offset + accel.matrix * (rest.accel - start.scaling.accel_center).cwiseQuotient(start.scaling.accel_scale)).normalized();
    scatter += up * up.transpose() / static_cast<double>(start.rests.size());
  }
  // A third in every direction is even; at a thirtieth every rest is within about 10 deg of one plane.
  if (start.rests.size() > 1 && Eigen::SelfAdjointEigenSolver<Matrix3d>(scatter).eigenvalues()[0] < 1.0 / 30)
    start.warnings.push_back("the rests hold gravity near one axis or plane of the unit: turn it so that each of its axes points up and down");
}

/// Raw noise of a declared density, and a warning where the rests show another. A raw axis feeds its column of the matrix.
Vector3d declared_sigma(const char* triad, double density, const Matrix3d& raw_matrix, double interval_s, const Vector3d& measured,
                        std::vector<std::string>& warnings) {
  const Vector3d declared = (density / std::sqrt(interval_s)) * raw_matrix.colwise().norm().transpose().cwiseInverse();
  const double ratio = measured.norm() / declared.norm();
  if (ratio > 1.5 || ratio < 1 / 1.5)
    warnings.push_back(fmt::format("the {} noise at rest is {:.2g} times the declared density; the declared one sets the weights", triad, ratio));
  return declared;
}

}  // namespace

std::vector<int> accel_coefficients() {
  std::vector<int> indices;
  for (const Coefficient& c : coefficient_table())
    if (c.triad == Triad::accel && (c.term == Term::offset || (c.term == Term::matrix && c.column <= c.row)))
      indices.push_back(coefficient_index(c.triad, c.term, c.row, c.column));
  return indices;
}

std::vector<int> choose_terms(const std::vector<int>& wanted, const std::vector<int>& supplied, std::string_view method) {
  std::vector<int> chosen;
  for (const int index : supplied)
    if (std::find(wanted.begin(), wanted.end(), index) != wanted.end()) chosen.push_back(index);
  for (const int index : wanted) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    const bool upper = c.triad == Triad::accel && c.term == Term::matrix && c.column > c.row;  // zero by the frame
    if (!upper && std::find(supplied.begin(), supplied.end(), index) == supplied.end())
      throw Error(fmt::format("--terms: {} is not a coefficient that the method {} estimates", c.name, method));
  }
  if (chosen.empty()) throw Error(fmt::format("--terms: nothing of it is estimated by the method {}; the accelerometer matrix is lower triangular", method));
  return chosen;
}

void expect_alive(const Columns3& triad, std::string_view file, std::string_view name, std::string_view consequence) {
  for (std::size_t j = 0; j < 3; ++j)
    if (!triad[j].empty() && std::all_of(triad[j].begin(), triad[j].end(), [&](double v) { return v == triad[j].front(); }))
      throw Unsupported(fmt::format("{}: {} {} reads {:g} in every sample: {}", file, name, "xyz"[j], triad[j].front(), consequence));
}

Start start_from_rests(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, double gravity) {
  if (ranges.empty())
    throw Unsupported(
        fmt::format("{}: no rests: the unit was never still for long enough; hold it still in many different orientations", recording.name));
  expect_alive(recording.accel, recording.name, "accel", "without it nothing can be calibrated");
  Start start;
  start.rests = summarize_rests(recording, ranges);
  check_accel_unit(recording, start.rests, gravity);
  start.scaling = choose_scaling(recording, start.rests);
  start.noise = measure_noise(recording, start.rests);

  start.scaled_model.accel.raw_unit = recording.accel_unit;
  start.scaled_model.gyro.raw_unit = recording.gyro_unit;
  std::vector<Vector3d> readings;
  for (const Rest& rest : start.rests) readings.push_back((rest.accel - start.scaling.accel_center).cwiseQuotient(start.scaling.accel_scale));
  const bool counts = recording.accel_unit == "count";
  auto coarse = every_axis_feels_gravity(start) ? coarse_accel(readings, gravity) : std::nullopt;
  if (coarse && !counts && !near_identity(coarse->matrix)) coarse.reset();  // fitted to the noise of rests that are too alike
  if (coarse) {
    start.scaled_model.accel.offset = coarse->offset;
    start.scaled_model.accel.matrix = coarse->matrix;
    if (!coarse->misalignment)
      start.notes.push_back("the rests leave the accelerometers' misalignments open to the linear solution: it started from zero");
  } else if (!counts) {
    start.notes.push_back("the rests do not give offsets and scales by themselves: the fit started from the declared units");
  } else {
    throw Unsupported(
        fmt::format("{}: {} rests do not determine the accelerometers' offsets and scales: at least six rests with each axis up and down, or nine in "
                    "different directions, are needed",
                    recording.name, ranges.size()));
  }

  start.prior.mean.accel.raw_unit = recording.accel_unit;
  start.prior.mean.gyro.raw_unit = recording.gyro_unit;
  if (counts) {
    start.prior.mean.accel.offset = start.scaled_model.accel.offset;
    start.prior.mean.accel.matrix = start.scaled_model.accel.matrix.diagonal().asDiagonal();
  }
  warn_of_poor_rests(start);
  const SensorModel raw = to_raw(start.scaled_model, start.scaling);
  if (imu.accel_noise_density)
    start.noise.accel = declared_sigma("accelerometers'", *imu.accel_noise_density, raw.accel.matrix, recording.interval_s, start.noise.accel, start.warnings);
  // A stuck or coarsely quantised axis shows no noise; a hundred-millionth of the scale keeps the weights finite.
  start.noise.accel = start.noise.accel.cwiseMax(1e-8 * start.scaling.accel_scale);
  start.noise.gyro = start.noise.gyro.cwiseMax(1e-8 * start.scaling.gyro_scale);
  return start;
}

bool near_identity(const Matrix3d& matrix) { return (matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.2; }

void use_declared_gyro_noise(Start& start, const Recording& recording, const ImuDeclaration& imu) {
  if (!imu.gyro_noise_density) return;
  const SensorModel raw = to_raw(start.scaled_model, start.scaling);
  start.noise.gyro = declared_sigma("gyros'", *imu.gyro_noise_density, raw.gyro.matrix, recording.interval_s, start.noise.gyro, start.warnings);
}

void keep_start_of_others(Start& start, const std::vector<int>& indices, const std::vector<int>& supplied) {
  for (const int index : supplied) {
    if (std::find(indices.begin(), indices.end(), index) != indices.end()) continue;
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    const bool counts = (c.triad == Triad::accel ? start.prior.mean.accel : start.prior.mean.gyro).raw_unit == "count";
    if (counts && (c.term == Term::offset || (c.term == Term::matrix && c.row == c.column)))
      throw Error(fmt::format("--terms: {} is missing: readings in counts have no offset and scale to start from", c.name));
    set_coefficient(start.scaled_model, index, coefficient_value(start.prior.mean, index));
  }
}

namespace {

/// A triad's scale further from its prior than an IMU can be: the rests are too alike, and the fit has left along what they do not determine.
const Coefficient* runaway(const Fit& fit, const SensorModel& scaled_model, const Prior& prior, const std::vector<int>& indices, Triad triad) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(indices[i])];
    if (c.triad != triad || c.term != Term::matrix || c.row != c.column || !fit.adjustment.determined[i]) continue;
    const double moved = coefficient_value(scaled_model, indices[i]) - coefficient_value(prior.mean, indices[i]);
    if (!(std::abs(moved) <= prior.sigma(c, 1.0))) return &c;
  }
  return nullptr;
}

}  // namespace

Calibration finish(std::string_view method, const Start& start, Fit fit, const SensorModel& scaled_model, const std::vector<int>& indices,
                   const ImuDeclaration& imu, const Site& site) {
  Calibration calibration;
  calibration.imu = imu.name;
  calibration.method = method;
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Coefficient* c = runaway(fit, scaled_model, start.prior, indices, triad);
    if (!c) continue;
    calibration.quality.warnings.push_back(fmt::format("{} came out further off than any IMU is: the rests are too alike, and {} is kept", c->name,
                                                       triad == Triad::accel ? "nothing of the fit" : "nothing of the gyros'"));
    for (std::size_t i = 0; i < indices.size(); ++i)
      if (triad == Triad::accel || coefficient_table()[static_cast<std::size_t>(indices[i])].triad == triad) fit.adjustment.determined[i] = 0;
  }
  SensorModel scaled = scaled_model;
  for (std::size_t i = 0; i < indices.size(); ++i)  // to the last bit: the fit held them to a millionth of their prior
    if (!fit.adjustment.determined[i]) set_coefficient(scaled, indices[i], coefficient_value(start.prior.mean, indices[i]));
  calibration.model = to_raw(scaled, start.scaling);
  const auto n = static_cast<Eigen::Index>(indices.size());
  Eigen::MatrixXd covariance = covariance_to_raw(fit.adjustment.covariance.topLeftCorner(n, n), indices, start.scaling);

  // g is the scale: accelerations are proportional to it, g-sensitivity inversely.
  const double relative = site.gravity_sigma() / site.gravity();
  Eigen::VectorXd with_g = Eigen::VectorXd::Zero(n);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < n; ++i) {
    const int index = indices[static_cast<std::size_t>(i)];
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    if (c.triad == Triad::accel) with_g[i] = coefficient_value(calibration.model, index);
    if (c.term == Term::g_sensitivity) with_g[i] = -coefficient_value(calibration.model, index);
    if (fit.adjustment.determined[static_cast<std::size_t>(i)]) {
      kept.push_back(i);
      calibration.estimated.push_back(index);
    } else {
      calibration.quality.unobservable.emplace_back(c.name);
    }
  }
  covariance += relative * relative * with_g * with_g.transpose();
  calibration.covariance = covariance(kept, kept);

  Quality& quality = calibration.quality;
  quality.condition = fit.adjustment.condition;
  quality.notes = start.notes;
  quality.warnings.insert(quality.warnings.begin(), start.warnings.begin(), start.warnings.end());
  quality.sources.push_back(
      {"gravity", relative, fmt::format("g is known to {:.3g} ppm: this much is common to all three accelerometer scales", 1e6 * relative)});
  return calibration;
}

std::vector<std::string> common_doubts(const Calibration& calibration, const Fit& fit, const Site& site, std::size_t dropped, std::size_t all) {
  std::vector<std::string> doubts;
  if (!fit.converged) doubts.push_back("the fit did not converge");
  for (const std::string& doubt : common_doubts(calibration, site, dropped, all)) doubts.push_back(doubt);
  // A spread from ten residuals is good to a quarter; from fewer the uncertainties may be far too small.
  if (const double degrees = spread_degrees(fit); degrees < 10)
    doubts.push_back(fmt::format("the spread beyond the sample noise rests on {:.0f} degrees of freedom", degrees));
  return doubts;
}

std::vector<std::string> common_doubts(const Calibration& calibration, const Site& site, std::size_t dropped, std::size_t all) {
  std::vector<std::string> doubts;
  const Quality& quality = calibration.quality;
  if (!quality.unobservable.empty()) doubts.push_back(fmt::format("{} coefficients are not determined by the data", quality.unobservable.size()));
  // Below about six degrees of freedom the residuals can hardly contradict the model or the noise.
  if (quality.degrees_of_freedom < 6)
    doubts.push_back(fmt::format("only {} degrees of freedom remain to check the result", quality.degrees_of_freedom));
  if (5 * dropped > all) doubts.push_back(fmt::format("{} of {} rests and rotations were dropped as outliers", dropped, all));
  // Real sensors in a hand show 3 to 10; five times the noise is another sensor, another motion or another place than was declared.
  if (quality.chi2_per_dof > 25) doubts.push_back(fmt::format("the residuals are {:.0f} times what the noise explains", std::sqrt(quality.chi2_per_dof)));
  if (quality.chi2_per_dof < 0.3) doubts.push_back("the residuals are far smaller than the declared noise: the uncertainties are too large");
  for (const int index : calibration.estimated) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    if (c.term != Term::matrix || c.row != c.column) continue;
    const auto row = (c.triad == Triad::accel ? calibration.model.accel : calibration.model.gyro).matrix.row(c.row);
    const double relative = *standard_uncertainty(calibration, index) / row.norm();
    if (relative > 0.01) doubts.push_back(fmt::format("{} is uncertain by {:.2g} %", c.name, 100 * relative));  // uncalibrated: a few per cent
  }
  if (site.given_gravity) {
    // Normal gravity is true to 0.005 m/s^2 at a known height and 0.03 m/s^2 up to 10 km; on Earth's surface g is between 9.76 and 9.84.
    const double expected = site.latitude ? normal_gravity(*site.latitude, site.height.value_or(0)) : 9.80;
    if (std::abs(*site.given_gravity - expected) > 0.05)
      doubts.push_back(fmt::format("gravity_mps2 = {:g} is not that of {} ({:.3f})", *site.given_gravity, site.latitude ? "the given latitude" : "the Earth's surface", expected));
  }
  return doubts;
}

std::string spread_note(std::string_view what, double spread, std::string_view unit_name) {
  return fmt::format("{} spread by {:.3g} {} (1 sigma) more than the sample noise explains; counted in the uncertainties", what, spread, unit_name);
}

void conclude(Calibration& calibration, const std::vector<std::string>& doubts) {
  std::string& verdict = calibration.quality.verdict;
  verdict = doubts.empty() ? "good" : "doubtful, because ";
  for (std::size_t i = 0; i < doubts.size(); ++i) verdict += (i > 0 ? "; " : "") + doubts[i];
}

}  // namespace imulab
