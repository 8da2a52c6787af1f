// Is production steady? Control limits, run rules and capability of one coefficient over the units in the order in which they were measured.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// Whether a rule fires at more units than a steady production explains.
bool stands_out(const ControlChart& chart, std::size_t rule);

/// Values in the order of their times. Each has limits of its own: the spread between units and its own uncertainty, as in `fleet`.
ControlChart control_chart(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variances, const RandomEffects& fleet);

}  // namespace imulab
