// Is production steady? Control limits, run rules and capability of one coefficient over the units in the order in which they were measured.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/fleet/statistics/random_effects.hpp"

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace imulab {

/// The rules of Nelson (1984) that apply to single values.
struct RunRule {
  std::string_view name;
  double false_alarm;  ///< probability that it fires at one unit of a steady production
};
inline constexpr std::size_t run_rule_count = 4;
const std::array<RunRule, run_rule_count>& run_rules();

struct ControlChart {
  Eigen::ArrayXd scores;  ///< of each unit: its difference from the mean in the standard deviation that it should have
  std::array<std::vector<Eigen::Index>, run_rule_count> fired;  ///< the units at which each rule fires
};

/// Whether a rule fires at more units than a steady production explains.
bool stands_out(const ControlChart& chart, std::size_t rule);

/// Values in the order of their times. Each has limits of its own: the spread between units and its own uncertainty, as in `fleet`.
ControlChart control_chart(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variances, const RandomEffects& fleet);

/// Capability of the units themselves, without the measurement uncertainty, for values that have to be within `limit` of `target`.
struct Capability {
  double target = 0, limit = 0;
  double cp = 0, cp_low = 0, cp_high = 0;  ///< limit / (3 spread); the interval is the spread's
  double cpk = 0;                          ///< (limit - |mean - target|) / (3 spread)
  double outside = 0;                      ///< the share of units that are outside, if they are normally distributed
};
Capability capability(const RandomEffects& fleet, double target, double limit);

}  // namespace imulab
