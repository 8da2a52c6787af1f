#include "imulab/estimate/whole_unit/problem.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/slow_noise.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <fmt/core.h>
#include <unsupported/Eigen/AutoDiff>

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using kernel::Role;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Rows = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Returns prior sizes for the full scale reached [m/s^2, rad/s]. Second and third orders are three to a hundred times those of Dai's table 2 (3e-4
/// /g and 6e-5 /g^2; 7.5e-4 /(deg/s) and 1e-7 /(deg/s)^2), because other units may be worse.
kernel::PriorSizes prior_sizes(double force, double rate) {
  using unit::deg, unit::g;
  return {.accel = {0.2 * force, 0.2, 0.05, 3e-4 / g, 6e-5 / (g * g), 0.15 * g},
          .gyro = {0.2 * rate, 0.2, 0.05, 7.5e-4 / deg, 1e-7 / (deg * deg), 15 * deg}};
}

/// Returns the coefficients that the points can determine.
std::vector<CoefficientIndex> candidates(const MachinePoints& points) {
  std::vector<CoefficientIndex> indices;
  for (const CoefficientIndex k : coefficient_indices()) {
    const Coefficient& c = coefficient(k);
    if (c.term == Term::lever_arm || is_extended(c) || (c.term == Term::thermal && !points.thermal[c.triad == Triad::accel ? 0 : 1].known)) continue;
    indices.push_back(k);
  }
  return indices;
}

void set_priors(PointProblem& problem) {
  const auto [force, rate] = problem.full_scale();
  const kernel::PriorSizes sizes = prior_sizes(std::max(force, problem.session->site.gravity()), std::max(rate, 1 * unit::deg));
  for (Index i = 0; i < problem.prior_sigma.size(); ++i) {
    const Coefficient& c = coefficient(problem.coefficients[static_cast<std::size_t>(i)]);
    const ThermalRange& thermal = problem.points.thermal[c.triad == Triad::accel ? 0 : 1];
    const TriadModel& triad = triad_model(problem.start, c.triad);
    const int axis = c.term == Term::matrix ? c.column : c.row;
    const double sigma =
        kernel::prior_sigma(sizes, c, std::abs(triad.matrix(axis, axis)), std::max(thermal.size(), thermal.unit == "raw" ? 1e-6 : 10));
    problem.prior_sigma[i] = sigma;
    problem.needed_sigma[i] = c.term == Term::thermal && !thermal.excited ? 0 : kernel::needed_sigma(c, sigma);
  }
}

}  // namespace

std::string CommonError::name() const {
  if (drift)
    return fmt::format("recording {}: slow noise of {}.{}", drift->recording + 1, drift->channel < 3 ? "accel" : "gyro", "xyz"[drift->channel % 3]);
  return rig.empty() && source.kind == RigErrorKind::zero ? "gravity" : (rig.empty() ? "" : rig + ": ") + source.name();
}

PointProblem::PointProblem(MachinePoints used, const Session& declared, const SensorModel& starting_model, const Vector6d& reading_center)
    : points(std::move(used)),
      session(&declared),
      site(declared.site),
      start(starting_model),
      model(starting_model),
      center(reading_center),
      coefficients(candidates(points)),
      role(coefficients.size(), Role::estimated),
      prior_sigma(std::ssize(coefficients)),
      needed_sigma(std::ssize(coefficients)),
      place_(place_of(declared.site)) {
  common.push_back({"", {}, declared.site.gravity_sigma(), 0});  // "gravity"
  for (const RecordingSource& source : declared.recordings) {
    const RigDeclaration& rig = *declared.rig_of(source);
    std::vector<std::size_t>& acting = acting_.emplace_back();
    for (const RigErrorSource& error : rig_error_sources(declared, source)) {
      const auto known = std::find_if(common.begin() + 1, common.end(), [&](const CommonError& c) { return c.rig == rig.name && c.source == error; });
      acting.push_back(static_cast<std::size_t>(known - common.begin()));
      if (known == common.end()) common.push_back({rig.name, error, error.sigma, 0});
    }
  }
  update_noise();
  add_drifts();
  set_priors(*this);
}

