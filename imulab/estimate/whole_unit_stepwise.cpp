#include "imulab/estimate/whole_unit_stepwise.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/rig/machine.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// One scalar equation that is linear in the coefficients of its step: row . theta = value, and what moves its misfit row . theta - value.
struct Equation {
  VectorXd row;       ///< by the problem's coefficients; the step's own, and those of steps before
  double misfit;      ///< with the coefficients so far (the step's own at zero)
  VectorXd by_noise;  ///< by the unit-variance noises of all points, then by the common errors over their sigmas; empty without covariance
};

class Steps {
 public:
  Steps(const WholeUnitProblem& problem, bool with_covariance)
      : problem_(problem),
        points_(problem.points().points),
        model_(problem.model()),
        with_covariance_(with_covariance),
        noises_(12 * static_cast<Index>(points_.size())),
        sources_(with_covariance ? noises_ + static_cast<Index>(problem.common().size()) : 0),
        sensitivity_(MatrixXd::Zero(coefficients(), sources_)) {
    for (const int k : problem.coefficients()) set_coefficient(model_, k, 0);
  }

  /// Step 1: U = u0 + c1 tau + c2 tau^2 in every channel.
  void chamber();
  /// Step 2: means of opposed positions at equal rate; W0, W1, W2, W3 (eqs 5, 6).
  void rate_table();
  /// Step 3: A0, A1, A2, A3 (eq 7), then C from what the gyros' readings leave (eqs 9, 10).
  void centrifuge_accelerometers();
  void centrifuge_gyros();

  StepwiseEstimate estimate() const { return {model_, sensitivity_ * sensitivity_.transpose()}; }

 private:
  Index coefficients() const { return static_cast<Index>(problem_.coefficients().size()); }
  std::vector<Index> of(Triad triad, std::initializer_list<Term> terms) const;
  std::vector<std::size_t> points_of(RigKind kind) const;
  Equation equation(std::size_t point, int row) const;
  Eigen::Matrix<double, 6, 6> raw_by_noise(std::size_t point) const;
  Vector6d thermal_sigma(std::size_t point) const;
  void solve(const std::vector<Equation>& equations, const std::vector<Index>& own);

  const WholeUnitProblem& problem_;
  const std::vector<WholeUnitPoint>& points_;
  SensorModel model_;
  bool with_covariance_;
  Index noises_, sources_;
  MatrixXd sensitivity_;  ///< of the coefficients, as by_noise
};

std::vector<Index> Steps::of(Triad triad, std::initializer_list<Term> terms) const {
  std::vector<Index> own;
  for (std::size_t k = 0; k < problem_.coefficients().size(); ++k) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(problem_.coefficients()[k])];
    if (c.triad == triad && std::find(terms.begin(), terms.end(), c.term) != terms.end()) own.push_back(static_cast<Index>(k));
  }
  return own;
}

std::vector<std::size_t> Steps::points_of(RigKind kind) const {
  std::vector<std::size_t> points;
  for (std::size_t p = 0; p < points_.size(); ++p)
    if (problem_.kind(points_[p]) == kind) points.push_back(p);
  return points;
}

