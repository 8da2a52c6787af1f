#include "imulab/analysis/hybrid_advice.hpp"

#include "imulab/analysis/motion_information.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/recording/turn.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What is to be reached of the model's constants; infinite: nothing.
VectorXd targets(const InformationModel& model, const HybridPrediction& p, const std::vector<Requirement>& requirements) {
  const std::vector<int> of_state = corrected_coefficients(p.layout);
  VectorXd out = VectorXd::Constant(model.size(), std::numeric_limits<double>::infinity());
  for (Index i = 0; i < model.size(); ++i) {
    const Index state = model.constants[static_cast<std::size_t>(i)];
    const int index = of_state[static_cast<std::size_t>(state)];
    if (index < 0) continue;
    if (requirements.empty()) out[i] = 0.5 * p.prior[state];
    for (const Requirement& r : requirements)
      if (std::find(r.coefficients.begin(), r.coefficients.end(), index) != r.coefficients.end())
        out[i] = std::min({out[i], r.limit, 0.5 * p.prior[state]});
  }
  return out;
}

/// A turn about a table axis from an attitude, and where it leads.
struct Move {
  std::size_t axis;
  double angle;  // rad
};
constexpr std::array<double, 4> angles{90, 180, -90, -180};  // deg

struct Place {
  Matrix3d C_nb;
  RigAxes axes;
};

/// The outer axis carries the middle one, and that the inner one.
Place moved(Place p, const Move& m) {
  const Matrix3d turn = rotation_about(p.axes[m.axis], m.angle);
  for (std::size_t a = m.axis; a < 3; ++a) p.axes[a] = turn * p.axes[a];
  p.C_nb = turn * p.C_nb;
  return p;
}

std::string in_words(const Place& p, const Move& m) {
  const Vector3d& axis = p.axes[m.axis];
  const Vector3d body = p.C_nb.transpose() * axis;
  Index along;
  const double part = body.cwiseAbs().maxCoeff(&along);
  const double up = std::abs(axis.z());
  const char* stands = up > 0.999 ? "vertical" : (up < 0.045 ? "horizontal" : "inclined");
  const double angle = m.angle / unit::deg * (part > 0.999 && body[along] < 0 ? -1 : 1);
  if (part > 0.999) return fmt::format("turn by {:g} deg about the unit's {} axis while it is {}", angle, "xyz"[along], stands);
  return fmt::format("turn by {:g} deg about the {} axis, which is {} then", angle, to_string(static_cast<RigAxis>(m.axis)), stands);
}

struct Outcome {
  Knowledge knowledge;
  double worst = 0, sum = 0;  ///< ratio; logarithms of those above 1
};

Outcome outcome(Knowledge knowledge, const VectorXd& target) {
  const VectorXd ratio = sigma_of(knowledge).cwiseQuotient(target);
  return {std::move(knowledge), ratio.maxCoeff(), ratio.cwiseMax(1).array().log().sum()};
}

}  // namespace

