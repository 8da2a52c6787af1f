#include "imulab/model/forward_model.hpp"

#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Returns a unit in counts with zeros far from 0, so that nonlinearity shifts every coefficient.
SensorModel nonlinear_unit() {
  SensorModel model;
  model.accel.matrix << 1e-3, 2e-6, -1e-6, 3e-6, 1.1e-3, 1e-6, -2e-6, 1e-6, 0.9e-3;
  model.gyro.matrix << 1e-5, 2e-8, -1e-8, 3e-8, 1.1e-5, 1e-8, -2e-8, 1e-8, 0.9e-5;
  model.accel.offset << 0.2, -0.3, 0.1;
  model.gyro.offset << 1e-3, 2e-3, -1e-3;
  model.accel.quadratic << 1e-10, -2e-10, 1e-10;
  model.accel.cubic << 1e-15, 2e-15, -1e-15;
  model.gyro.quadratic << 1e-13, 2e-13, -1e-13;
  model.gyro.cubic << 1e-19, -1e-19, 2e-19;
  model.g_sensitivity << 1e-5, 2e-5, 1e-5, -1e-5, 1e-5, 2e-5, -2e-5, 1e-5, 3e-5;
  return model;
}

TEST(ForwardModel, GoesThereAndBack) {
  const SensorModel model = nonlinear_unit(), again = backward(forward(model));
  for (const CoefficientIndex index : coefficient_indices()) {
    const double value = coefficient_value(model, index);
    EXPECT_NEAR(coefficient_value(again, index), value, 1e-12 * std::abs(value) + 1e-15) << coefficient(index).name;  // rounding
  }
}

TEST(ForwardModel, DerivativesAreThoseOfDifferences) {
  const SensorModel model = nonlinear_unit();
  const VectorXd v = forward(model);
  std::vector<CoefficientIndex> all;
  for (const CoefficientIndex index : coefficient_indices())
    if (const Term term = coefficient(index).term; term != Term::thermal && term != Term::lever_arm) all.push_back(index);
  const Eigen::MatrixXd derivatives = backward_derivatives(model, all);
  for (Index column = 0; column < Forward::all; ++column) {
    if (column >= Forward::turning_bias && column < Forward::nonlinearity) continue;
    // The maps are polynomials except for inverses of matrices, which are linear to 1e-12 over a millionth of a column.
    const double step = 1e-6 * std::max(std::abs(v[column]), column < Forward::nonlinearity ? 1.0 : 0.0);
    const SensorModel up = backward(v + step * VectorXd::Unit(v.size(), column)), down = backward(v - step * VectorXd::Unit(v.size(), column));
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double difference = (coefficient_value(up, all[i]) - coefficient_value(down, all[i])) / (2 * step);
      const double size = std::abs(coefficient_value(model, all[i])) / step;  // rounding of the difference is 1e-16 of this
      EXPECT_NEAR(derivatives(static_cast<Index>(i), column), difference, 1e-6 * std::abs(difference) + 1e-14 * size)
          << coefficient(all[i]).name << " by column " << column;
    }
  }
}

}  // namespace
}  // namespace imulab