void Steps::chamber() {
  const auto points = points_of(RigKind::chamber);
  const auto rows = static_cast<Index>(points.size());
  for (Index channel = 0; channel < 6; ++channel) {
    if (!problem_.points().thermal[channel < 3 ? 0 : 1]) continue;
    const Triad triad = channel < 3 ? Triad::accel : Triad::gyro;
    const int axis = static_cast<int>(channel % 3);
    MatrixXd x(rows, 3);
    VectorXd u(rows);
    for (Index k = 0; k < rows; ++k) {
      const RawSample raw = problem_.sample(points_[points[static_cast<std::size_t>(k)]]);
      const double tau = (channel < 3 ? raw.accel_tau : raw.gyro_tau)[axis];
      x.row(k) << 1, tau, tau * tau;
      u[k] = (channel < 3 ? raw.accel : raw.gyro)[axis];
    }
    const MatrixXd pseudo_inverse = x.colPivHouseholderQr().solve(MatrixXd::Identity(rows, rows));
    const VectorXd fit = pseudo_inverse * u;
    for (int order = 1; order <= 2; ++order) {
      const int index = coefficient_index(triad, Term::thermal, axis, order);
      set_coefficient(model_, index, fit[order]);
      const auto at = std::find(problem_.coefficients().begin(), problem_.coefficients().end(), index) - problem_.coefficients().begin();
      for (Index k = 0; k < rows && with_covariance_; ++k) {
        const std::size_t p = points[static_cast<std::size_t>(k)];
        const double slope = fit[1] + 2 * fit[2] * x(k, 1);
        sensitivity_.row(at).segment<6>(static_cast<Index>(12 * p)) = pseudo_inverse(order, k) * raw_by_noise(p).row(channel);
        sensitivity_(at, static_cast<Index>(12 * p) + 6 + channel) = -pseudo_inverse(order, k) * slope * thermal_sigma(p)[channel];
      }
    }
  }
}

/// What a sigma of the mean's noise, which is one of force and rate, does to the raw means.
Eigen::Matrix<double, 6, 6> Steps::raw_by_noise(std::size_t p) const {
  const Vector6d sigma = (problem_.noise() / static_cast<double>(points_[p].samples)).cwiseSqrt();
  return compensation_derivatives(problem_.model(), problem_.sample(points_[p])).raw.inverse() * sigma.asDiagonal();
}

Vector6d Steps::thermal_sigma(std::size_t p) const {
  return (problem_.points().thermal_variance / static_cast<double>(points_[p].samples)).cwiseSqrt();
}

/// Row 0..5 (force, rate) of e = compensate - motion at a point, with the coefficients so far.
Equation Steps::equation(std::size_t p, int row) const {
  const WholeUnitPoint& point = points_[p];
  const CompensationDerivatives d = compensation_derivatives(model_, problem_.sample(point));
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_common;
  const Motion truth = problem_.motion(point, &by_common);
  Equation e{VectorXd(coefficients()), row < 3 ? d.motion.force[row] - truth.force[row] : d.motion.rate[row - 3] - truth.rate[row - 3],
             VectorXd::Zero(sources_)};
  for (Index k = 0; k < coefficients(); ++k) e.row[k] = d.coefficients(row, problem_.coefficients()[static_cast<std::size_t>(k)]);
  if (!with_covariance_) return e;
  e.by_noise.segment<6>(static_cast<Index>(12 * p)) = (d.raw.row(row) * raw_by_noise(p)).transpose();
  e.by_noise.segment<6>(static_cast<Index>(12 * p) + 6) = d.temperature.row(row).transpose().cwiseProduct(thermal_sigma(p));
  for (Index k = 0; k < by_common.cols(); ++k) e.by_noise[noises_ + k] = -by_common(row, k) * problem_.common()[static_cast<std::size_t>(k)].sigma;
  return e;
}

/// Least squares for the step's own coefficients; what the noise and the steps before do to the misfits goes on to them.
void Steps::solve(const std::vector<Equation>& equations, const std::vector<Index>& own) {
  const auto rows = static_cast<Index>(equations.size());
  MatrixXd x(rows, coefficients()), noise(rows, sources_);
  VectorXd misfit(rows);
  for (Index k = 0; k < rows; ++k) {
    const Equation& e = equations[static_cast<std::size_t>(k)];
    x.row(k) = e.row;
    noise.row(k) = e.by_noise;
    misfit[k] = e.misfit;
  }
  MatrixXd design = x(Eigen::all, own);
  const VectorXd scale = design.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  design = design * scale.asDiagonal();
  const Eigen::LLT<MatrixXd> normal(design.transpose() * design);
  const MatrixXd inverse = normal.solve(MatrixXd::Identity(design.cols(), design.cols()));
  if (normal.info() != Eigen::Success || !inverse.allFinite() || inverse.diagonal().maxCoeff() > 1e13)
    throw Unsupported("stepwise: the rate table's or centrifuge's points do not determine their coefficients: too few rates or positions");
  const MatrixXd gain = scale.asDiagonal() * inverse * design.transpose();
  const VectorXd correction = -gain * misfit;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const int index = problem_.coefficients()[static_cast<std::size_t>(own[k])];
    set_coefficient(model_, index, coefficient_value(model_, index) + correction[static_cast<Index>(k)]);
  }
  if (!with_covariance_) return;
  MatrixXd earlier = x;
  for (const Index k : own) earlier.col(k).setZero();
  sensitivity_(own, Eigen::all) = -gain * (noise + earlier * sensitivity_);
}