CompensationDerivatives accel_first_derivatives(const SensorModel& model, const RawSample& raw) {
  CompensationDerivatives d = compensation_derivatives(model, raw);
  const std::array<int, 6> order{3, 4, 5, 0, 1, 2};
  d.coefficients = d.coefficients(order, Eigen::all).eval();
  d.raw = d.raw(order, order).eval();
  d.temperature = d.temperature(order, order).eval();
  return d;
}

Vector6d PointProblem::measured_noise() const {
  Vector6d variance = Vector6d::Zero();
  for (const MachinePoint& point : points.all) {
    const Matrix6 slope = accel_first_derivatives(model, sample(point)).raw;
    variance += slope.cwiseAbs2() * point.variance / static_cast<double>(points.all.size());
  }
  return variance;
}

void PointProblem::update_noise() {
  noise = measured_noise();
  const NoiseModels declared = declared_terms(session->imu);
  if (const double N = declared.accel.N; N > 0) noise.head<3>().setConstant(N * N / points.interval_s);
  if (const double N = declared.gyro.N; N > 0) noise.tail<3>().setConstant(N * N / points.interval_s);
  noise = noise.cwiseProduct(points.correlation);
}

std::array<double, 2> PointProblem::full_scale() const {
  std::array<double, 2> full{};
  for (const MachinePoint& point : points.all) {
    const Motion m = motion(point);
    full[0] = std::max(full[0], m.force.cwiseAbs().maxCoeff());
    full[1] = std::max(full[1], m.rate.cwiseAbs().maxCoeff());
  }
  return full;
}

RawSample PointProblem::sample(const MachinePoint& point) const {
  RawSample raw{.gyro = point.raw.tail<3>() - center.tail<3>(), .accel = point.raw.head<3>() - center.head<3>()};
  if (model.accel.temperature) raw.accel_tau = point.temperature.head<3>().array() - model.accel.temperature->reference;
  if (model.gyro.temperature) raw.gyro_tau = point.temperature.tail<3>().array() - model.gyro.temperature->reference;
  return raw;
}

Motion PointProblem::motion(const MachinePoint& point, Rows* motion_by_common) const {
  constexpr int variables = 8;  // gravity, tilt, rate, mount, radius
  using T = Eigen::AutoDiffScalar<Eigen::Vector<double, variables>>;
  std::vector<Index> index{0};  // index of eta for each derivative
  MachineErrors<T> errors;
  for (const std::size_t i : acting_[point.recording])
    if (T* const element = element_of(errors, common[i].source, mount_of(point.step))) {
      *element = T(common[i].source.known + common[i].value, variables, static_cast<int>(index.size()));
      index.push_back(static_cast<Index>(i));
    }
  const SteadyMotion<T> m = steady_motion<T>(point.step, errors, {place_.gravity + T(common[0].value, variables, 0), place_.rate_ie_n});
  Motion motion;
  if (motion_by_common) *motion_by_common = Rows::Zero(6, std::ssize(common));
  for (int i = 0; i < 3; ++i) {
    motion.force[i] = m.force[i].value(), motion.rate[i] = m.rate[i].value();
    for (int k = 0; const Index column : index) {
      if (motion_by_common)
        (*motion_by_common)(i, column) = m.force[i].derivatives()[k], (*motion_by_common)(3 + i, column) = m.rate[i].derivatives()[k];
      ++k;
    }
  }
  for (std::size_t i = 0; i < common.size(); ++i) {
    if (!common[i].drift) continue;
    const int channel = common[i].drift->channel;
    const double by = common[i].drift->at(point);
    (channel < 3 ? motion.force[channel] : motion.rate[channel - 3]) += by * common[i].value;
    if (motion_by_common) (*motion_by_common)(channel, static_cast<Index>(i)) = by;
  }
  return motion;
}

