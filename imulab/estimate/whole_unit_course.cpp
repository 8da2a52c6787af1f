#include "imulab/estimate/whole_unit_course.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const Coefficient& coefficient(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

}  // namespace

WholeUnitPrior::WholeUnitPrior(const WholeUnitProblem& problem, const SensorModel& start) : mean_(start) {
  const WholeUnitPoints& points = problem.points();
  const auto [force, rate] = problem.full_scale();
  full_scale_[0] = std::max(force, problem.session().site.gravity()), full_scale_[1] = std::max(rate, 1 * unit::deg);
  scale_[0] = start.accel.matrix.diagonal().cwiseAbs(), scale_[1] = start.gyro.matrix.diagonal().cwiseAbs();
  for (std::size_t triad = 0; triad < 2; ++triad) {
    const double least = points.thermal_unit[triad] == "raw" ? 1e-6 : 10;
    thermal_range_[triad] = std::max(points.thermal_range_high[triad] - points.thermal_range_low[triad], least);
    thermal_excited_[triad] = points.thermal_excited[triad];
  }
}

double WholeUnitPrior::sigma(int index) const {
  const Coefficient& c = coefficient(index);
  const std::size_t triad = c.triad == Triad::accel ? 0 : 1;
  const double s = scale_[triad][c.row], per = triad == 0 ? unit::g : unit::deg;
  switch (c.term) {
    case Term::offset:
      return 0.2 * full_scale_[triad];
    case Term::matrix:
      return (c.row == c.column ? 0.2 : 0.05) * scale_[triad][c.column];
    case Term::quadratic:
      return (triad == 0 ? 3e-4 : 7.5e-4) / per * s * s;
    case Term::cubic:
      return (triad == 0 ? 6e-5 : 1e-7) / (per * per) * s * s * s;
    case Term::thermal:
      return (triad == 0 ? 0.15 : 15) * per / s / std::pow(thermal_range_[triad], c.column);
    case Term::g_sensitivity:
      return 1e-3;
    case Term::lever_arm:
      break;
  }
  return 0;
}

double WholeUnitPrior::needed(int index) const {
  const Coefficient& c = coefficient(index);
  if (c.term == Term::thermal && !thermal_excited_[c.triad == Triad::accel ? 0 : 1]) return 0;
  const bool basic = c.term == Term::offset || (c.term == Term::matrix && c.row == c.column);
  return (basic ? 0.05 : 0.5) * sigma(index);
}

Knowledge knowledge(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, Weak weak) {
  Knowledge known{VectorXd(problem.size()), VectorXd(problem.size())};
  const auto& indices = problem.coefficients();
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const auto i = static_cast<Index>(k);
    known.offset[i] = coefficient_value(prior.mean(), indices[k]) - coefficient_value(problem.model(), indices[k]);
    const bool loose = parts[k] == Part::weak && (weak == Weak::free || coefficient(indices[k]).term == Term::offset);
    known.sigma[i] = parts[k] == Part::estimated ? free_parameter : loose ? prior.sigma(indices[k]) : 0;
  }
  for (std::size_t k = 0; k < problem.common().size(); ++k) {
    const auto i = static_cast<Index>(indices.size() + k);
    known.offset[i] = -problem.common()[k].value;
    known.sigma[i] = problem.common()[k].sigma;
  }
  return known;
}

MatrixXd covariance(const WholeUnitFit& fit, const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts) {
  return solve(fit.sum, knowledge(problem, prior, parts, Weak::free)).covariance;
}

WholeUnitFit converge(WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, Weak weak) {
  constexpr int most_iterations = 20;
  WholeUnitFit fit;
  for (int iteration = 0; iteration < most_iterations && !fit.converged; ++iteration) {
    fit.sum = problem.square_sum();
    fit.solution = solve(fit.sum, knowledge(problem, prior, parts, weak));
    problem.correct(fit.solution.x);
    const VectorXd sigma = fit.solution.covariance.diagonal().cwiseSqrt();
    // What is held arrives at once.
    fit.converged = ((sigma.array() > 0).select(fit.solution.x.cwiseAbs() - 0.01 * sigma, 0)).maxCoeff() <= 0;
  }
  return fit;
}

std::vector<Part> determined(const WholeUnitProblem& problem, const WholeUnitPrior& prior, std::vector<Part> parts) {
  std::vector<Part> trial = parts;
  for (Part& part : trial)
    if (part == Part::estimated) part = Part::weak;
  const Solution s = solve(problem.square_sum(), knowledge(problem, prior, trial, Weak::free));
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (parts[k] == Part::estimated &&
        std::sqrt(s.covariance(static_cast<Index>(k), static_cast<Index>(k))) > prior.needed(problem.coefficients()[k]))
      parts[k] = Part::weak;
  return parts;
}

namespace {

constexpr std::size_t parts_of_validation = 10;
constexpr double chance = 0.005;  // of the RMS of some 2000 residuals: twenty of chi-square, more than nine coefficients gain by chance

struct Group {
  std::string name;
  std::vector<std::size_t> members;  ///< of the problem's coefficients
};

std::vector<Group> groups_of(const WholeUnitProblem& problem, const std::vector<Part>& parts) {
  std::vector<Group> groups;
  const auto add = [&](std::string name, Triad triad, Term term, int column) {
    Group group{std::move(name), {}};
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Coefficient& c = coefficient(problem.coefficients()[k]);
      if (c.triad == triad && c.term == term && (column < 0 || c.column == column) && parts[k] == Part::estimated) group.members.push_back(k);
    }
    if (!group.members.empty()) groups.push_back(std::move(group));
  };
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const std::string name(to_string(triad));
    add(name + ".cubic", triad, Term::cubic, -1);
    add(name + ".quadratic", triad, Term::quadratic, -1);
    add(name + ".thermal second order", triad, Term::thermal, 2);
  }
  add("gyro.g_sensitivity", Triad::gyro, Term::g_sensitivity, -1);
  return groups;
}

