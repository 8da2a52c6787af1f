// The iterations of the hybrid method: passes of the filter about improving models, the significant terms, and the velocities that the
// converged model cannot explain.
#pragma once

#include "imulab/estimate/hybrid/filter.hpp"
#include "imulab/model/calibration.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::hybrid {

/// The state of the iterations.
struct Iterate {
  Groups terms;  ///< optional groups
  States states;
  Linearization about;    ///< model, place and attitude at the start of the next pass
  Eigen::VectorXd total;  ///< by constant: what was corrected since the coarse solution
  Pass pass = {};         ///< the last one; once converged it is about the final model
  bool converged = false;
  bool heading_known = false;  ///< the start's, well enough for a linearization
  int iterations = 0;
};

/// From the coarse solution.
Iterate first_iterate(const Data& data, const Groups& terms);

/// Errors of the model that the last pass was about. Constants that are `undetermined` are at the coarse solution, and how far that may be off counts
/// in the others' covariance.
struct Errors {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Index> undetermined;
  std::vector<CoefficientIndex> coefficients, open;  ///< determined, and not
};
Errors determined_errors(const Iterate& iterate);

/// One pass, about the same model.
Iterate repeated(const Data& data, Iterate iterate, double curve_interval = 0);

/// A latitude as the gyros measure the Earth's rate [rad].
struct SeenLatitude {
  double value, sigma;
};

struct Converged {
  Iterate last;
  std::vector<TermTest> tests;           ///< of the optional groups, where the data choose among them
  std::size_t left_out = 0;              ///< velocities
  std::optional<SeenLatitude> latitude;  ///< contradicts the place's: then the rest is void
};

/// Repeats until neither the terms nor the velocities that are used change. It starts with `terms` and ends with those of `possible` that are
/// significant (all of `terms` where both are the same). Blocks whose velocity is an outlier are no longer observed in `data`.
Converged converge(Data& data, const Groups& terms, const Groups& possible, double significance);

}  // namespace imulab::hybrid
