// The iteration of the hybrid method: passes of the filter about improving models, and velocities that the converged model cannot explain.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/hybrid/filter.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab::hybrid {

/// The state of the iteration.
struct Iterate {
  States states;
  Linearization about;    ///< model, place and attitude at the start of the next pass
  Eigen::VectorXd total;  ///< sum of the corrections of each constant since the coarse solution
  Pass pass = {};         ///< last pass; after convergence it is about the final model
  bool converged = false;
  bool heading_known = false;  ///< the heading at the start is accurate enough for a linearization
  int iterations = 0;
};

/// Starts from the coarse solution.
Iterate first_iterate(const Data& data);

/// Errors of the model of the last pass. Constants that are `undetermined` stay at the coarse solution; its uncertainty enters the others'
/// covariance.
struct Errors {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Index> undetermined;
  std::vector<CoefficientIndex> coefficients, open;  ///< determined or optional coefficients; coefficients that are not determined
  std::vector<CoefficientIndex> considered;          ///< optional ones among `coefficients` that the data do not determine
};
Errors determined_errors(const Iterate& iterate);
/// Returns the part of the constants' covariance that recurs for the same IMU (kernel::Effects::constant_part); empty if sizes are not inferred.
Eigen::MatrixXd constant_part(const Data& data, const Iterate& last);

/// Returns the RMS of the velocity residuals relative to their noise.
double scatter_of(const Data& data, const Iterate& iterate);
/// Scatter of data that no prior, axis or choice of velocities can explain.
inline constexpr double other_data = 100;

/// Repeats one pass about the same model.
Iterate repeated(const Data& data, Iterate iterate, double curve_interval = 0);

struct Converged {
  Iterate last;
  std::vector<TermTest> tests = {};        ///< tests of the optional groups
  std::vector<std::size_t> left_out = {};  ///< blocks with an outlying velocity
  std::vector<std::string> lost = {};      ///< turns that no model explains
  double headings = 1;                     ///< scatter of the headings in the rests relative to their noise, before it was attributed to movement
};

/// Iterates until the set of used velocities no longer changes. Blocks with outlying velocities are no longer observed in `data`, and turns that no
/// model explains are removed. Optional groups are in the model, significant or not; they are tested unless the user named the terms.
Converged converge(Data& data, double significance);

}  // namespace imulab::hybrid
