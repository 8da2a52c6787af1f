// Compares calibrations of one IMU, or calibrations with the truth, coefficient by coefficient, in sigmas and in user units.
//
// Example:
//   const Calibration spring = calibration, autumn = calibration;
//   const Comparison c = compare(spring, autumn);
//   if (c.consistency.p_value < 0.01) std::puts("the IMU, or a stated uncertainty, has changed");
//   for (const CoefficientDifference& d : c.coefficients)
//     if (d.sigmas().value_or(0) > significant_sigmas(c.coefficients.size())) std::puts(coefficient(d.index).name.data());
//
// Both calibrations are converted to the accelerometers' frame and to the reference temperatures of the first. Lever arms are compared relative to
// their mean point if both calibrations have all nine, because this point moves with the mounting. Errors that recur in every calibration of an IMU
// by one method cancel (Calibration::constant_covariance; an IMU is identified by name and serial number). All other errors count as independent,
// even those of a common declared g or table. Throws Error if thermal terms belong to readings in different units. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// One coefficient in two calibrations, both in the accelerometers' frame (quadratic and cubic terms are not rotated) and at the reference
/// temperatures of the first; SI unless stated otherwise.
struct CoefficientDifference {
  CoefficientIndex index;  ///< in the coefficient table
  double a = 0, b = 0;
  double difference = 0;              ///< b - a
  std::optional<double> uncertainty;  ///< standard uncertainty of `difference`; absent if a calibration did not determine the coefficient
  /// The difference in user units. For a matrix it is an element of D = M_b M_a^-1 - I, which does not depend on the raw unit: the difference of a
  /// scale factor [ppm] on the diagonal, of a misalignment [arcsec] off the diagonal.
  double user_difference = 0;
  std::optional<double> user_uncertainty;
  std::string_view user_unit;

  std::optional<double> sigmas() const;       ///< difference / uncertainty
  std::optional<double> user_sigmas() const;  ///< user_difference / user_uncertainty; equals sigmas() except for matrices
};

/// A coefficient whose difference is improbable given the differences of the other coefficients, in sigmas of its conditional distribution. Two
/// strongly correlated coefficients, such as offset and scale on a level road, may each agree but contradict each other.
struct DifferenceGivenOthers {
  CoefficientIndex index;
  double sigmas = 0;
};

/// Tests whether the differences agree with the stated covariances, by e^T P^-1 e over the coefficients that were estimated together.
struct Consistency {
  double chi2 = 0;
  int degrees_of_freedom = 0;  ///< 0: nothing can be tested
  double p_value = 1;          ///< probability of a chi-square at least this large
  /// If p_value is below `improbable_differences`: the coefficients that were left out, largest first, until the others agree.
  std::vector<DifferenceGivenOthers> differing = {};
};
inline constexpr double improbable_differences = 0.001;

struct Comparison {
  /// In table order: coefficients that a calibration estimated, and coefficients whose values differ.
  std::vector<CoefficientDifference> coefficients;
  Consistency consistency;
  std::optional<Vector3d> translation = {};  ///< displacement of the lever arms' mean point from a to b [m]; absent unless both have all nine
};

/// Compares b with a. A calibration without a covariance counts as the truth.
Comparison compare(const Calibration& a, const Calibration& b);

/// Compares each of `others` with a. Every comparison has the same coefficients in the same user units.
std::vector<Comparison> compare(const Calibration& a, const std::vector<Calibration>& others);

/// Probability that any of many tests of equal coefficients is called significant (Bonferroni, valid for any correlation).
inline constexpr double table_significance = 0.01;
double significant_sigmas(std::size_t tests);  ///< returns the number of sigmas beyond which a difference is significant among `tests` tests

/// Tests whether calibrations agree with one true value, by their squared distances from the mean weighted by the stated covariances.
struct Agreement {
  struct Coefficient {
    CoefficientIndex index;   ///< in the coefficient table
    Consistency consistency;  ///< test of this coefficient alone; for a matrix of the element of M M_first^-1, as in user_difference
    bool differs = false;     ///< significant among the tests of all coefficients
  };
  int calibrations = 0;                   ///< number of calibrations with uncertainties; a truth is not included
  std::vector<Coefficient> coefficients;  ///< in table order: coefficients that at least two calibrations estimated
  Consistency consistency;                ///< all coefficients: (N - 1) m degrees of freedom if all N estimated the same m
};

Agreement agreement(const std::vector<Calibration>& calibrations);  ///< `calibrations` without a covariance are not included

}  // namespace imulab
