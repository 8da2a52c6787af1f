// Calibrations of one IMU, or calibrations and the truth, coefficient by coefficient: in sigmas and in user units.
//
// Example:
//   const Calibration spring = calibration, autumn = calibration;
//   const Comparison c = compare(spring, autumn);
//   if (c.consistency.p_value < 0.01) std::puts("the IMU, or a stated uncertainty, has changed");
//   for (const CoefficientDifference& d : c.coefficients)
//     if (d.sigmas().value_or(0) > significant_sigmas(c.coefficients.size())) std::puts(coefficient(d.index).name.data());
//
// Both are brought to the accelerometers' frame and to the reference temperatures of the first. Lever arms are compared about their mean point, where
// both calibrations have all nine: the same IMU mounted elsewhere on its table has others. What one IMU brings again in each calibration by one
// method cancels (Calibration::constant_covariance; one IMU: of the same name and serial number). Other errors are taken as independent: those of the
// same declared g or the same table are not removed. Throws Error where thermal terms belong to readings in different units. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// One coefficient in two calibrations, both in the accelerometers' frame (quadratic and cubic terms unrotated) and at the reference temperatures of
/// the first. SI, except where said.
struct CoefficientDifference {
  CoefficientIndex index;  ///< in the coefficient table
  double a = 0, b = 0;
  double difference = 0;              ///< b - a
  std::optional<double> uncertainty;  ///< standard uncertainty of the difference; absent where one of the two did not determine the coefficient
  /// The difference in user units. For matrices this is an element of D = M_b M_a^-1 - I, which does not depend on the raw unit: the difference of a
  /// scale factor in ppm on the diagonal, of a misalignment in arcsec off it.
  double user_difference = 0;
  std::optional<double> user_uncertainty;
  std::string_view user_unit;

  std::optional<double> sigmas() const;       ///< difference / uncertainty
  std::optional<double> user_sigmas() const;  ///< user_difference / user_uncertainty: the same except for matrices
};

/// A coefficient whose difference is unlike what those of the others make of it, in sigmas of the difference that they leave. Two that are uncertain
/// together, as offset and scale on a level road, may each agree and contradict each other.
struct DifferenceGivenOthers {
  CoefficientIndex index;
  double sigmas = 0;
};

/// Do the differences agree with the stated covariances? e^T P^-1 e over the coefficients estimated together.
struct Consistency {
  double chi2 = 0;
  int degrees_of_freedom = 0;  ///< 0: there is nothing to test
  double p_value = 1;          ///< probability of a chi-square at least this large
  /// Where p_value is below `improbable_differences`: what was left out, one after the other, until the rest is not, the most different first.
  std::vector<DifferenceGivenOthers> differing = {};
};
inline constexpr double improbable_differences = 0.001;

struct Comparison {
  std::vector<CoefficientDifference> coefficients;  ///< in table order: those any calibration estimated, and those whose values differ
  Consistency consistency;
  std::optional<Vector3d> translation = {};  ///< m: by which the lever arms' mean point moved from a to b; absent: not both have all nine
};

/// Compares b with a. A calibration without a covariance is taken as the truth.
Comparison compare(const Calibration& a, const Calibration& b);

/// Compares each of the others with a: the same coefficients in the same user units in every comparison.
std::vector<Comparison> compare(const Calibration& a, const std::vector<Calibration>& others);

/// The probability that any of many tests of equal coefficients is called significant (Bonferroni: for any correlation).
inline constexpr double table_significance = 0.01;
double significant_sigmas(std::size_t tests);  ///< a difference beyond this many sigmas is significant among this number of tests

/// Do calibrations agree with one truth? Their squared distances from its best estimate, the weighted mean under the stated covariances.
struct Agreement {
  struct Coefficient {
    CoefficientIndex index;   ///< in the coefficient table
    Consistency consistency;  ///< this one alone; of a matrix the element of M M_first^-1, as in user_difference
    bool differs = false;     ///< significant among all coefficients' tests
  };
  int calibrations = 0;                   ///< those that state uncertainties; a truth has its own comparison and takes no part
  std::vector<Coefficient> coefficients;  ///< in table order: those that two or more calibrations estimated
  Consistency consistency;                ///< over all: (N - 1) m degrees of freedom where all N estimated the same m
};

Agreement agreement(const std::vector<Calibration>& calibrations);

}  // namespace imulab
