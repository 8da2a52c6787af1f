#include "imulab/estimate/whole_unit/stepwise.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Three misfits of force or rate that are linear in the coefficients of their step: misfit + design . change of theta.
struct Equations {
  MatrixXd design;    ///< by the problem's coefficients: the step's own, and those of steps before
  VectorXd misfit;    ///< with the coefficients so far
  MatrixXd by_noise;  ///< by the unit-variance noises of all points, then by the common errors over their sigmas; no columns without covariance
};

constexpr std::initializer_list<Term> polynomial{Term::offset, Term::matrix, Term::quadratic, Term::cubic};

class Steps {
 public:
  Steps(const Problem& problem, bool with_covariance)
      : problem_(problem),
        points_(problem.points.all),
        model_(problem.model),
        with_covariance_(with_covariance),
        noises_(12 * static_cast<Index>(points_.size())),
        sources_(with_covariance ? noises_ + static_cast<Index>(problem.common.size()) : 0),
        sensitivity_(MatrixXd::Zero(coefficients(), sources_)) {
    for (const CoefficientIndex k : problem.coefficients) set_coefficient(model_, k, 0);
  }

  /// Step 1: U = u0 + c1 tau + c2 tau^2 in every channel.
  void chamber();
  /// Step 2: means of opposed positions at equal rate; W0, W1, W2, W3 (eqs 5, 6).
  void rate_table();
  /// Step 3: A0, A1, A2, A3 (eq 7), then C from what the gyros' readings leave (eqs 9, 10).
  void centrifuge(Triad triad, std::initializer_list<Term> terms, int passes);

  StepwiseEstimate estimate() const { return {model_, sensitivity_ * sensitivity_.transpose()}; }

 private:
  Index coefficients() const { return static_cast<Index>(problem_.coefficients.size()); }
  std::vector<Index> of(Triad triad, std::initializer_list<Term> terms) const;
  std::vector<std::size_t> points_of(RigKind kind) const;
  Equations equations(std::size_t point, Triad triad) const;
  Eigen::Matrix<double, 6, 6> raw_by_noise(std::size_t point) const;
  Vector6d thermal_sigma(std::size_t point) const;
  void solve(const std::vector<Equations>& equations, const std::vector<Index>& own, std::string_view points);

  const Problem& problem_;
  const std::vector<Point>& points_;
  SensorModel model_;
  bool with_covariance_;
  Index noises_, sources_;
  MatrixXd sensitivity_;  ///< of the coefficients, as by_noise
};

