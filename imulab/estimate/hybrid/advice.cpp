#include "imulab/estimate/hybrid/advice.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid/motion_information.hpp"
#include "imulab/recording/turn.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The limits of the model's constants; unlimited: none.
VectorXd targets(const InformationModel& model, const std::vector<Requirement>& requirements) {
  VectorXd out = model.states.needed()(model.constants);
  if (requirements.empty()) return out;
  for (Index i = 0; i < model.size(); ++i) {
    double limit = unlimited;
    for (const Requirement& r : requirements)
      if (contains(r.coefficients, model.states.corrects(model.constants[static_cast<std::size_t>(i)]))) limit = std::min(limit, r.limit);
    out[i] = limit < unlimited ? std::min(out[i], limit) : unlimited;
  }
  return out;
}

/// An IMU on a table: its attitude, and the directions of the axes in n.
struct Pose {
  Matrix3d C_nb;
  RigAxes axes;
  const Vector3d& axis(const TableTurn& turn) const { return axes[static_cast<std::size_t>(turn.axis)]; }
};

/// The outer axis carries the middle one, and that the inner one.
Pose turned(Pose pose, const TableTurn& turn) {
  const Matrix3d rotation = rotation_about(pose.axis(turn), turn.angle_deg * unit::deg);
  for (auto a = static_cast<std::size_t>(turn.axis); a < 3; ++a) pose.axes[a] = rotation * pose.axes[a];
  pose.C_nb = rotation * pose.C_nb;
  return pose;
}

std::string in_words(const Pose& pose, const TableTurn& turn) {
  const Vector3d axis = pose.axis(turn), body = pose.C_nb.transpose() * axis;
  Index along;
  const bool of_body = body.cwiseAbs().maxCoeff(&along) > 0.999;
  const double up = std::abs(axis.z());
  const char* stands = up > 0.999 ? "vertical" : (up < 0.045 ? "horizontal" : "inclined");
  if (!of_body) return fmt::format("turn by {:g} deg about the {} axis, which is {} then", turn.angle_deg, to_string(turn.axis), stands);
  return fmt::format("turn by {:g} deg about the unit's {} axis while it is {}", body[along] < 0 ? -turn.angle_deg : turn.angle_deg, "xyz"[along],
                     stands);
}

struct Outcome {
  Knowledge knowledge;
  double worst = 0, sum = 0;  ///< ratio; logarithms of those above 1
  bool operator<(const Outcome& other) const { return std::pair(sum, worst) < std::pair(other.sum, other.worst); }
};

Outcome outcome(Knowledge knowledge, const VectorXd& target) {
  const VectorXd ratio = sigma_of(knowledge).cwiseQuotient(target);
  return {std::move(knowledge), ratio.maxCoeff(), ratio.cwiseMax(1).array().log().sum()};
}

/// The worst-determined direction.
Advice worst_direction(const InformationModel& model, const Knowledge& now, const VectorXd& target) {
  const Index n = model.size();
  const VectorXd scale = target.cwiseInverse();
  const SymmetricEigen eigen = symmetric_eigen(scale.asDiagonal() * inverse_of(now).topLeftCorner(n, n) * scale.asDiagonal());
  const VectorXd direction = eigen.vectors.col(n - 1).cwiseAbs();
  Advice out;
  out.ratio = std::sqrt(eigen.values[n - 1]);
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return direction[a] > direction[b]; });
  for (const Index i : order)
    if (direction[i] > 0.3 * direction.maxCoeff()) out.coefficients.push_back(model.states.corrects(model.constants[static_cast<std::size_t>(i)]));
  return out;
}

}  // namespace

Advice advise(const Plan& plan, const Prediction& prediction, const std::vector<Requirement>& requirements) {
  const InformationModel model(plan);
  const VectorXd target = targets(model, requirements);
  const Knowledge now = knowledge_of(model, prediction);
  double rate = 10 * unit::deg, acceleration = default_acceleration_dps2 * unit::deg, rest = 60;  // as the procedure's last ones
  for (const Step& step : plan.procedure.steps) {
    if (step.kind == StepKind::rotate) rate = step.rate, acceleration = step.acceleration.value_or(acceleration);
    if (step.kind == StepKind::hold) rest = std::max(5.0, step.end - step.start);
  }
  const auto with = [&](const Knowledge& before, const Pose& pose, const TableTurn& turn) {
    const Turn motion{pose.axis(turn), turn.angle_deg * unit::deg, rate, acceleration};
    return outcome(after(after(before, turn_information(model, pose.C_nb, motion)),
                         rest_information(model, turned(pose, turn).C_nb, static_cast<int>(std::lround(rest)))),
                   target);
  };
  std::vector<TableTurn> turns;
  for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner})
    for (const double angle : {90, 180, -90, -180}) turns.push_back({axis, angle, rest});
  const Pose here{prediction.C_nb, prediction.axes};
  const std::size_t n = turns.size();
  std::vector<Outcome> single(n), pair(n * n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t k) {
    single[k] = with(now, here, turns[k]);
    for (std::size_t j = 0; j < n; ++j) pair[n * k + j] = with(single[k].knowledge, turned(here, turns[k]), turns[j]);
  });
  const auto one = std::min_element(single.begin(), single.end()), two = std::min_element(pair.begin(), pair.end());
  const double before = outcome(now, target).sum;
  const bool enough = before - one->sum > 0.8 * (before - two->sum);
  const auto best_pair = static_cast<std::size_t>(two - pair.begin());
  const TableTurn& first = turns[enough ? static_cast<std::size_t>(one - single.begin()) : best_pair / n];
  Advice out = worst_direction(model, now, target);
  out.turns.push_back(in_words(here, first));
  if (!enough) out.turns.push_back(in_words(turned(here, first), turns[best_pair % n]));
  out.ratio_after = enough ? one->worst : two->worst;
  return out;
}

std::vector<std::string> in_words(std::span<const TableTurn> turns) {
  Pose pose{Matrix3d::Identity(), ideal_axes()};
  std::vector<std::string> out;
  for (const TableTurn& turn : turns) {
    out.push_back(in_words(pose, turn));
    pose = turned(pose, turn);
  }
  return out;
}

std::vector<Shortfall> shortfalls(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::vector<Shortfall> out;
  std::vector<CoefficientIndex> named;
  for (const Requirement& r : requirements)
    for (const CoefficientIndex index : r.coefficients) {
      if (contains(named, index)) continue;
      const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), index);
      const double sigma = found != p.coefficients.end() ? p.sigma[found - p.coefficients.begin()] : contains(p.undetermined, index) ? unlimited : 0;
      if (sigma <= r.limit) continue;
      out.push_back({r, index, sigma, std::isinf(sigma) ? "the procedure does not determine it" : ""});
      named.push_back(index);
    }
  return out;
}

void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan) {
  for (const Requirement& r : requirements) {
    bool any = false;
    for (const CoefficientIndex index : r.coefficients) {
      const Coefficient& c = coefficient(index);
      any = any || c.triad == Triad::gyro || c.term != Term::matrix || c.column <= c.row;
      if (c.term == Term::g_sensitivity && !plan.terms.contains(Group::g_sensitivity))
        throw Error(
            fmt::format("{}: this unit's calibration does not estimate it; g-sensitivity is that of a grade that has it, such as mems", r.selector));
    }
    if (!any)
      throw Error(
          fmt::format("{}: it is zero in the accelerometers' frame, which the method calibrates in: their matrix is lower triangular", r.selector));
  }
}

}  // namespace imulab::hybrid
