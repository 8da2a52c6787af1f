#include "imulab/fleet/statistics/control.hpp"

#include "imulab/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

double upper_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

/// The number of scores from `begin` to `end` (not included) for which the condition holds.
template <class Is>
int count_of(const Eigen::ArrayXd& scores, Eigen::Index begin, Eigen::Index end, const Is& is) {
  int n = 0;
  for (Eigen::Index i = begin; i < end; ++i) n += is(scores[i]) ? 1 : 0;
  return n;
}

bool beyond_three(const Eigen::ArrayXd& z, Eigen::Index i) { return std::abs(z[i]) > 3; }

bool nine_on_one_side(const Eigen::ArrayXd& z, Eigen::Index i) {
  constexpr Eigen::Index run = 9;
  if (i + 1 < run) return false;
  const int above = count_of(z, i + 1 - run, i + 1, [](double s) { return s > 0; });
  return above == run || above == 0;
}

bool six_in_one_direction(const Eigen::ArrayXd& z, Eigen::Index i) {
  constexpr Eigen::Index run = 6;
  if (i + 1 < run) return false;
  int up = 0, down = 0;
  for (Eigen::Index k = i + 2 - run; k <= i; ++k) up += z[k] > z[k - 1], down += z[k] < z[k - 1];
  return up == run - 1 || down == run - 1;
}

bool two_of_three_beyond_two(const Eigen::ArrayXd& z, Eigen::Index i) {
  if (i < 2) return false;
  const double side = z[i] > 0 ? 1 : -1;
  return side * z[i] > 2 && (side * z[i - 1] > 2 || side * z[i - 2] > 2);
}

}  // namespace

const std::array<RunRule, run_rule_count>& run_rules() {
  static const double two = upper_tail(2);
  static const std::array<RunRule, run_rule_count> rules{{
      {"beyond 3 standard deviations", 2 * upper_tail(3)},
      {"nine in a row on one side", 2.0 / 512},
      {"six in a row up or down", 2.0 / 720},  // of the orders of six values, one rises and one falls
      {"two of three beyond 2 standard deviations", 2 * two * (1 - (1 - two) * (1 - two))},
  }};
  return rules;
}

bool stands_out(const ControlChart& chart, std::size_t rule) {
  const double expected = run_rules()[rule].false_alarm * static_cast<double>(chart.scores.size()),
               found = static_cast<double>(chart.fired[rule].size());
  const double cluster = rule == 0 ? 1 : 3;  // a run fires at several units, one after the other
  return found > expected + 4 * std::sqrt(cluster * expected) + cluster;
}

ControlChart control_chart(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variances, const RandomEffects& fleet) {
  ControlChart out{(values - fleet.mean) / (variances + fleet.spread * fleet.spread).sqrt(), {}};
  constexpr std::array<bool (*)(const Eigen::ArrayXd&, Eigen::Index), run_rule_count> fires{beyond_three, nine_on_one_side, six_in_one_direction,
                                                                                            two_of_three_beyond_two};
  for (Eigen::Index i = 0; i < out.scores.size(); ++i)
    for (std::size_t rule = 0; rule < run_rule_count; ++rule)
      if (fires[rule](out.scores, i)) out.fired[rule].push_back(i);
  return out;
}

Capability capability(const RandomEffects& fleet, double target, double limit) {
  const double off = fleet.mean - target;
  const auto ratio = [&](double room, double spread) {
    return spread > 0 ? room / (3 * spread) : std::copysign(std::numeric_limits<double>::infinity(), room);
  };
  Capability c{target,
               limit,
               ratio(limit, fleet.spread),
               ratio(limit, fleet.spread_high),
               ratio(limit, fleet.spread_low),
               ratio(limit - std::abs(off), fleet.spread),
               0};
  c.outside = fleet.spread > 0        ? upper_tail((limit - off) / fleet.spread) + upper_tail((limit + off) / fleet.spread)
              : std::abs(off) > limit ? 1.0
                                      : 0.0;
  return c;
}

}  // namespace imulab
