// How the filter's states correct a sensor model.
#pragma once

#include "imulab/estimate/hybrid_filter.hpp"

#include <vector>

namespace imulab {

/// The model whose output is that of `model` less the errors x: A0 <- (I - Ma) A0 - ba, A1 <- (I - Ma) A1, gyros alike.
SensorModel corrected(const SensorModel& model, const Eigen::VectorXd& x, const HybridLayout& layout);

/// Derivatives of the table coefficients `indices` of the corrected model by the states, at x = 0.
Eigen::MatrixXd correction_jacobian(const SensorModel& model, const std::vector<int>& indices, const HybridLayout& layout);

/// The table coefficient that a state corrects; -1 for the others.
std::vector<int> corrected_coefficients(const HybridLayout& layout);

}  // namespace imulab