std::vector<Index> Steps::of(Triad triad, std::initializer_list<Term> terms) const {
  std::vector<Index> own;
  for (std::size_t k = 0; k < problem_.coefficients.size(); ++k) {
    const Coefficient& c = coefficient(problem_.coefficients[k]);
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
    if (!problem_.points.thermal[channel < 3 ? 0 : 1].known) continue;
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
    const MatrixXd pseudo_inverse = least_squares(x, MatrixXd::Identity(rows, rows)).x;
    const VectorXd fit = pseudo_inverse * u;
    for (int order = 1; order <= 2; ++order) {
      const CoefficientIndex index = coefficient_index(triad, Term::thermal, axis, order);
      set_coefficient(model_, index, fit[order]);
      const auto at = std::find(problem_.coefficients.begin(), problem_.coefficients.end(), index) - problem_.coefficients.begin();
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
  const Vector6d sigma = (problem_.noise / static_cast<double>(points_[p].samples)).cwiseSqrt();
  return compensation_derivatives(problem_.model, problem_.sample(points_[p])).raw.inverse() * sigma.asDiagonal();
}

Vector6d Steps::thermal_sigma(std::size_t p) const {
  return (problem_.points.thermal_variance / static_cast<double>(points_[p].samples)).cwiseSqrt();
}

/// e = compensate - motion at a point, with the coefficients so far.
Equations Steps::equations(std::size_t p, Triad triad) const {
  const CompensationDerivatives d = compensation_derivatives(model_, problem_.sample(points_[p]));
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_common;
  const Motion truth = problem_.motion(points_[p], &by_common);
  const Index row = triad == Triad::accel ? 0 : 3, column = static_cast<Index>(12 * p);
  Equations e{d.coefficients(Eigen::seqN(row, 3), problem_.coefficients),
              triad == Triad::accel ? d.motion.force - truth.force : d.motion.rate - truth.rate, MatrixXd::Zero(3, sources_)};
  if (!with_covariance_) return e;
  e.by_noise.middleCols<6>(column) = d.raw.middleRows<3>(row) * raw_by_noise(p);
  e.by_noise.middleCols<6>(column + 6) = d.temperature.middleRows<3>(row) * thermal_sigma(p).asDiagonal();
  for (Index k = 0; const CommonError& error : problem_.common) {
    e.by_noise.col(noises_ + k) = -error.sigma * by_common.col(k).segment<3>(row);
    ++k;
  }
  return e;
}

/// Least squares for the step's own coefficients; what noise and the steps before do to the misfits goes on to them.
void Steps::solve(const std::vector<Equations>& equations, const std::vector<Index>& own, std::string_view points) {
  const Index rows = 3 * std::ssize(equations);
  Equations all{MatrixXd(rows, coefficients()), VectorXd(rows), MatrixXd(rows, sources_)};
  for (Index row = 0; const Equations& e : equations) {
    all.design.middleRows<3>(row) = e.design, all.misfit.segment<3>(row) = e.misfit, all.by_noise.middleRows<3>(row) = e.by_noise;
    row += 3;
  }
  const MatrixXd design = all.design(Eigen::all, own);
  const kernel::Solution s = kernel::solve({design, all.misfit}, kernel::Parameters(design.cols()), points);
  for (Index k = 0; const Index i : own) {
    const CoefficientIndex index = problem_.coefficients[static_cast<std::size_t>(i)];
    set_coefficient(model_, index, coefficient_value(model_, index) + s.x[k++]);
  }
  if (!with_covariance_) return;
  all.design(Eigen::all, own).setZero();  // what remains are the steps before
  sensitivity_(own, Eigen::all) = -s.covariance * design.transpose() * (all.by_noise + all.design * sensitivity_);
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
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<Equations> means;
    for (const auto& [key, positions] : opposed) {
      if (positions[0].empty() || positions[1].empty()) continue;
      Equations& mean = means.emplace_back(Equations{MatrixXd::Zero(3, coefficients()), VectorXd::Zero(3), MatrixXd::Zero(3, sources_)});
      for (const auto& side : positions)
        for (const std::size_t p : side) {
          const Equations e = equations(p, Triad::gyro);
          const double share = 0.5 / static_cast<double>(side.size());
          mean.design += share * e.design, mean.misfit += share * e.misfit, mean.by_noise += share * e.by_noise;
        }
    }
    solve(means, of(Triad::gyro, polynomial), "the rate table's points");
  }
}

void Steps::centrifuge(Triad triad, std::initializer_list<Term> terms, int passes) {
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<Equations> all;
    for (const std::size_t p : points_of(RigKind::centrifuge)) all.push_back(equations(p, triad));
    solve(all, of(triad, terms), "the centrifuge's points");
  }
}

}  // namespace

bool has_three_steps(const Problem& problem) {
  std::map<RigKind, std::array<bool, 6>> seen;
  for (const Point& p : problem.points.all) {
    const Mount mount = mount_of(p.step);
    const RigKind kind = problem.kind(p);
    const BodyAxis axis = kind == RigKind::centrifuge ? mount.outward : mount.up;
    seen[kind][static_cast<std::size_t>(2 * axis.index + (axis.sign > 0))] = true;
  }
  const auto all = [&](RigKind kind) { return seen.contains(kind) && std::all_of(seen[kind].begin(), seen[kind].end(), [](bool b) { return b; }); };
  return seen.contains(RigKind::chamber) && all(RigKind::rate_table) && all(RigKind::centrifuge);
}

StepwiseEstimate stepwise_estimate(const Problem& problem, bool with_covariance) {
  if (!has_three_steps(problem))
    throw Unsupported(
        "the machines do not do all of Dai's three steps; expected a chamber, a rate table with each axis up and down, and a centrifuge "
        "with each axis outward both ways");
  Problem declared = problem;
  for (CommonError& error : declared.common) error.value = 0;
  Steps steps(declared, with_covariance);
  steps.chamber();
  steps.rate_table();
  steps.centrifuge(Triad::accel, polynomial, 2);
  steps.centrifuge(Triad::gyro, {Term::g_sensitivity}, 1);
  return steps.estimate();
}

}  // namespace imulab::whole_unit
