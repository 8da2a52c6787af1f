#include "imulab/estimate/extrinsics/body_fit.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::extrinsics {
namespace {

double squared(double x) { return x * x; }

/// The first column of a matrix that a coefficient is an element of; -1: of none.
int first_column(const Coefficient& c) {
  return c.term == Term::g_sensitivity ? +g_sensitivity : c.term != Term::matrix ? -1 : c.triad == Triad::gyro ? +gyro_matrix : +accel_matrix;
}
int offset_column(const Coefficient& c) { return (c.triad == Triad::gyro ? gyro_offset : accel_offset) + c.row; }

/// Of the errors before the motion. Offsets are any, or those of the calibration or the grade if they are `known`.
Prior covariance_of_errors(const BodyImu& imu, bool known) {
  const Grade& sizes = grade(imu.grade);
  Prior p = Prior::Zero();
  constexpr double fixed = 1e-7, any_gyro_offset = 0.2, any_accel_offset = 1;  // relative, rad/s, m/s^2
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int element = 3 * i + j;
      p(gyro_matrix + element, gyro_matrix + element) = squared(i == j ? sizes.gyro_scale : sizes.gyro_misalignment);
      p(g_sensitivity + element, g_sensitivity + element) = squared(std::max(sizes.g_sensitivity, sizes.terms.g_sensitivity));
      p(accel_matrix + element, accel_matrix + element) = squared(i == j ? sizes.accel_scale : i > j ? sizes.accel_misalignment : fixed);
    }
  const double of_gyros = known ? squared(sizes.gyro_bias) : squared(any_gyro_offset),
               of_accels = known ? squared(sizes.accel_bias) : squared(any_accel_offset);
  for (int i = 0; i < 3; ++i) p(gyro_offset + i, gyro_offset + i) = of_gyros, p(accel_offset + i, accel_offset + i) = of_accels;
  p.diagonal().array() += squared(fixed);  // a size may be zero
  if (!imu.calibration) return p;
  const Calibration& c = *imu.calibration;
  const Eigen::MatrixXd to_errors = errors_by_coefficients(c, known);
  Prior kept = Prior::Identity();
  for (const CoefficientIndex index : c.estimated) {
    const Coefficient& coefficient = imulab::coefficient(index);
    const int first = first_column(coefficient);
    if (known && coefficient.term == Term::offset) kept.diagonal()[offset_column(coefficient)] = 0;
    if (first >= 0) kept.diagonal().segment<3>(first + 3 * coefficient.row).setZero();
  }
  p = kept * p * kept;
  p += to_errors * c.covariance * to_errors.transpose();
  for (int i = 0; i < 3 && known; ++i) {
    p(gyro_offset + i, gyro_offset + i) += squared(c.turn_on ? c.turn_on->gyro : sizes.gyro_noise.turn_on.value) + squared(sizes.gyro_noise.B);
    p(accel_offset + i, accel_offset + i) += squared(c.turn_on ? c.turn_on->accel : sizes.accel_noise.turn_on.value) + squared(sizes.accel_noise.B);
  }
  p.diagonal().array() += squared(fixed);
  return p;
}

std::vector<Span> common_spans(const std::vector<Stream>& streams, const std::vector<ImuState>& states, double most_used_s, Span& whole) {
  whole = {-HUGE_VAL, HUGE_VAL};
  for (std::size_t k = 0; k < streams.size(); ++k) {
    whole.begin = std::max(whole.begin, streams[k].samples.front().begin - states[k].offset);
    whole.end = std::min(whole.end, streams[k].samples.back().end - states[k].offset);
  }
  constexpr double margin = 0.1;  // offsets change by less in the fit
  whole.begin += margin, whole.end -= margin;
  if (whole.length() < 5)
    throw Unsupported(fmt::format("the recordings have {:.1f} s in common; expected 5 s or more of one motion", std::max(0., whole.length())));
  return spans_with_motion(streams.front(), whole, most_used_s);
}

double variance_of(const std::vector<double>& list) {
  double sum = 0, squares = 0;
  for (const double x : list) sum += x, squares += x * x;
  const double n = static_cast<double>(list.size());
  return squares / n - squared(sum / n);
}

void expect_different_names(const std::vector<BodyImu>& imus) {
  if (imus.size() < 2) throw Error(fmt::format("one IMU ({}); expected two or more on one body", imus.empty() ? "none" : imus.front().name));
  for (std::size_t i = 0; i < imus.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (imus[i].name == imus[j].name) throw Error(fmt::format("{}: two IMUs have this name; expected different ones", imus[i].name));
}

std::string along(const Vector3d& direction) {
  const Eigen::Index largest = [&] {
    Eigen::Index i = 0;
    direction.cwiseAbs().maxCoeff(&i);
    return i;
  }();
  const Vector3d v = direction[largest] < 0 ? Vector3d(-direction) : direction;
  if (v[largest] > 0.97) return fmt::format("{}", "xyz"[largest]);
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", v[0] + 0., v[1] + 0., v[2] + 0.);
}

}  // namespace

