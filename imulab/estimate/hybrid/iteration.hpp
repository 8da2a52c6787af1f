// The iterations of the hybrid method: passes of the filter about improving models, and the velocities that the converged model cannot
// explain.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/hybrid/filter.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab::hybrid {

/// The state of the iterations.
struct Iterate {
  States states;
  Linearization about;    ///< model, place and attitude at the start of the next pass
  Eigen::VectorXd total;  ///< by constant: what was corrected since the coarse solution
  Pass pass = {};         ///< the last one; once converged it is about the final model
  bool converged = false;
  bool heading_known = false;  ///< the start's, well enough for a linearization
  int iterations = 0;
};

/// From the coarse solution.
Iterate first_iterate(const Data& data);

/// Errors of the model that the last pass was about. Constants that are `undetermined` are at the coarse solution, and how far that may be off counts
/// in the others' covariance.
struct Errors {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Index> undetermined;
  std::vector<CoefficientIndex> coefficients, open;  ///< determined, or optional; and not determined
  std::vector<CoefficientIndex> considered;          ///< optional ones that the data do not show, among `coefficients`
};
Errors determined_errors(const Iterate& iterate);
/// Part of the constants' covariance that the same IMU brings again (kernel::Effects::constant_part); empty where sizes are not inferred.
Eigen::MatrixXd constant_part(const Data& data, const Iterate& last);

/// The velocities' residuals over what the noise explains (RMS).
double scatter_of(const Data& data, const Iterate& iterate);
/// The scatter of data that no prior, axis or choice of velocities explains.
inline constexpr double other_data = 100;

/// One pass, about the same model.
Iterate repeated(const Data& data, Iterate iterate, double curve_interval = 0);

struct Converged {
  Iterate last;
  std::vector<TermTest> tests = {};        ///< of the optional groups: are they seen?
  std::vector<std::size_t> left_out = {};  ///< blocks whose velocity is an outlier
  std::vector<std::string> lost = {};      ///< turns that no model explains
  double headings = 1;                     ///< their scatter in the rests over what the noise explains, before it was taken for movement
};

/// Repeats until the velocities that are used no longer change. Blocks whose velocity is an outlier are no longer observed in `data`, and turns that
/// no model explains are no longer in it. The optional
/// groups are in the model, seen or not; they are tested where the user did not name them.
Converged converge(Data& data, double significance);

}  // namespace imulab::hybrid