TermTest wald_test(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const Group& group, const Solution& s) {
  const auto n = static_cast<Index>(group.members.size());
  VectorXd value(n);
  std::vector<Index> at;
  for (Index k = 0; k < n; ++k) {
    const std::size_t member = group.members[static_cast<std::size_t>(k)];
    const int index = problem.coefficients()[member];
    at.push_back(static_cast<Index>(member));
    value[k] = coefficient_value(problem.model(), index) + s.x[static_cast<Index>(member)] - coefficient_value(prior.mean(), index);
  }
  const MatrixXd p = s.covariance(at, at);
  const VectorXd scale = p.diagonal().cwiseSqrt().cwiseInverse();
  const VectorXd scaled = scale.cwiseProduct(value);
  TermTest test{group.name, scaled.dot(MatrixXd(scale.asDiagonal() * p * scale.asDiagonal()).llt().solve(scaled)), static_cast<int>(n), 1, true, 0,
                0};
  test.p_value = chi_square_tail(test.statistic, static_cast<double>(n));
  return test;
}

/// RMS of what each part's points miss, in sigmas of their noise, when predicted from the others.
double cross_validation(const std::vector<SquareSum>& folds, const SquareSum& all, const Knowledge& known) {
  double sum = 0;
  int rows = 0;
  for (const SquareSum& fold : folds) {
    const SquareSum others{all.N - fold.N, all.g - fold.g, all.c - fold.c, all.rows - fold.rows};
    sum += fold.at(solve(others, known).x);
    rows += fold.rows;
  }
  return std::sqrt(sum / std::max(rows, 1));
}

}  // namespace

std::vector<TermTest> choose_orders(const WholeUnitProblem& problem, const WholeUnitPrior& prior, std::vector<Part>& parts) {
  std::vector<SquareSum> folds;
  SquareSum all;
  for (std::size_t k = 0; k < parts_of_validation; ++k) all += folds.emplace_back(problem.square_sum(k, parts_of_validation));
  std::vector<TermTest> tests;
  for (std::vector<Group> groups = groups_of(problem, parts); !groups.empty();) {
    const Knowledge known = knowledge(problem, prior, parts, Weak::held);
    const Solution s = solve(all, known);
    const double with = cross_validation(folds, all, known);
    std::vector<TermTest> now;
    for (const Group& group : groups) {
      TermTest& test = now.emplace_back(wald_test(problem, prior, group, s));
      std::vector<Part> without = parts;
      for (const std::size_t k : group.members) without[k] = Part::absent;
      test.cross_validation_with = with;
      test.cross_validation_without = cross_validation(folds, all, knowledge(problem, prior, without, Weak::held));
      test.kept = test.p_value < 0.01 || test.cross_validation_without > (1 + chance) * with;
    }
    const auto weakest = std::max_element(
        now.begin(), now.end(), [](const TermTest& a, const TermTest& b) { return std::pair(!a.kept, a.p_value) < std::pair(!b.kept, b.p_value); });
    if (weakest->kept) {
      tests.insert(tests.end(), now.begin(), now.end());
      break;
    }
    const auto at = weakest - now.begin();
    for (const std::size_t k : groups[static_cast<std::size_t>(at)].members) parts[k] = Part::absent;
    tests.push_back(*weakest);
    groups.erase(groups.begin() + at);
  }
  return tests;
}

std::vector<std::string> drop_outliers(WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, double level) {
  const WholeUnitProblem whole = problem;
  const std::size_t most = std::max<std::size_t>(2, problem.points().points.size() / 50);
  for (std::vector<std::string> dropped;;) {
    const WholeUnitFit fit = converge(problem, prior, parts);
    const std::vector<WholeUnitPoint>& points = problem.points().points;
    std::vector<double> statistic;
    for (const WholeUnitPoint& point : points) {
      const PointEquations e = problem.equations(point);
      // The misfit as the other points predict it: I - J P J^T is what the fit leaves of unit noise.
      const Eigen::Matrix<double, 6, 6> left =
          Eigen::Matrix<double, 6, 6>::Identity() - e.jacobian * fit.solution.covariance * e.jacobian.transpose();
      statistic.push_back(e.white.dot(left.ldlt().solve(e.white)));
    }
    const double spread = std::max(1.0, median(statistic) / chi_square_quantile(0.5, 6));  // of good points, where their size is not the noise's
    const auto worst = std::max_element(statistic.begin(), statistic.end());
    if (log_chi_square_tail(*worst / spread, 6) > std::log(level / static_cast<double>(points.size()))) return dropped;
    if (dropped.size() == most) {
      problem = whole;
      return {};
    }
    const auto at = static_cast<std::size_t>(worst - statistic.begin());
    dropped.push_back(points[at].name(problem.session()));
    problem.drop(at);
  }
}

}  // namespace imulab
