#include "imulab/estimate/whole_unit/selection.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/suspects.hpp"
#include "imulab/estimate/kernel/terms.hpp"

#include <Eigen/Cholesky>

#include <algorithm>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::VectorXd;
using kernel::Role;
using kernel::TermGroup;

void consider_undetermined(Problem& problem) {
  const kernel::Parameters parameters = problem.parameters(Priors::all);
  const kernel::Solution s = kernel::solve(problem.information(), parameters, "the points");
  for (const Index i : kernel::undetermined(s.covariance, parameters, problem.needed_sigma))
    problem.role[static_cast<std::size_t>(i)] = Role::considered;
}

namespace {

constexpr std::size_t parts_of_validation = 10;
constexpr double chance = 0.005;  // of the RMS of some 2000 residuals: twenty of chi-square, more than nine coefficients gain by chance

/// The optional terms, of estimated coefficients.
std::vector<TermGroup> optional_terms(const Problem& problem) {
  std::vector<TermGroup> groups;
  const auto add = [&](Triad triad, std::string_view name, Term term, int column = -1) {
    TermGroup group{std::string(to_string(triad)) + "." + std::string(name), {}};
    for (std::size_t k = 0; k < problem.role.size(); ++k) {
      const Coefficient& c = coefficient(problem.coefficients[k]);
      if (c.triad == triad && c.term == term && (column < 0 || c.column == column) && problem.role[k] == Role::estimated)
        group.members.push_back(static_cast<Index>(k));
    }
    if (!group.members.empty()) groups.push_back(std::move(group));
  };
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    add(triad, "cubic", Term::cubic);
    add(triad, "quadratic", Term::quadratic);
    add(triad, "thermal second order", Term::thermal, 2);
  }
  add(Triad::gyro, "g_sensitivity", Term::g_sensitivity);
  return groups;
}

/// A fit whose suspects are its points.
struct PointFit {
  Problem problem;
  std::size_t may_go;  ///< so many points more
  Fit fit = whole_unit::fit(problem);

  std::vector<kernel::Suspect> suspects() const {
    using Matrix6 = Eigen::Matrix<double, 6, 6>;
    std::vector<double> statistic;
    for (const Point& point : problem.points.all) {
      const PointEquations e = problem.equations(point);
      // The misfit as the other points predict it: I - J P J^T is what the fit leaves of unit noise.
      const Matrix6 remaining = Matrix6::Identity() - e.jacobian * fit.solution.covariance * e.jacobian.transpose();
      statistic.push_back(e.white.dot(remaining.ldlt().solve(e.white)));
    }
    const double spread = std::max(1.0, median(statistic) / chi_square_quantile(0.5, 6));  // of good points, where their size is not the noise's
    std::vector<kernel::Suspect> out;
    for (std::size_t k = 0; k < statistic.size(); ++k)
      out.push_back({problem.points.all[k].name(*problem.session), log_chi_square_tail(statistic[k] / spread, 6)});
    return out;
  }
  bool may_drop(std::size_t) const { return may_go > 0; }
  PointFit without(std::size_t suspect) const {
    Problem rest = problem;
    rest.points.all.erase(rest.points.all.begin() + static_cast<std::ptrdiff_t>(suspect));
    return {std::move(rest), may_go - 1};
  }
};

}  // namespace

std::vector<TermTest> choose_terms(Problem& problem, double significance) {
  std::vector<kernel::Information> parts;
  kernel::Information all;
  for (std::size_t k = 0; k < parts_of_validation; ++k) all += parts.emplace_back(problem.information(k, parts_of_validation));
  const auto test = [&](const std::vector<TermGroup>& groups) {
    const kernel::Parameters parameters = problem.parameters();
    const kernel::Solution s = kernel::solve(all, parameters, "the points");
    const VectorXd values = s.x - parameters.offset;  // less the starting values
    const double with = kernel::cross_validation(parts, all, parameters);
    std::vector<TermTest> tests;
    for (const TermGroup& group : groups) {
      TermTest& t = tests.emplace_back(kernel::wald(group, values, s.covariance, significance));
      kernel::Parameters without = parameters;
      for (const Index i : group.members) without.role[static_cast<std::size_t>(i)] = Role::fixed;
      t.cross_validation_with = with;
      t.cross_validation_without = kernel::cross_validation(parts, all, without);
      t.kept = t.kept || t.cross_validation_without > (1 + chance) * with;
    }
    return tests;
  };
  return kernel::choose_terms(optional_terms(problem), test, [&](const TermGroup& group) {
    for (const Index i : group.members) problem.role[static_cast<std::size_t>(i)] = Role::fixed;
  });
}

std::vector<std::string> drop_bad_points(Problem& problem, double level) {
  auto cleaned = kernel::drop_suspects(PointFit{problem, std::max<std::size_t>(2, problem.points.all.size() / 50)}, level);
  if (!cleaned.clean) return {};
  problem = std::move(cleaned.fit.problem);
  return std::move(cleaned.dropped);
}

}  // namespace imulab::whole_unit
