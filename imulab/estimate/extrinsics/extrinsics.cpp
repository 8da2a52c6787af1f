#include "imulab/extrinsics.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/extrinsics/alignment.hpp"
#include "imulab/estimate/extrinsics/motion_fit.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {

using namespace extrinsics;

double Mounting::uncertainty(int row) const { return std::sqrt(covariance(row, row)); }

Vector3d Mounting::uncertainties(Row first) const { return covariance.diagonal().segment<3>(first).cwiseSqrt(); }

Eigen::Matrix4d Mounting::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation;
  m.topRightCorner<3, 1>() = -rotation * lever_arm;
  return m;
}

namespace {

constexpr double most_used_s = 120;

double square(double x) { return x * x; }

/// How a calibration's errors scale and turn its output: d(M raw) = dM M^-1 output, for each triad; and the g-sensitivity.
Prior covariance_of_errors(const BodyImu& imu) {
  const Grade& sizes = grade(imu.grade);
  Prior p = Prior::Zero();
  constexpr double fixed = 1e-7, any_gyro_offset = 0.2, any_accel_offset = 1;  // relative, rad/s, m/s^2
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int element = 3 * i + j;
      p(gyro_matrix + element, gyro_matrix + element) = square(i == j ? sizes.gyro_scale : sizes.gyro_misalignment);
      p(g_sensitivity + element, g_sensitivity + element) = square(std::max(sizes.g_sensitivity, sizes.terms.g_sensitivity));
      p(accel_matrix + element, accel_matrix + element) = square(i == j ? sizes.accel_scale : i > j ? sizes.accel_misalignment : fixed);
    }
  for (int i = 0; i < 3; ++i) {
    p(gyro_offset + i, gyro_offset + i) = square(any_gyro_offset);
    p(accel_offset + i, accel_offset + i) = square(any_accel_offset);
  }
  p.diagonal().array() += square(fixed);  // a size may be zero
  if (!imu.calibration) return p;
  const Calibration& c = *imu.calibration;
  Eigen::MatrixXd to_errors = Eigen::MatrixXd::Zero(own_columns, static_cast<Eigen::Index>(c.estimated.size()));
  Prior kept = Prior::Identity();
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const Coefficient& coefficient = imulab::coefficient(c.estimated[k]);
    const int first = coefficient.term == Term::g_sensitivity                                 ? g_sensitivity
                      : coefficient.term == Term::matrix && coefficient.triad == Triad::gyro  ? gyro_matrix
                      : coefficient.term == Term::matrix && coefficient.triad == Triad::accel ? accel_matrix
                                                                                              : -1;
    if (first < 0) continue;
    const int row = coefficient.row, column = coefficient.column;
    const TriadModel& triad = coefficient.triad == Triad::accel ? c.model.accel : c.model.gyro;
    Matrix3d back = Matrix3d::Identity();
    if (coefficient.term == Term::matrix) {
      if (const auto inverse = regular_inverse(triad.matrix)) back = *inverse;
    }
    for (int j = 0; j < 3; ++j) to_errors(first + 3 * row + j, static_cast<Eigen::Index>(k)) = back(column, j);
    for (int j = 0; j < 3; ++j) kept(first + 3 * row + j, first + 3 * row + j) = 0;
  }
  p = kept * p * kept;
  p += to_errors * c.covariance * to_errors.transpose();
  p.diagonal().array() += square(fixed);
  return p;
}

