#include "imulab/estimate/kernel/terms.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TermTest wald(std::string name, const VectorXd& value, const MatrixXd& covariance, double significance) {
  TermTest test{std::move(name), 0, static_cast<int>(value.size()), 1, false};
  if (value.size() == 0) return test;
  const VectorXd unit = covariance.diagonal().cwiseSqrt().cwiseInverse(), scaled = unit.cwiseProduct(value);
  test.statistic = squared_norm_in(unit.asDiagonal() * covariance * unit.asDiagonal(), scaled);
  test.p_value = chi_square_tail(test.statistic, static_cast<double>(value.size()));
  test.kept = test.p_value <= significance;
  return test;
}

TermTest wald_without_prior(std::string name, const VectorXd& value, const MatrixXd& covariance, const VectorXd& prior_sigma, double significance) {
  TermTest test{std::move(name), 0, static_cast<int>(value.size()), 1, false};
  if (value.size() == 0) return test;
  // In units of the prior, the information of the data is P^-1 - I, with the information vector P^-1 x.
  const MatrixXd unit = prior_sigma.cwiseInverse().asDiagonal();
  const SymmetricEigen posterior = symmetric_eigen(unit * covariance * unit);
  const VectorXd along = posterior.vectors.transpose() * (unit * value);
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    const double variance = posterior.values[i];
    if (variance < 1 - 1e-6) test.statistic += along[i] * along[i] / (variance * (1 - variance));  // otherwise the combination is not observable
  }
  test.p_value = chi_square_tail(test.statistic, static_cast<double>(value.size()));
  test.kept = test.p_value <= significance;
  return test;
}

CrossValidation cross_validation(const std::vector<Information>& parts, const Information& all, const Parameters& parameters,
                                 const std::vector<TermGroup>& groups) {
  CrossValidation out{0, std::vector<double>(groups.size(), 0)};
  for (const Information& part : parts) {
    const Solution s = solve(all - part, parameters);
    out.with += part.at(s.x);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      // Fixing the group changes the others: x - P_k P_kk^-1 (x_k - prior value).
      const std::vector<Index>& at = groups[k].members;
      const VectorXd off = s.x(at) - parameters.offset(at);
      out.without[k] += part.at(s.x - s.covariance(Eigen::all, at) * solve_semidefinite(MatrixXd(s.covariance(at, at)), off));
    }
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / std::max(all.rows, 1)); };
  out.with = rms(out.with);
  for (double& sum : out.without) sum = rms(sum);
  return out;
}

std::vector<TermTest> choose_terms(std::vector<TermGroup> groups, const std::function<std::vector<TermTest>(const std::vector<TermGroup>&)>& test,
                                   const std::function<void(const TermGroup&)>& leave_out) {
  std::vector<TermTest> done;
  while (!groups.empty()) {
    const std::vector<TermTest> now = test(groups);
    const auto weakest = std::max_element(
        now.begin(), now.end(), [](const TermTest& a, const TermTest& b) { return std::pair(!a.kept, a.p_value) < std::pair(!b.kept, b.p_value); });
    if (weakest->kept) {
      done.insert(done.end(), now.begin(), now.end());
      break;
    }
    const auto at = weakest - now.begin();
    leave_out(groups[static_cast<std::size_t>(at)]);
    done.push_back(*weakest);
    groups.erase(groups.begin() + at);
  }
  return done;
}

}  // namespace imulab::kernel
