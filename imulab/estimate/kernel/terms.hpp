// Selection of optional terms: Wald's test, cross-validation, and backward selection.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/information.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab::kernel {

/// Parameters that are either all in a model or all absent.
struct TermGroup {
  std::string name;                   ///< "gyro.g_sensitivity"
  std::vector<Eigen::Index> members;  ///< indices of the parameters
};

/// Wald's test of a group against zero: value^T covariance^-1 value is chi-square distributed if the group is absent. `value` and `covariance`
/// contain the group's members only. An empty group is not kept.
TermTest wald(std::string name, const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance, double significance);
/// Wald's test on the information of the data alone, for a group that was estimated under a zero-mean prior with these sigmas.
TermTest wald_without_prior(std::string name, const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& prior_sigma,
                            double significance);

/// RMS residual of each part of the data, predicted from the other parts, in sigmas of its noise.
struct CrossValidation {
  double with = 0;              ///< RMS with all parameters
  std::vector<double> without;  ///< RMS with each group in turn fixed at its prior value
};
/// Computes the cross-validation; `all` must be the sum of `parts`.
CrossValidation cross_validation(const std::vector<Information>& parts, const Information& all, const Parameters& parameters,
                                 const std::vector<TermGroup>& groups);

/// Backward selection: the least significant group that fails its test is left out, and the others are tested again without it. `test` receives the
/// groups that are still in the model, `leave_out` the one to remove. Returns every group's last test.
std::vector<TermTest> choose_terms(std::vector<TermGroup> groups, const std::function<std::vector<TermTest>(const std::vector<TermGroup>&)>& test,
                                   const std::function<void(const TermGroup&)>& leave_out);

}  // namespace imulab::kernel