void Steps::rate_table() {
  // The body's rate along an axis; of the positions with that axis up and down.
  std::map<std::pair<int, long>, std::array<std::vector<std::size_t>, 2>> opposed;
  for (const std::size_t p : points_of(RigKind::rate_table)) {
    const Step& step = points_[p].step;
    const BodyAxis up = mount_of(step).up;
    const double rate = step.kind == StepKind::spin ? step.rate * up.sign : 0;
    opposed[{up.index, std::lround(rate * 1e6)}][up.sign > 0].push_back(p);
  }
  // Two passes: how the noise of a reading moves the misfit is known once there are coefficients.
  const std::vector<Index> own = of(Triad::gyro, {Term::offset, Term::matrix, Term::quadratic, Term::cubic});
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<Equation> equations;
    for (const auto& [key, positions] : opposed) {
      if (positions[0].empty() || positions[1].empty()) continue;
      for (int row = 3; row < 6; ++row) {
        Equation mean{VectorXd::Zero(coefficients()), 0, VectorXd::Zero(sources_)};
        for (const auto& side : positions)
          for (const std::size_t p : side) {
            const Equation e = equation(p, row);
            const double share = 0.5 / static_cast<double>(side.size());
            mean.row += share * e.row, mean.misfit += share * e.misfit, mean.by_noise += share * e.by_noise;
          }
        equations.push_back(std::move(mean));
      }
    }
    solve(equations, own);
  }
}

void Steps::centrifuge_accelerometers() {
  const std::vector<Index> own = of(Triad::accel, {Term::offset, Term::matrix, Term::quadratic, Term::cubic});
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<Equation> equations;
    for (const std::size_t p : points_of(RigKind::centrifuge))
      for (int row = 0; row < 3; ++row) equations.push_back(equation(p, row));
    solve(equations, own);
  }
}

void Steps::centrifuge_gyros() {
  std::vector<Equation> equations;
  for (const std::size_t p : points_of(RigKind::centrifuge))
    for (int row = 3; row < 6; ++row) equations.push_back(equation(p, row));
  solve(equations, of(Triad::gyro, {Term::g_sensitivity}));
}

}  // namespace

bool has_three_steps(const WholeUnitProblem& problem) {
  std::map<RigKind, std::array<bool, 6>> seen;
  for (const WholeUnitPoint& p : problem.points().points) {
    const Mount mount = mount_of(p.step);
    const RigKind kind = problem.kind(p);
    const BodyAxis axis = kind == RigKind::centrifuge ? mount.outward : mount.up;
    seen[kind][static_cast<std::size_t>(2 * axis.index + (axis.sign > 0))] = true;
  }
  const auto all = [&](RigKind kind) { return seen.contains(kind) && std::all_of(seen[kind].begin(), seen[kind].end(), [](bool b) { return b; }); };
  return seen.contains(RigKind::chamber) && all(RigKind::rate_table) && all(RigKind::centrifuge);
}

StepwiseEstimate stepwise_estimate(const WholeUnitProblem& problem, bool with_covariance) {
  if (!has_three_steps(problem))
    throw Unsupported(
        "stepwise: a chamber, a rate table with each axis up and down, and a centrifuge with each axis outward both ways were expected");
  WholeUnitProblem declared = problem;
  declared.forget_common();
  Steps steps(declared, with_covariance);
  steps.chamber();
  steps.rate_table();
  steps.centrifuge_accelerometers();
  steps.centrifuge_gyros();
  return steps.estimate();
}

}  // namespace imulab
