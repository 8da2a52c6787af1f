// Common to the conditions of both methods on rests: the rests, the coefficients to estimate, and their priors.
#pragma once

#include "imulab/estimate/kernel/rest_start.hpp"
#include "imulab/estimate/rests/conditions.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::rests {

/// A rest or a rotation as a whole.
struct SuspectRows {
  std::string name;
  std::vector<Eigen::Index> rows;
};

class RestProblem {
 public:
  /// Coefficients that the data do not determine go back to their prior value and stay there.
  void hold(const std::vector<Eigen::Index>& undetermined);
  /// Of a coefficient of scaled readings: offsets 20 % of g and 1 rad/s, scales 20 %, misalignments 1e-2 (20 % where the row does not point along its
  /// axis: axes swapped), which contain uncalibrated units; optional terms by kernel::optional_priors.
  double prior_sigma(const Coefficient& c) const;
  /// Estimated coefficients to hold: the optional terms of which the data say nothing, else the one that they determine least of those that they do
  /// not determine. One at a time: a weak one makes others look undetermined.
  std::vector<Eigen::Index> not_determined(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const;

  const std::vector<RestMeans>& rests() const { return rests_; }
  const std::vector<CoefficientIndex>& indices() const { return indices_; }
  const SensorModel& model() const { return model_; }  ///< of scaled readings
  const SensorModel& prior() const { return prior_; }

 protected:
  RestProblem(const kernel::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices);
  /// The coefficients, then `nuisances` estimated without a prior.
  kernel::Parameters parameters(Eigen::Index nuisances) const;
  /// A correction's elements: up to the prior of those that all IMUs have; the equations are straight in the optional terms, which are small.
  Eigen::VectorXd longest_coefficient_step(Eigen::Index parameters) const;
  void correct_coefficients(const Eigen::VectorXd& correction);
  /// Specific force and rate that the model gives at a rest.
  Vector3d force_at(const RestMeans& rest) const { return output(model_.accel, scaling_.accel(rest.accel)); }
  Vector3d rate_at(const RestMeans& rest) const;
  Matrix3d force_covariance(const RestMeans& rest, double spread) const;
  Matrix3d rate_covariance(const RestMeans& rest, double spread) const;
  /// Adds the derivatives of rows by the coefficients of a triad, from those by the force (accelerometers) or the rate (gyros) at a rest.
  void add_derivatives(Conditions& c, Eigen::Index row, Triad triad, const RestMeans& rest, const Eigen::MatrixXd& by_output) const;
  /// The k-th rest with the rows of its own block.
  SuspectRows rest_suspect(const Conditions& conditions, std::size_t k) const;

  std::vector<RestMeans> rests_;
  double gravity_;
  std::optional<double> latitude_;
  Scaling scaling_;
  SampleNoise noise_;  ///< scaled
  SensorModel model_, prior_;
  kernel::PriorSizes sizes_;
  std::vector<CoefficientIndex> indices_;
  std::vector<kernel::Role> roles_;  ///< of the coefficients
};

}  // namespace imulab::rests
