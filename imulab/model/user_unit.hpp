// Customary units of coefficients' differences and uncertainties. For matrices they are those of D = M_b M_a^-1 - I.
#pragma once

#include "imulab/model/coefficient.hpp"

#include <span>
#include <string_view>

namespace imulab {

struct UserUnit {
  std::string_view name;
  double size;  ///< SI
};

/// Every unit that a coefficient's differences may be given in, the usual one first; none for terms whose unit depends on the raw readings.
std::span<const UserUnit> user_units(const Coefficient& coefficient);

/// The customary unit of this coefficient's differences; `size` is the largest of its term [SI].
UserUnit user_unit(const Coefficient& coefficient, double size);

/// The same where the readings are in SI, which gives quadratic and cubic terms units of their own: those of a prediction.
UserUnit user_unit_of_si(const Coefficient& coefficient, double size);

}  // namespace imulab
