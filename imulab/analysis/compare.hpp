// Two calibrations, or a calibration and the truth, coefficient by coefficient: in sigmas and in user units.
#pragma once

#include "imulab/model/calibration.hpp"

#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// One coefficient in two calibrations, both in the accelerometers' frame (quadratic and cubic terms unrotated). SI, except where said.
struct CoefficientDifference {
  int index = 0;  ///< in the coefficient table
  double a = 0, b = 0;
  double difference = 0;              ///< b - a
  std::optional<double> uncertainty;  ///< standard uncertainty of the difference; absent where neither calibration states one
  /// The same in user units. For matrices this is an element of D = M_b M_a^-1 - I, which does not depend on the raw unit: what a scale or
  /// misalignment differs by, diagonal in ppm, off-diagonal in arcsec.
  double user_difference = 0;
  std::optional<double> user_uncertainty;
  std::string_view user_unit;

  std::optional<double> sigmas() const;       ///< difference / uncertainty
  std::optional<double> user_sigmas() const;  ///< user_difference / user_uncertainty: the same but for matrices
};

/// Are the differences as large as the stated covariances say? e^T P^-1 e over the coefficients estimated together.
struct Consistency {
  double chi2 = 0;
  int degrees_of_freedom = 0;  ///< 0: there is nothing to test
  double p_value = 1;          ///< probability of a chi-square at least this large
};

struct Comparison {
  std::vector<CoefficientDifference> coefficients;  ///< in table order: those either calibration estimated, and those whose values differ
  Consistency consistency;
};

/// Compares b with a. Their errors count as independent; one without a covariance counts as the truth.
Comparison compare(const Calibration& a, const Calibration& b);

}  // namespace imulab