PointEquations PointProblem::equations(const MachinePoint& point) const {
  const CompensationDerivatives d = accel_first_derivatives(model, sample(point));
  Rows motion_by_common;
  const Motion truth = motion(point, &motion_by_common);
  PointEquations out;
  out.residual << d.motion.force - truth.force, d.motion.rate - truth.rate;  // Dai 2011 eqs 1 to 4 minus the machine's motion: his eqs 5, 7, 10

  const Matrix6 thermal = d.temperature * points.thermal_variance.asDiagonal() * d.temperature.transpose();
  Matrix6 variance = (thermal + Matrix6(noise.asDiagonal())) / static_cast<double>(point.samples);
  // A coarsely quantized or dead channel has no noise; 1e-8 of the full range keeps the weights finite.
  variance.diagonal() += 1e-16 * (Vector6d() << Vector3d::Constant(place_.gravity * place_.gravity), Vector3d::Ones()).finished();
  variance.diagonal() += point_variance[point.recording];
  variance += spin_noise(point.step, session->rig_of(session->recordings[point.recording])->zero.value, place_);
  const Eigen::LLT<Matrix6> factor(noise_factor * noise_factor * variance);
  out.jacobian.resize(6, size());
  out.jacobian.leftCols(size() - effects.size()) << d.coefficients(Eigen::all, coefficients), -motion_by_common;
  if (effects.size() > 0) {
    const MatrixXd& of_point = by_effects[point.recording][point.number];
    out.residual += of_point * effects.value();
    if (latitude_ >= 0) out.residual -= of_point.col(latitude_) * effects.value()[latitude_];
    out.jacobian.rightCols(effects.size()) = of_point;
  }
  factor.matrixL().solveInPlace(out.jacobian);
  out.white = factor.matrixL().solve(out.residual);
  return out;
}

std::vector<Index> PointProblem::acting_columns(std::size_t recording) const {
  std::vector<Index> columns;
  for (Index i = 0; i < std::ssize(coefficients); ++i) columns.push_back(i);
  const std::vector<std::size_t>& of_machine = acting_[recording];
  for (std::size_t k = 0; k < common.size(); ++k)
    if (k == 0 || (common[k].drift ? common[k].drift->recording == recording : std::ranges::count(of_machine, k) > 0))
      columns.push_back(static_cast<Index>(coefficients.size() + k));
  for (Index k = 0; k < effects.size(); ++k) {  // the drift of another recording has no effect here
    const auto acts = [&](const MatrixXd& at_point) { return at_point.size() > 0 && !at_point.col(k).isZero(0); };
    if (std::ranges::any_of(by_effects[recording], acts)) columns.push_back(size() - effects.size() + k);
  }
  return columns;
}

kernel::Information PointProblem::information(std::size_t part, std::size_t parts) const {
  constexpr Index at_once = 32;  // points
  kernel::Information sum(size());
  for (std::size_t recording = 0; recording < session->recordings.size(); ++recording) {
    const std::vector<Index> columns = acting_columns(recording);
    const auto n = std::ssize(columns);
    MatrixXd rows(6 * at_once, n), N = MatrixXd::Zero(n, n);
    Index filled = 0;
    const auto add = [&] {
      if (filled > 0) N.selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(filled).transpose());
      filled = 0;
    };
    for (std::size_t p = part; p < points.all.size(); p += parts) {
      if (points.all[p].recording != recording) continue;
      const PointEquations e = equations(points.all[p]);
      rows.middleRows<6>(filled) = e.jacobian(Eigen::all, columns);
      if ((filled += 6) == rows.rows()) add();
      sum.g += e.jacobian.transpose() * e.white;
      sum.chi2 += e.white.squaredNorm();
      sum.rows += 6;
    }
    add();
    sum.N(columns, columns) += MatrixXd(N.selfadjointView<Eigen::Lower>());
  }
  return sum;
}

