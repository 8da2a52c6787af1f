#include "imulab/estimate/whole_unit/terms.hpp"

#include "imulab/estimate/kernel/terms.hpp"

#include <string>
#include <string_view>
#include <utility>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::VectorXd;
using kernel::Role;
using kernel::TermGroup;

namespace {

constexpr std::size_t parts_of_validation = 10;
constexpr double chance = 0.005;  // of the RMS of some 2000 residuals: twenty of chi-square, more than the chance gain of nine coefficients

/// Returns the optional terms of the estimated coefficients.
std::vector<TermGroup> optional_terms(const PointProblem& problem) {
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

}  // namespace

std::vector<TermTest> choose_terms(PointProblem& problem, double significance) {
  std::vector<kernel::Information> parts;
  kernel::Information all;
  for (std::size_t k = 0; k < parts_of_validation; ++k) all += parts.emplace_back(problem.information(k, parts_of_validation));
  const auto test = [&](const std::vector<TermGroup>& groups) {
    const kernel::Parameters parameters = problem.parameters();
    const kernel::Solution s = kernel::solve(all, parameters, "the points");
    const VectorXd values = s.x - parameters.offset;  // minus the starting values
    const kernel::CrossValidation missed = kernel::cross_validation(parts, all, parameters, groups);
    std::vector<TermTest> tests;
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const std::vector<Index>& at = groups[k].members;
      TermTest& t = tests.emplace_back(kernel::wald(groups[k].name, values(at), s.covariance(at, at), significance));
      t.cross_validation_with = missed.with, t.cross_validation_without = missed.without[k];
      t.kept = t.kept || missed.without[k] > (1 + chance) * missed.with;
    }
    return tests;
  };
  if (problem.effects.size() > 0) return test(optional_terms(problem));
  return kernel::choose_terms(optional_terms(problem), test, [&](const TermGroup& group) {
    for (const Index i : group.members) problem.role[static_cast<std::size_t>(i)] = Role::fixed;
  });
}

}  // namespace imulab::whole_unit
