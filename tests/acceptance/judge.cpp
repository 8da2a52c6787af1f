#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <cmath>
#include <map>

namespace imulab::acceptance {

using Eigen::Index;

std::vector<Check> judge(const std::vector<Run>& runs) {
  const double n = static_cast<double>(runs.size());
  const auto m = static_cast<Index>(runs.front().indices.size());
  double efficiency = 0, consistency = 0;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(m);  // over the bound's variance
  std::map<std::string, std::vector<Index>> groups;
  for (Index i = 0; i < m; ++i) {
    const Coefficient& c = coefficient(runs.front().indices[static_cast<std::size_t>(i)]);
    groups[std::string(to_string(c.triad)) + "." + std::string(to_string(c.term))].push_back(i);
  }
  std::map<std::string, double> inside;
  for (const Run& run : runs) {
    const double dm = static_cast<double>(m);
    efficiency += run.error.dot(run.information * run.error) / dm / n;
    consistency += squared_norm_in(run.covariance, run.error) / dm / n;
    squares += run.error.cwiseAbs2().cwiseQuotient(inverse_of(run.information).diagonal()) / n;
    for (const auto& [name, at] : groups) {
      const Eigen::VectorXd e = run.error(at);
      const Eigen::MatrixXd p = run.covariance(at, at);
      const Eigen::VectorXd white = Cholesky(p).solve_lower(e);
      for (const double w : white) inside[name] += std::abs(w) <= 1.959963985 ? 1 : 0;
    }
  }
  const double dof = n * static_cast<double>(m);
  std::vector<Check> checks{{"efficiency", efficiency, 0, 1.1025},
                            {"consistency", consistency, chi_square_quantile(0.0005, dof) / dof, chi_square_quantile(0.9995, dof) / dof}};
  for (const auto& [name, at] : groups) {
    const double trials = n * static_cast<double>(at.size());
    checks.push_back({"coverage " + name, inside[name] / trials, binomial_quantile(0.0005, trials, 0.95) / trials,
                      binomial_quantile(0.9995, trials, 0.95) / trials});
  }
  Index worst;
  squares.maxCoeff(&worst);
  const Coefficient& c = coefficient(runs.front().indices[static_cast<std::size_t>(worst)]);
  checks.push_back({"worst coefficient " + std::string(c.name), std::sqrt(squares[worst]), 0,
                    std::sqrt(chi_square_quantile(1 - 0.001 / static_cast<double>(m), n) / n)});
  return checks;
}

std::vector<Run> run_all(Run (*run)(std::uint64_t), int count, const std::string& name) {
  return runs_of<Run>(name, count, [&](std::size_t i) { return run(i + 1); });
}

std::string describe(const std::vector<Check>& checks) {
  std::string text;
  for (const Check& check : checks)
    text += fmt::format("  {:<42} {:7.4f}  in [{:.4f}, {:.4f}]  {}\n", check.name, check.value, check.low, check.high,
                        check.passed() ? "passed" : "FAILED");
  return text;
}

}  // namespace imulab::acceptance