kernel::Parameters PointProblem::parameters(Priors priors) const {
  kernel::Parameters out(size());
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const auto i = static_cast<Index>(k);
    out.offset[i] = coefficient_value(start, coefficients[k]) - coefficient_value(model, coefficients[k]);
    if (role[k] == Role::estimated && priors != Priors::all) continue;
    const bool free = role[k] != Role::fixed && (priors != Priors::offsets || coefficient(coefficients[k]).term == Term::offset);
    if (free)
      out.sigma[i] = prior_sigma[i];
    else
      out.role[k] = Role::fixed;
  }
  for (std::size_t k = coefficients.size(); const CommonError& error : common) {
    out.offset[static_cast<Index>(k)] = -error.value;
    out.sigma[static_cast<Index>(k)] = error.sigma;
    if (!(error.sigma > 0)) out.role[k] = Role::fixed;
    ++k;
  }
  effects.add_to(out);
  return out;
}

void PointProblem::correct(const VectorXd& x) {
  Index i = 0;
  for (const CoefficientIndex index : coefficients) set_coefficient(model, index, coefficient_value(model, index) + x[i++]);
  for (CommonError& error : common) error.value += x[i++];
  effects.correct(x);
  if (latitude_ >= 0) set_place();
}

Fit fit(PointProblem& problem, Priors priors) {
  constexpr int most_iterations = 20;
  constexpr double still = 0.01 * 0.01;  // change of chi-square: every parameter changes by less than a hundredth of its standard deviation
  Fit out;
  problem.update_effects();
  out.converged = kernel::iterate(most_iterations, [&](int) {
    out.data = problem.information();
    out.parameters = problem.parameters(priors);
    const VectorXd x = kernel::correction(out.data, out.parameters, "the points");
    problem.correct(x);
    const std::vector<Index> loose = out.parameters.with(Role::estimated);
    const VectorXd moved = x(loose);
    const double chi2 = moved.dot(out.data.N(loose, loose) * moved) + moved.cwiseQuotient(out.parameters.sigma(loose)).squaredNorm();
    return chi2 <= still ? kernel::Progress::converged : kernel::Progress::moving;
  });
  return out;
}

double ChannelDrift::at(const MachinePoint& point) const { return point.recording == recording ? shape[static_cast<Index>(point.number)] : 0; }

void PointProblem::add_drifts() {
  constexpr double stands_out = 0.1;
  const NoiseModels declared = declared_terms(session->imu);
  point_variance.assign(session->recordings.size(), Vector6d::Zero());
  for (std::size_t recording = 0; recording < point_variance.size(); ++recording) {
    std::vector<const MachinePoint*> of_recording;
    for (const MachinePoint& p : points.all)
      if (p.recording == recording) of_recording.push_back(&p);
    if (of_recording.empty()) continue;
    const auto n = std::ssize(of_recording);
    // Noise begins with the recording. Its clock begins at the same time unless it starts at more than the recording's length.
    const double first = of_recording.front()->step.start, origin = first < of_recording.back()->step.end - first ? 0 : first;
    std::vector<kernel::TimeSpan> times;
    for (const MachinePoint* p : of_recording) times.push_back({p->step.start - origin, p->step.end - origin});
    Eigen::MatrixXd covariance;
    SymmetricEigen shapes;
    for (int channel = 0; channel < 6; ++channel) {
      const NoiseModel& of_triad = channel < 3 ? declared.accel : declared.gyro;
      if (channel % 3 == 0) covariance = kernel::slow_noise(times, of_triad, points.interval_s);
      if (covariance.size() == 0) continue;
      if (channel % 3 == 0) shapes = symmetric_eigen(covariance);
      const double independent = std::max(0.0, shapes.values[0]), white = noise[channel] / static_cast<double>(of_recording.front()->samples);
      double others = 0;
      for (Index k = 0; k < n; ++k) {
        const double variance = shapes.values[k] - independent;
        if (!(variance > stands_out * (white + independent))) {
          others += variance / static_cast<double>(n);
          continue;
        }
        ChannelDrift drift{recording, channel, Eigen::VectorXd::Zero(static_cast<Index>(of_recording.back()->number) + 1)};
        for (Index p = 0; p < n; ++p) drift.shape[static_cast<Index>(of_recording[static_cast<std::size_t>(p)]->number)] = shapes.vectors(p, k);
        common.push_back({"", {}, std::sqrt(variance), 0, std::move(drift)});
      }
      point_variance[recording][channel] = independent + others;
    }
  }
}

}  // namespace imulab::whole_unit