Eigen::MatrixXd errors_by_coefficients(const Calibration& c, bool offsets) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(own_columns, std::ssize(c.estimated));
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const Coefficient& coefficient = imulab::coefficient(c.estimated[k]);
    const int first = first_column(coefficient), offset_row = offset_column(coefficient);
    if (offsets && coefficient.term == Term::offset) out(offset_row, at) = 1;
    if (first < 0) continue;
    const TriadModel& triad = triad_model(c.model, coefficient.triad);
    Matrix3d back = Matrix3d::Identity();
    if (coefficient.term == Term::matrix) {
      if (const auto inverse = regular_inverse(triad.matrix)) back = *inverse;
      if (offsets) out(offset_row, at) = -(back * triad.offset)[coefficient.column];
    }
    for (int j = 0; j < 3; ++j) out(first + 3 * coefficient.row + j, at) = back(coefficient.column, j);
  }
  return out;
}

std::vector<std::string> not_shown(const Mounting& m) {
  constexpr double most_arm = 0.1, most_turn = 10 * unit::deg, most_offset = 0.1;  // m, rad, s
  std::vector<std::string> out;
  const auto directions = [&](int first, double most, std::string_view what) {
    const SymmetricEigen e = symmetric_eigen(m.covariance.block<3, 3>(first, first));
    for (int i = 0; i < 3; ++i)
      if (std::sqrt(e.values[i]) > most) out.push_back(fmt::format("{} {}", what, along(e.vectors.col(i))));
  };
  directions(turn, most_turn, "rotation about");
  directions(arm, most_arm, "lever arm along");
  if (m.uncertainty(offset) > most_offset) out.emplace_back("clock offset");
  return out;
}

Mounting BodyFit::mounting(std::size_t k, const std::vector<BodyImu>& imus) const {
  const ImuState& state = fit->states()[k];
  Mounting m{.from = imus.front().name,
             .to = imus[k].name,
             .rotation = state.rotation,
             .lever_arm = state.lever_arm,
             .clock_offset = state.offset,
             .clock_drift = state.drift,
             .accel_delay = state.delay,
             .epoch = fit->epoch()};
  m.covariance = constants.covariance.block<mount_columns, mount_columns>(MotionFit::mount_column(k), MotionFit::mount_column(k));
  m.not_shown = not_shown(m);
  return m;
}

void BodyFit::judge_agreement(std::size_t k, const std::vector<BodyImu>& imus, const BodyRates& rates, Findings& findings) const {
  double motion = 0;  // variance of the rates, mean of the axes
  for (const std::vector<double>& axis : rates.second) motion += variance_of(axis) / 3;
  const double unlike = std::hypot(fit->states()[0].gyro_sigma, fit->states()[k].gyro_sigma) / std::sqrt(motion);
  constexpr double most_unlike = 0.2;
  if (unlike > most_unlike || agreement[k - 1] < 1 - most_unlike)
    findings.add<Code::rates_unlike>(Subject{imus.front().name}, imus[k].name, 100 * std::max(unlike, std::sqrt(std::max(0., 1 - agreement[k - 1]))));
}

void BodyFit::judge_scatter(const Mounting& m, Eigen::Index first, Eigen::Index size, Findings& findings) const {
  kernel::add_scatter(findings, fmt::format("seconds of {} and {}", m.from, m.to), constants.enlargement.segment(first, size).maxCoeff());
}

void BodyFit::judge_mounting(const Mounting& m, Findings& findings) {
  if (!m.not_shown.empty()) findings.add<Code::mounting_not_shown>(Subject{m.to}, fmt::format("{}", fmt::join(m.not_shown, ", ")));
  const double u = m.uncertainty(delay);
  constexpr double certain = 4, least_delay_s = 2e-4;  // sigmas; a delay that matters to no user
  if (std::abs(m.accel_delay) > certain * u && std::abs(m.accel_delay) > least_delay_s)
    findings.add<Code::accels_late>(Subject{m.to}, 1e3 * m.accel_delay, m.from, 1e3 * u);
}