HybridAdvice advise(const HybridPlan& plan, const HybridPrediction& prediction, const std::vector<Requirement>& requirements) {
  const InformationModel model = information_model(plan, prediction.layout, prediction.prior);
  const VectorXd target = targets(model, prediction, requirements);
  const Knowledge now = known(model, prediction);
  const Index n = model.size();
  const MatrixXd covariance = now.inverse().topLeftCorner(n, n);
  const VectorXd scale = target.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(scale.asDiagonal() * covariance * scale.asDiagonal()));
  const VectorXd direction = eigen.eigenvectors().col(n - 1).cwiseAbs();

  HybridAdvice out;
  out.ratio = std::sqrt(eigen.eigenvalues()[n - 1]);
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return direction[a] > direction[b]; });
  const std::vector<int> of_state = corrected_coefficients(prediction.layout);
  for (const Index i : order)
    if (direction[i] > 0.3 * direction.maxCoeff())
      out.coefficients.push_back(of_state[static_cast<std::size_t>(model.constants[static_cast<std::size_t>(i)])]);

  double rate = 10 * unit::deg, acceleration = default_acceleration_dps2 * unit::deg, rest = 60;
  for (const Step& step : plan.procedure.steps) {
    if (step.kind == StepKind::rotate) rate = step.rate, acceleration = step.acceleration.value_or(acceleration);
    if (step.kind == StepKind::hold) rest = step.end - step.start;
  }
  const int rest_s = std::max(5, static_cast<int>(std::lround(rest)));
  const auto done = [&](const Knowledge& before, const Place& p, const Move& m) {
    return after(after(before, turn_information(model, p.C_nb, {p.axes[m.axis], m.angle, rate, acceleration})),
                 rest_information(model, moved(p, m).C_nb, rest_s));
  };
  std::vector<Move> moves;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const double angle : angles) moves.push_back({axis, angle * unit::deg});
  const Place here{prediction.C_nb, prediction.axes};
  std::vector<Outcome> single(moves.size()), pair(moves.size() * moves.size());
  tbb::parallel_for(std::size_t{0}, moves.size(), [&](std::size_t k) {
    const Place there = moved(here, moves[k]);
    single[k] = outcome(done(now, here, moves[k]), target);
    for (std::size_t j = 0; j < moves.size(); ++j) pair[moves.size() * k + j] = outcome(done(single[k].knowledge, there, moves[j]), target);
  });
  const auto less = [](const Outcome& a, const Outcome& b) { return a.sum != b.sum ? a.sum < b.sum : a.worst < b.worst; };
  const std::size_t one = static_cast<std::size_t>(std::min_element(single.begin(), single.end(), less) - single.begin());
  const std::size_t two = static_cast<std::size_t>(std::min_element(pair.begin(), pair.end(), less) - pair.begin());
  const double before = outcome(now, target).sum;
  const bool enough = before - single[one].sum > 0.8 * (before - pair[two].sum);
  const std::size_t first = enough ? one : two / moves.size();
  out.turns.push_back(in_words(here, moves[first]));
  if (!enough) out.turns.push_back(in_words(moved(here, moves[first]), moves[two % moves.size()]));
  out.ratio_after = enough ? single[one].worst : pair[two].worst;
  return out;
}

std::vector<std::string> in_words(std::span<const TableTurn> turns) {
  Place place{Matrix3d::Identity(), ideal_axes()};
  std::vector<std::string> out;
  for (const TableTurn& turn : turns) {
    const Move move{static_cast<std::size_t>(turn.axis), turn.angle_deg * unit::deg};
    out.push_back(in_words(place, move));
    place = moved(place, move);
  }
  return out;
}

std::vector<Shortfall> shortfalls(const HybridPrediction& p, const std::vector<Requirement>& requirements) {
  std::vector<Shortfall> out;
  const auto named = [&](int index) { return std::any_of(out.begin(), out.end(), [&](const Shortfall& s) { return s.coefficient == index; }); };
  for (const Requirement& r : requirements)
    for (const int index : r.coefficients) {
      if (named(index)) continue;
      if (std::find(p.undetermined.begin(), p.undetermined.end(), index) != p.undetermined.end())
        out.push_back({r, index, std::numeric_limits<double>::infinity(), "the procedure does not determine it"});
      const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), index);
      if (found == p.coefficients.end()) continue;
      if (const double sigma = p.sigma[found - p.coefficients.begin()]; sigma > r.limit) out.push_back({r, index, sigma, {}});
    }
  return out;
}

void expect_estimated(const std::vector<Requirement>& requirements, const HybridPlan& plan) {
  for (const Requirement& r : requirements) {
    bool any = false;
    for (const int index : r.coefficients) {
      const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
      any = any || c.triad == Triad::gyro || c.term != Term::matrix || c.column <= c.row;
      if (c.term == Term::g_sensitivity && !plan.terms.g_sensitivity)
        throw Error(fmt::format(
            "--require: {}: this unit's calibration does not estimate it; g-sensitivity is that of a grade that has it, such as mems", r.selector));
    }
    if (!any)
      throw Error(fmt::format(
          "--require: {}: it is zero in the accelerometers' frame, which the method calibrates in: their matrix is lower triangular", r.selector));
  }
}

}  // namespace imulab
