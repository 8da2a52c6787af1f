#include "imulab/estimate/hybrid/prediction.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/hybrid/motion_information.hpp"
#include "imulab/estimate/hybrid/quality.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

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

/// Returns the sampling rate. Throws Error for several recordings.
double rate_of(const Session& procedure) { return kernel::only_source(procedure).rate_hz.value_or(default_sample_rate); }

}  // namespace

constexpr const char* no_hold = ": no hold among the steps; expected at least one, since the method needs rests";

Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  const std::string& file = procedure.file;
  if (procedure.steps.empty()) throw Error(file + no_hold);
  const double rate = rate_of(procedure);
  const NoiseModels noise = errors_at(file, [&] { return declared_noise(procedure.imu); });
  if (!(noise.accel.N > 0 && noise.gyro.N > 0))
    throw Error(file + ": a noise density of 0; expected densities above 0, since the uncertainties follow from them");
  return {procedure, errors_at(file, [&] { return place_of(procedure.site); }),
          in_place::noise_of(Vector3d::Constant(noise.gyro.N), Vector3d::Constant(noise.accel.N), noise, procedure.steps.back().end),
          terms_of(procedure, terms, {}, 1 / rate), on_turntable(procedure)};
}

FilterPrediction predict(const Plan& plan) {
  // The sampling rate does not matter as long as a sample turns by a small angle.
  // Ramps of turns determine lever arms if the session's rate resolves them: they take a fifth of a second.
  const double slowest = plan.terms.optional.contains(Group::lever_arm) ? std::clamp(rate_of(plan.procedure), 20.0, 100.0) : 20;
  const Recording recording = coarse_recording(plan.procedure, {earth_rate_enu(plan.place.latitude), plan.place.gravity}, slowest);
  const std::vector<Range> rests = in_place::still_parts(recording, rests_of(recording, plan.procedure).ranges);
  if (rests.empty()) throw Error(plan.procedure.file + no_hold);
  Data data{recording,
            in_place::cut_into_blocks(recording, rests, plan.observe_motion).blocks,
            plan.effects ? with_latitude_effect(plan.place, plan.procedure) : plan.place,
            plan.noise,
            SensorModel{},
            plan.terms};
  if (plan.effects) data.unmodeled = unmodeled_of(plan.procedure, recording, data.blocks, data.coarse, plan.terms.wanted, {}, true);
  const Iterate pass = repeated(data, first_iterate(data));
  const Errors errors = determined_errors(pass);

  Calibration calibration = calibration_of(data, pass);
  calibration.quality.sources.push_back(kernel::gravity_source(plan.procedure.site));
  FilterPrediction out{prediction_of(calibration), pass.states, pass.pass.covariance, pose_at_end(plan.procedure.steps)};
  const MatrixXd jacobian = correction_jacobian(SensorModel{}, errors.coefficients, out.states);
  const Index n = out.states.constants();
  const MatrixXd by_undetermined = errors.covariance - out.covariance.topLeftCorner(n, n);
  VectorXd bound = out.sigma.cwiseAbs2();
  bound.head(jacobian.rows()) -= (jacobian * by_undetermined * jacobian.transpose()).diagonal();
  out.cramer_rao = bound.cwiseSqrt();
  std::vector<Index> open;
  for (const Index state : errors.undetermined)
    if (contains(errors.open, out.states.corrects(state))) open.push_back(state);
  out.remaining = out.covariance.diagonal()(open).cwiseSqrt();
  return out;
}

Prediction predict(const Session& procedure, const PredictionOptions& options) {
  Plan plan = plan_of(procedure, options.terms);
  plan.effects = options.effects;
  expect_estimated(options.requirements, plan);
  const FilterPrediction filter = predict(plan);
  Prediction out = filter;
  out.missed = shortfalls(out, options.requirements);
  if (options.advice && (!out.missed.empty() || !out.undetermined.empty()))
    out.advice = advise(plan, filter, out.missed.empty() ? std::vector<Requirement>{} : options.requirements);
  return out;
}

void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan) {
  for (const Requirement& r : requirements) {
    bool any = false;
    for (const CoefficientIndex index : r.coefficients) {
      any = any || !zero_by_frame(index);
      if (!plan.terms.wanted.empty() && !contains(plan.terms.wanted, index))
        throw Error(fmt::format("{}: {} is not among the terms to be estimated", r.selector, coefficient(index).name));
    }
    if (!any)
      throw Error(
          fmt::format("{}: it is zero in the accelerometers' frame, which the method calibrates in: their matrix is lower triangular", r.selector));
  }
}

namespace {

/// Returns the limits of the model's constants; infinite: none.
VectorXd targets(const InformationModel& model, const std::vector<Requirement>& requirements) {
  VectorXd out = model.states.needed()(model.constants);
  if (requirements.empty()) return out;
  constexpr double unlimited = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < model.size(); ++i) {
    double limit = unlimited;
    for (const Requirement& r : requirements)
      if (contains(r.coefficients, model.states.corrects(model.constants[static_cast<std::size_t>(i)]))) limit = std::min(limit, r.limit);
    out[i] = limit < unlimited ? std::min(out[i], limit) : unlimited;
  }
  return out;
}

struct Outcome {
  Knowledge knowledge;
  double worst = 0, sum = 0;  ///< largest ratio; sum of the logarithms of ratios above 1
  bool operator<(const Outcome& other) const { return std::pair(sum, worst) < std::pair(other.sum, other.worst); }
};

Outcome outcome(Knowledge knowledge, const VectorXd& target) {
  const VectorXd ratio = sigma_of(knowledge).cwiseQuotient(target);
  return {std::move(knowledge), ratio.maxCoeff(), ratio.cwiseMax(1).array().log().sum()};
}

/// Returns the worst-determined direction.
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

Advice advise(const Plan& plan, const FilterPrediction& prediction, const std::vector<Requirement>& requirements) {
  const InformationModel model(plan);
  const VectorXd target = targets(model, requirements);
  const Knowledge now = knowledge_of(model, prediction);
  double rate = 10 * unit::deg, acceleration = default_acceleration_dps2 * unit::deg, rest = 60;  // as the last ones of the procedure
  for (const Step& step : plan.procedure.steps) {
    if (step.kind == StepKind::rotate) rate = step.rate, acceleration = step.acceleration.value_or(acceleration);
    if (step.kind == StepKind::hold) rest = std::max(5.0, step.end - step.start);
  }
  const auto with = [&](const Knowledge& before, const PoseOnTable& pose, const TableTurn& turn) {
    const Turn motion{pose.axis(turn), turn.angle_deg * unit::deg, rate, acceleration};
    return outcome(after(after(before, turn_information(model, pose.C_nb, motion)),
                         rest_information(model, turned(pose, turn).C_nb, used_seconds(model, static_cast<int>(std::lround(rest)), true))),
                   target);
  };
  std::vector<TableTurn> turns;
  for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner})
    for (const double angle : {90, 180, -90, -180}) turns.push_back({axis, angle, rest});
  const PoseOnTable& here = prediction.end;
  const std::size_t n = turns.size();
  std::vector<Outcome> single(n), pair(n * n);
  parallel_for(n, [&](std::size_t k) {
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

}  // namespace imulab::hybrid