namespace {

/// The step that is left, of the IMUs whose mounting the motion shows: the others' has no end.
struct StepLeft {
  Eigen::VectorXd step;
  double change = 0;  ///< in standard uncertainties
  bool all_shown = true;
};
StepLeft step_left(const std::vector<BodyImu>& imus, const BodyFit& body) {
  const ConstantsCovariance& constants = body.constants;
  StepLeft out{.step = Eigen::VectorXd::Zero(constants.step.size())};
  for (std::size_t k = 1; k < imus.size(); ++k) {
    const Eigen::Index first = MotionFit::mount_column(k) - own_columns, size = +own_columns + +mount_columns;
    const bool shown = not_shown(body.mounting(k, imus)).empty();
    if (shown) out.step.segment(first, size) = constants.step.segment(first, size);
    out.all_shown = out.all_shown && shown;
  }
  out.change = (out.step.array() / constants.covariance.diagonal().array().sqrt()).abs().maxCoeff();
  return out;
}

/// Noise of the motion makes the squares seem steeper than they are, so the fit's steps end too early: these take the curvature without it.
void finish_fit(const std::vector<BodyImu>& imus, BodyFit& body) {
  constexpr int most_steps = 5;
  constexpr double most_change = 0.5, most_unshown_change = 0.2;
  StepLeft left = step_left(imus, body);
  for (int i = 0; i < most_steps && left.change > most_change; ++i) {
    body.fit->move(left.step / std::max(1., left.change));
    body.fit->step(false), body.fit->step(true);
    body.constants = body.fit->covariance();
    left = step_left(imus, body);
  }
  body.converged = left.change <= most_change && (left.all_shown || body.converged || body.constants.change <= most_unshown_change);
}

}  // namespace

BodyFit fit_body(const std::vector<BodyImu>& imus, const FitOptions& options, Findings& findings) {
  expect_different_names(imus);
  BodyFit out{.fit = {}, .covariance_before = {}, .constants = {}, .residuals = {}, .agreement = {}};
  std::vector<Stream> streams;
  std::vector<ImuState> states(imus.size());
  std::vector<Prior> priors;
  double tilt_sigma = 0;  // of the first IMU's gyros
  const std::int64_t origin = imus.front().clock_zero_ns + (imus.front().recording.time_ns.empty() ? 0 : imus.front().recording.time_ns.front());
  for (const BodyImu& imu : imus) {
    streams.push_back(stream_of(imu, origin));
    if (streams.back().samples.size() < 2) throw Unsupported(imu.name + ": has no samples without gaps; expected 5 s or more");
    const Prior errors = covariance_of_errors(imu, options.first_is_reference && streams.size() == 1);
    priors.push_back(Cholesky(errors).inverse());
    out.covariance_before.push_back(errors);
    if (streams.size() == 1)
      for (const int element : {1, 2, 3, 5, 6, 7}) tilt_sigma = std::max(tilt_sigma, std::sqrt(errors(gyro_matrix + element, gyro_matrix + element)));
  }
  for (std::size_t k = 1; k < imus.size(); ++k) {
    const common_motion::Alignment found = common_motion::aligned(streams.front(), streams[k], {imus.front().name, imus[k].name, "two IMUs"});
    states[k].rotation = found.rotation, states[k].offset = found.offset;
    out.agreement.push_back(found.agreement);
    if (found.second_offset) findings.add<Code::clock_ambiguous>(Subject{imus.front().name}, imus[k].name, found.offset, *found.second_offset);
  }
  Span whole;
  const std::vector<Span> spans = common_spans(streams, states, options.most_used_s, whole);
  for (const Span& span : spans) out.used += span.length();
  out.duration = whole.length();
  if (out.used < 0.99 * out.duration) findings.add<Code::motion_part>(out.used, out.duration);

  // Of a poor IMU at first: far from the solution the residuals are not noise, and the priors have to hold what the data show weakly.
  constexpr double gyro_density = 3e-3, accel_density = 3e-2;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double root_rate = 1 / std::sqrt(streams[k].interval);
    states[k].gyro_sigma = gyro_density * root_rate, states[k].accel_sigma = accel_density * root_rate;
  }
  MotionFit& fit = out.fit.emplace(std::move(streams), std::move(states), std::move(priors), spans, tilt_sigma);
  constexpr int most_steps = 20;
  constexpr double small_step = 0.05, small_change = 0.02;
  fit.step(false);
  for (int i = 0; i < most_steps && !out.converged; ++i) {
    const double step = fit.step(true);
    out.converged = fit.take_noise() < small_change && step < small_step;
    if (options.progress) options.progress((i + 1.) / most_steps);
  }
  out.residuals = fit.residuals();
  out.constants = fit.covariance();
  finish_fit(imus, out);
  return out;
}

}  // namespace imulab::extrinsics
