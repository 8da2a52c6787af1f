#include "imulab/core/rotation.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

constexpr UserUnit metre{"m", 1}, degree{"deg", unit::deg}, second{"s", 1}, ppm{"ppm", unit::ppm}, gyro_bias{"deg/h", unit::deg_per_h},
    accel_bias{"mg", 1e-3 * unit::g}, by_force{"deg/h/g", unit::deg_per_h / unit::g};
constexpr std::string_view upside_down = "rests upside down or on a side: level motion does not separate bias and scale factor",
                           turns = "turns in both directions", straight = "a straight drive at speed", speed = "changes of speed, and turns";

/// The first that matches counts.
constexpr std::array quantities{
    ConstantQuantity{"gyro.offset.*", gyro_bias, "a minute at rest"},
    ConstantQuantity{"accel.offset.z", accel_bias, upside_down},
    ConstantQuantity{"accel.offset.*", accel_bias, "the same road in both directions, figure eights"},
    ConstantQuantity{"gyro.matrix.zz", ppm, "turns in both directions, of several full circles"},
    ConstantQuantity{"gyro.matrix.*z", ppm, turns},
    ConstantQuantity{"gyro.matrix.*", ppm, "rotations about that axis: rolls and pitches of 30 deg and more, or turns by hand before the drive"},
    ConstantQuantity{"accel.matrix.zz", ppm, upside_down},
    ConstantQuantity{"accel.matrix.*", ppm, "braking and turns in both directions; rests on several faces"},
    ConstantQuantity{"gyro.g_sensitivity.*", by_force, "figure eights and braking; rests on several faces"},
    ConstantQuantity{"*.lever_arm.up", metre, "roll or pitch: a slope, a bank, braking"},
    ConstantQuantity{"*.lever_arm.*", metre, turns},
    ConstantQuantity{"*.height_level", metre, ""},
    ConstantQuantity{"*.mounting.*", degree, straight},
    ConstantQuantity{"*.body.*", degree, "turns about two axes"},
    ConstantQuantity{"*.tilt.*", degree, "turns about level axes"},
    ConstantQuantity{"*imu.gyro_delay", second, turns},
    ConstantQuantity{"*.delay", second, speed},
    ConstantQuantity{"*.delay.drift", ppm, speed},
    ConstantQuantity{"pose*.scale", metre, "accelerations"},
    ConstantQuantity{"odometry*.scale", metre, "accelerations"},
    ConstantQuantity{"*.scale", ppm, straight},
    ConstantQuantity{"*", ppm, ""},
};

/// A * of the pattern stands for any characters.
bool matches(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() != '*') return !name.empty() && pattern.front() == name.front() && matches(pattern.substr(1), name.substr(1));
  return matches(pattern.substr(1), name) || (!name.empty() && matches(pattern, name.substr(1)));
}

}  // namespace

const ConstantQuantity& quantity_of_constant(std::string_view name) {
  return *std::ranges::find_if(quantities, [&](const ConstantQuantity& q) { return matches(q.names, name); });
}

std::vector<std::pair<std::string_view, std::vector<std::string>>> by_manoeuvre(const std::vector<std::string>& names) {
  std::vector<std::pair<std::string_view, std::vector<std::string>>> groups;
  for (const std::string& name : names) {
    const std::string_view manoeuvre = quantity_of_constant(name).manoeuvre;
    auto group = std::ranges::find_if(groups, [&](const auto& g) { return g.first == manoeuvre; });
    if (group == groups.end()) group = groups.insert(groups.end(), {manoeuvre, {}});
    group->second.push_back(name);
  }
  return groups;
}

namespace aided {

void use_factors(const AidedNavigation& out, Problem& p) {
  for (std::size_t k = 0; k < p.sources.size(); ++k) p.sources[k].factor = out.factors[k].factor * out.factors[k].lasting * out.factors[k].lasting;
}

namespace {

/// States the rotation of a tracked body and the scale of its positions as a whole: the states are what the first guess lacks.
void state_from_first_guess(const Channel& c, const Eigen::VectorXd& x, const std::vector<Eigen::Index>& states, AidedNavigation& out) {
  if (c.body < 0) return;
  const Vector3d turn = rotation_log(c.body_start * rotation_exp(x.segment<3>(c.body)));
  for (std::size_t k = 0; k < states.size(); ++k) {
    AidedConstant& constant = out.constants[k];
    if (const Eigen::Index element = states[k] - c.body; element >= 0 && element < 3) constant.value = turn[element];
    if (states[k] != c.scale) continue;
    const auto at = static_cast<Eigen::Index>(k);
    constant.value = c.scale_start * (1 + x[c.scale]), constant.sigma *= c.scale_start, constant.prior *= c.scale_start;
    out.constants_covariance.row(at) *= c.scale_start, out.constants_covariance.col(at) *= c.scale_start;
  }
}

}  // namespace

void add_constants(const Problem& p, const SmootherPass& smoothed, AidedNavigation& out) {
  const Eigen::VectorXd& x = smoothed.nodes[smoothed.middle].state.x;
  const Eigen::MatrixXd& P = smoothed.middle_covariance;
  std::vector<Eigen::Index> states;
  for (const StateBlock& b : p.blocks) {
    if (!is_result(p, b)) continue;
    for (Eigen::Index k = 0; k < b.size; ++k)
      if (const Eigen::Index at = b.first + k; b.prior[k] > 0) {
        out.constants.push_back({b.elements[static_cast<std::size_t>(k)], x[at], std::sqrt(P(at, at)), b.prior[k]});
        states.push_back(at);
      }
  }
  out.constants_covariance = P(states, states);
  for (const Channel& c : p.channels) state_from_first_guess(c, x, states, out);
}

void add_constants_with(const OutputTerms& terms, Problem& p, FilterStart start, AboutTrajectory& trajectory, AidedNavigation& out) {
  const Eigen::Index size = p.size, sensors_end = p.sensors_end;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(terms.sigma.size());
  p.terms = &terms;
  p.terms_first = add_block(p, {.name = "terms", .elements = terms.names, .size = zero.size(), .prior = terms.sigma, .walk = {}, .noise = {}});
  p.sensors_end = p.size;
  const Eigen::MatrixXd joint = p.joint;
  if (joint.size() > 0) p.joint.conservativeResizeLike(Eigen::MatrixXd::Zero(p.size, p.size));
  use_factors(out, p);
  const auto extend = [&](Eigen::VectorXd& x, const Eigen::VectorXd& by) { x = (Eigen::VectorXd(p.size) << x, by).finished(); };
  extend(start.mean.x, zero), extend(start.sigma, terms.sigma), extend(trajectory.x, zero);
  add_constants(p, smooth(p, filter(p, start, {.about = &trajectory})), out);
  p.blocks.pop_back();
  trajectory.x.conservativeResize(size);
  p.joint = joint, p.size = size, p.sensors_end = sensors_end, p.terms = nullptr;
}

void judge_heading(AidedNavigation& n) {
  if (n.covariance.back().value(2, 2) > largest_heading_sigma * largest_heading_sigma) n.findings.add<Code::heading_not_shown>();
}

}  // namespace aided

}  // namespace imulab