std::vector<Span> common_spans(const std::vector<Stream>& streams, const std::vector<ImuState>& states, Span& whole) {
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

/// What is hardly more certain than before the motion.
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

double variance_of(const std::vector<double>& list) {
  double sum = 0, squares = 0;
  for (const double x : list) sum += x, squares += x * x;
  const double n = static_cast<double>(list.size());
  return squares / n - square(sum / n);
}

void judge_agreement(Extrinsics& out, const MotionFit& fit, std::size_t k) {
  double motion = 0;  // variance of the rates, mean of the axes
  for (const std::vector<double>& axis : out.rates[k - 1].second) motion += variance_of(axis) / 3;
  const double unlike = std::hypot(fit.states()[0].gyro_sigma, fit.states()[k].gyro_sigma) / std::sqrt(motion);
  constexpr double most_unlike = 0.2;
  if (unlike > most_unlike || out.agreement[k - 1] < 1 - most_unlike)
    out.findings.add<Code::rates_unlike>(Subject{out.imus.front()}, out.imus[k],
                                         100 * std::max(unlike, std::sqrt(std::max(0., 1 - out.agreement[k - 1]))));
}

void judge_mounting(Extrinsics& out, const Mounting& m, double enlarged) {
  kernel::add_scatter(out.findings, fmt::format("seconds of {} and {}", m.from, m.to), enlarged);
  if (!m.not_shown.empty()) out.findings.add<Code::mounting_not_shown>(Subject{m.to}, fmt::format("{}", fmt::join(m.not_shown, ", ")));
  const double u = m.uncertainty(delay);
  constexpr double certain = 4, least_delay_s = 2e-4;  // sigmas; a delay that matters to no user
  if (std::abs(m.accel_delay) > certain * u && std::abs(m.accel_delay) > least_delay_s)
    out.findings.add<Code::accels_late>(Subject{m.to}, 1e3 * m.accel_delay, m.from, 1e3 * u);
}

void expect_different_names(const std::vector<BodyImu>& imus) {
  if (imus.size() < 2) throw Error(fmt::format("one IMU ({}); expected two or more on one body", imus.empty() ? "none" : imus.front().name));
  for (std::size_t i = 0; i < imus.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (imus[i].name == imus[j].name) throw Error(fmt::format("{}: two IMUs have this name; expected different ones", imus[i].name));
}

}  // namespace

Mounting Extrinsics::between(std::size_t from, std::size_t to) const {
  if (from >= imus.size() || to >= imus.size()) throw Error(fmt::format("{} IMUs; expected two of 0 to {}", imus.size(), imus.size() - 1));
  const Mounting none{.from = imus.front(), .to = imus.front(), .epoch = from_first.front().epoch};
  const Mounting &a = from == 0 ? none : from_first[from - 1], &b = to == 0 ? none : from_first[to - 1];
  Mounting m{.from = imus[from], .to = imus[to], .epoch = a.epoch};
  m.rotation = b.rotation * a.rotation.transpose();
  m.lever_arm = a.rotation * (b.lever_arm - a.lever_arm);
  m.clock_offset = b.clock_offset - a.clock_offset, m.clock_drift = b.clock_drift - a.clock_drift, m.accel_delay = b.accel_delay - a.accel_delay;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(mount_columns, covariance.rows());
  if (to > 0) {
    auto by_b = jacobian.middleCols<mount_columns>(static_cast<Eigen::Index>(mount_columns * (to - 1)));
    by_b.setIdentity();
    by_b.block<3, 3>(arm, arm) = a.rotation;
  }
  if (from > 0 && from != to) {
    auto by_a = jacobian.middleCols<mount_columns>(static_cast<Eigen::Index>(mount_columns * (from - 1)));
    by_a.diagonal().setConstant(-1);
    by_a.block<3, 3>(turn, turn) = -m.rotation;
    by_a.block<3, 3>(arm, turn) = -skew<double>(m.lever_arm);
    by_a.block<3, 3>(arm, arm) = -a.rotation;
  }
  if (from == to) jacobian.setZero();
  m.covariance = jacobian * covariance * jacobian.transpose();
  m.not_shown = imulab::not_shown(m);
  return m;
}

Extrinsics estimate_extrinsics(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress) {
  expect_different_names(imus);
  Extrinsics out;
  std::vector<Stream> streams;
  std::vector<ImuState> states(imus.size());
  std::vector<Prior> priors;
  double tilt_sigma = 0;  // of the first IMU's gyros
  const std::int64_t origin = imus.front().clock_zero_ns + (imus.front().recording.time_ns.empty() ? 0 : imus.front().recording.time_ns.front());
  for (const BodyImu& imu : imus) {
    out.imus.push_back(imu.name);
    streams.push_back(stream_of(imu, origin));
    if (streams.back().samples.size() < 2) throw Unsupported(imu.name + ": has no samples without gaps; expected 5 s or more");
    const Prior errors = covariance_of_errors(imu);
    priors.push_back(Cholesky(errors).inverse());
    if (out.imus.size() == 1)
      for (const int element : {1, 2, 3, 5, 6, 7}) tilt_sigma = std::max(tilt_sigma, std::sqrt(errors(gyro_matrix + element, gyro_matrix + element)));
    if (!imu.calibration) out.findings.add<Code::imu_not_calibrated>(Subject{imu.name}, "grade " + imu.grade);
  }
  for (std::size_t k = 1; k < imus.size(); ++k) {
    const Alignment found = aligned(streams.front(), streams[k], imus.front().name, imus[k].name);
    states[k].rotation = found.rotation, states[k].offset = found.offset;
    out.agreement.push_back(found.agreement);
    if (found.second_offset) out.findings.add<Code::clock_ambiguous>(Subject{imus[0].name}, imus[k].name, found.offset, *found.second_offset);
  }
  Span whole;
  const std::vector<Span> spans = common_spans(streams, states, whole);
  for (const Span& span : spans) out.used += span.length();
  out.duration = whole.length();
  if (out.used < 0.99 * out.duration) out.findings.add<Code::motion_part>(out.used, out.duration);

  // Of a poor IMU at first: far from the solution the residuals are not noise, and the priors have to hold what the data show weakly.
  constexpr double gyro_density = 3e-3, accel_density = 3e-2;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const double root_rate = 1 / std::sqrt(streams[k].interval);
    states[k].gyro_sigma = gyro_density * root_rate, states[k].accel_sigma = accel_density * root_rate;
  }
  MotionFit fit(streams, std::move(states), std::move(priors), spans, tilt_sigma);
  constexpr int most_steps = 20;
  constexpr double small_step = 0.05, small_change = 0.02;
  fit.step(false);
  bool converged = false;
  for (int i = 0; i < most_steps && !converged; ++i) {
    const double step = fit.step(true);
    converged = fit.take_noise() < small_change && step < small_step;
    if (progress) progress((i + 1.) / most_steps);
  }

  out.residuals = fit.residuals();
  const auto [covariance, enlargement, change] = fit.covariance();
  constexpr double most_change = 0.2;  // of a direction that the motion does not show the steps stay long
  if (!converged && change > most_change) out.findings.add<Code::not_converged>();
  const auto others = static_cast<Eigen::Index>(imus.size() - 1);
  out.covariance.resize(mount_columns * others, mount_columns * others);
  for (Eigen::Index a = 0; a < others; ++a)
    for (Eigen::Index b = 0; b < others; ++b)
      out.covariance.block<mount_columns, mount_columns>(mount_columns * a, mount_columns * b) = covariance.block<mount_columns, mount_columns>(
          MotionFit::mount_column(static_cast<std::size_t>(a) + 1), MotionFit::mount_column(static_cast<std::size_t>(b) + 1));
  for (std::size_t k = 1; k < imus.size(); ++k) {
    const ImuState& state = fit.states()[k];
    Mounting m{.from = imus.front().name,
               .to = imus[k].name,
               .rotation = state.rotation,
               .lever_arm = state.lever_arm,
               .clock_offset = state.offset,
               .clock_drift = state.drift,
               .accel_delay = state.delay,
               .epoch = fit.epoch()};
    const auto place = static_cast<Eigen::Index>(mount_columns * (k - 1));
    m.covariance = out.covariance.block<mount_columns, mount_columns>(place, place);
    m.not_shown = imulab::not_shown(m);
    out.rates.push_back(fit.rates(k));
    judge_agreement(out, fit, k);
    judge_mounting(out, m, enlargement.segment<mount_columns>(MotionFit::mount_column(k)).maxCoeff());
    out.from_first.push_back(std::move(m));
  }
  out.verdict = out.findings.doubtful() ? Verdict::doubtful : Verdict::good;
  return out;
}

}  // namespace imulab
