// Requirements on a calibration: "gyro.matrix.off_diagonal <= 5 arcsec", one sigma of each of these coefficients.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_value.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

struct Requirement {
  std::string selector;
  std::vector<CoefficientIndex> coefficients;
  double limit = 0;  ///< SI, above 0
  UserUnit unit;     ///< in which it was stated
};

/// "gyro.matrix.off_diagonal <= 5 arcsec"
std::string to_string(const Requirement& requirement);

/// Requirements separated by commas. Throws Error for text of another form, an unknown coefficient, one that cannot be required (all but offset,
/// matrix and g_sensitivity), a number that is not above 0, and a unit that the coefficients cannot have.
std::vector<Requirement> parse_requirements(std::string_view text);

/// Standard uncertainty of a coefficient, SI; of matrices relative to the row's scale; infinite where it was not estimated.
double relative_uncertainty(const Calibration& calibration, CoefficientIndex index);

/// Compares a calibration with a requirement: the standard uncertainty of the worst coefficient, for matrices relative to the row's scale. A
/// coefficient that was not estimated has infinite uncertainty; coefficients fixed by the frame are left out. A doubtful calibration meets none.
RequirementResult assess(const Calibration& calibration, const Requirement& requirement);

/// A requirement that is not met, by one of its coefficients.
struct Shortfall {
  Requirement requirement;
  CoefficientIndex coefficient;
  double sigma;        ///< of it, SI; infinite: the procedure does not determine it
  std::string source;  ///< of most of its variance, where that is known
};

}  // namespace imulab
