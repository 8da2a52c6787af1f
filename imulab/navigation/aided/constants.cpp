#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/setup.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace imulab {

std::string showing_manoeuvre(const std::string& c) {
  if (c.ends_with("lever_arm.up")) return "roll or pitch: a slope, a bank, braking";
  if (c.ends_with("lever_arm.right") || c.ends_with("lever_arm.forward")) return "turns in both directions";
  if (c.ends_with("delay") || c.ends_with("drift")) return "changes of speed, and turns";
  if (c.ends_with("mounting.pitch") || c.ends_with("mounting.yaw")) return "a straight drive at speed";
  if (c == "gyro.matrix.zz") return "turns in both directions, of several full circles";
  if (c.starts_with("gyro.matrix") && c.ends_with("z")) return "turns in both directions";
  if (c.starts_with("gyro.matrix")) return "rotations about that axis: rolls and pitches of 30 deg and more, or turns by hand before the drive";
  if (c.starts_with("gyro.g_sensitivity")) return "figure eights and braking; rests on several faces";
  if (c == "accel.offset.z" || c == "accel.matrix.zz") return "rests upside down or on a side: level motion does not separate bias and scale factor";
  if (c.starts_with("accel.offset")) return "the same road in both directions, figure eights";
  if (c.starts_with("accel.matrix")) return "braking and turns in both directions; rests on several faces";
  if (c.starts_with("gyro.offset")) return "a minute at rest";
  if (c.ends_with("scale")) return "a straight drive at speed";
  return "";
}

namespace aided {
namespace {

/// Names of a block's elements.
std::vector<std::string> elements_of(const Problem& p, const StateBlock& b) {
  constexpr std::array<const char*, 3> axes{"x", "y", "z"}, body{"right", "forward", "up"};
  std::vector<std::string> out;
  for (Eigen::Index k = 0; k < b.size; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (b.name.ends_with("matrix") || b.name.ends_with("g_sensitivity"))
      out.push_back(fmt::format("{}.{}{}", b.name, axes[i % 3], axes[i / 3]));
    else if (b.name.ends_with("offset"))
      out.push_back(fmt::format("{}.{}", b.name, axes[i]));
    else if (b.name.ends_with("lever_arm"))
      out.push_back(fmt::format("{}.{}", b.name, body[i]));
    else if (b.name.ends_with("mounting"))
      out.push_back(fmt::format("{}.{}", b.name, i == 0 ? "pitch" : "yaw"));
    else if (p.terms && b.first == p.terms_first)
      out.push_back(p.terms->names[i]);
    else if (b.name.ends_with("delay"))
      out.push_back(i == 0 ? b.name : b.name + ".drift");
    else
      out.push_back(b.name);
  }
  return out;
}

}  // namespace

void use_factors(const AidedNavigation& out, Problem& p) {
  for (std::size_t k = 0; k < p.sources.size(); ++k) p.sources[k].factor = out.factors[k].factor * out.factors[k].lasting * out.factors[k].lasting;
}

void add_constants(const Problem& p, const SmootherPass& smoothed, AidedNavigation& out) {
  const Eigen::VectorXd& x = smoothed.nodes[smoothed.middle].state.x;
  const Eigen::MatrixXd& P = smoothed.middle_covariance;
  std::vector<Eigen::Index> states;
  for (const StateBlock& b : p.blocks) {
    if (std::isfinite(b.time)) continue;
    const std::vector<std::string> names = elements_of(p, b);
    for (Eigen::Index k = 0; k < b.size; ++k)
      if (const Eigen::Index at = b.first + k; b.prior[k] > 0) {
        out.constants.push_back({names[static_cast<std::size_t>(k)], x[at], std::sqrt(P(at, at)), b.prior[k]});
        states.push_back(at);
      }
  }
  out.constants_covariance = P(states, states);
}

void add_constants_with(const OutputTerms& terms, Problem& p, FilterStart start, AboutTrajectory& trajectory, AidedNavigation& out) {
  const Eigen::Index size = p.size, sensors_end = p.sensors_end;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(terms.sigma.size());
  p.terms = &terms;
  p.terms_first = add_block(p, {.name = "terms", .size = zero.size(), .prior = terms.sigma, .walk = {}, .noise = {}});
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
