#include "imulab/estimate/turntable/tolerance.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::turntable {

using Eigen::Index;

namespace {

/// Returns the factor that counts as perfect: 1e-6 for table errors or timing, 1e-2 for noise (weights require some) and for all together.
double perfect_factor(Knob knob) { return knob == Knob::table || knob == Knob::timing ? 1e-6 : 1e-2; }

/// Replaces undeclared sizes by sizes that can be scaled.
Plan with_something_to_scale(Plan plan) {
  const ErrorSizes declared = error_sizes(plan);
  if (declared.angle == 0 && declared.orthogonality == 0 && declared.zero == 0)
    plan.rig.angle = plan.rig.orthogonality = plan.rig.zero = {unit::arcsec, false};
  if (declared.timing == 0) plan.rig.timing = {1e-3, false};
  return plan;
}

double shortest_hold(const Plan& plan) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Step& step : plan.parts.steps)
    if (step.kind == StepKind::hold) shortest = std::min(shortest, step.end - step.start);
  return shortest;
}

Tolerance search(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  const auto missed = [&](double factor) { return shortfalls(scaled(plan, knob, factor), requirements); };
  Tolerance out;
  double high = std::log(largest_factor(plan, knob)), low = std::log(perfect_factor(knob));
  out.shortfalls = missed(std::exp(low));
  if (!out.shortfalls.empty()) return out;
  out.unlimited = missed(std::exp(high)).empty();
  if (out.unlimited) low = high;
  // Uncertainties increase with every source, so the limit is a crossing; 0.5 % is finer than any declaration.
  while (high - low > 5e-3) {
    const double middle = 0.5 * (low + high);
    (missed(std::exp(middle)).empty() ? low : high) = middle;
  }
  out.factor = std::exp(low);
  out.sizes = error_sizes(scaled(plan, knob, *out.factor));
  return out;
}

/// Returns the coefficient that misses a requirement by most; empty if all meet it.
std::optional<Shortfall> shortfall(const Prediction& prediction, const Requirement& requirement) {
  std::optional<Shortfall> worst;
  for (const CoefficientIndex index : requirement.coefficients) {
    const StatedSigma stated = predicted(prediction, index);
    if (std::isinf(stated.sigma)) return Shortfall{requirement, index, stated.sigma, "the procedure does not determine it"};
    if (!stated.has_enough()) return Shortfall{requirement, index, stated.compared()};
    const Index row = std::find(prediction.coefficients.begin(), prediction.coefficients.end(), index) - prediction.coefficients.begin();
    if (stated.compared() <= (worst ? worst->sigma : requirement.limit)) continue;
    Index largest;
    const double share = prediction.variance.row(row).maxCoeff(&largest);
    const bool second = std::pow(prediction.second_order[row], 2) > share;
    worst = Shortfall{requirement, index, stated.compared(),
                      second ? "second order of the table's errors" : prediction.sources[static_cast<std::size_t>(largest)]};
  }
  return worst;
}

}  // namespace

void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan) {
  for (const Requirement& requirement : requirements)
    for (const CoefficientIndex index : requirement.coefficients)
      if (!contains(plan.terms, index))
        throw Error(fmt::format("{}: {} is not among the terms to be estimated", requirement.selector, coefficient(index).name));
}

std::vector<Shortfall> shortfalls(const Plan& plan, const std::vector<Requirement>& requirements) {
  const Prediction prediction = predict(plan);
  std::vector<Shortfall> out;
  for (const Requirement& requirement : requirements)
    if (const auto missed = shortfall(prediction, requirement)) out.push_back(*missed);
  return out;
}

ErrorSizes error_sizes(const Plan& plan) {
  const RigDeclaration& rig = plan.rig;
  const auto all_known = [](const auto& given) { return std::all_of(given.begin(), given.end(), [](const auto& axis) { return axis.has_value(); }); };
  const auto drawn = [](const Spread& spread, bool known = false) { return spread.fixed || known ? 0 : spread.value; };
  return {.angle = drawn(rig.angle),
          .orthogonality = drawn(rig.orthogonality, all_known(rig.given_orthogonality)),
          .zero = drawn(rig.zero, all_known(rig.given_zero)),
          .timing = drawn(rig.timing),
          .gyro_noise = plan.gyro_noise.N,
          .accel_noise = plan.accel_noise.N,
          .gyro_turn_on = plan.gyro_noise.turn_on.value,
          .accel_turn_on = plan.accel_noise.turn_on.value};
}

Plan scaled(Plan plan, Knob knob, double factor) {
  const auto scale = [&](Spread& spread) {  // a fixed error is known and adds no uncertainty
    if (!spread.fixed) spread.value *= factor;
  };
  if (knob == Knob::table || knob == Knob::all)
    for (Spread* spread : {&plan.rig.angle, &plan.rig.orthogonality, &plan.rig.zero}) scale(*spread);
  if (knob == Knob::timing || knob == Knob::all) scale(plan.rig.timing);
  if (knob == Knob::imu || knob == Knob::all)
    for (NoiseModel* noise : {&plan.accel_noise, &plan.gyro_noise}) {
      noise->N *= factor;
      noise->turn_on.value *= factor;  // includes a fixed turn-on bias, which the calibration has to estimate
    }
  plan.parts = table_plan(plan.parts.steps, plan.rig);
  return plan;
}

double largest_factor(const Plan& plan, Knob knob) {
  const ErrorSizes s = error_sizes(with_something_to_scale(plan));
  // A declared size is used as it is, even beyond these limits.
  const double table = std::max(1.0, 600 * unit::arcsec / std::max({s.angle, s.orthogonality, s.zero}));
  const double timing = std::max(1.0, std::min(10.0, 0.05 * shortest_hold(plan)) / s.timing), imu = 1e6;
  if (knob == Knob::all) return std::min({table, timing, imu});
  return knob == Knob::table ? table : knob == Knob::timing ? timing : imu;
}

Tolerance tolerance(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  return search(with_something_to_scale(plan), knob, requirements);
}

Tolerance tolerance_alone(const Plan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  Plan alone = with_something_to_scale(plan);
  for (const Knob other : {Knob::table, Knob::timing, Knob::imu})
    if (other != knob) alone = scaled(alone, other, perfect_factor(other));
  alone.site.given_gravity = alone.site.gravity();
  alone.site.given_gravity_sigma = 0;
  alone.site.latitude_sigma = 0;
  if (alone.effects) alone.effects->declared["site.latitude"] = alone.effects->declared["site.north"] = 0;
  if (!alone.site.latitude) alone.site.latitude = 45 * unit::deg;  // any latitude: the Earth's rate is then known
  return search(alone, knob, requirements);
}

namespace {

Tolerances tolerances_of(const Plan& plan, const std::vector<Requirement>& requirements) {
  Tolerances out{.declared = error_sizes(plan), .has_turns = !plan.parts.turns.empty(), .answers = {}};
  for (const Knob knob : {Knob::table, Knob::timing, Knob::imu, Knob::all}) out.answers.push_back({knob, {}, {}});
  parallel_for(2 * out.answers.size() - 1, [&](std::size_t k) {
    Tolerances::Answer& a = out.answers[k / 2];
    if (k % 2 == 0)
      a.declared = tolerance(plan, a.knob, requirements);
    else
      a.alone = tolerance_alone(plan, a.knob, requirements);
  });
  return out;
}

}  // namespace

Prediction predict(const Session& procedure, const PredictionOptions& options) {
  Plan plan = plan_of(procedure, options.terms);
  if (options.effects) plan.effects = kernel::effect_sizes(procedure);
  if (options.classical) plan = classical(std::move(plan));
  expect_estimated(options.requirements, plan);
  const bool is_part = options.runs > 0 && options.sharing && options.sharing->part;  // part of the Monte Carlo only
  Prediction out = is_part ? Prediction() : predict(plan);
  out.warnings = plan.parts.warnings;
  const auto progress = [&](std::uint64_t done) {
    if (options.progress) options.progress(static_cast<double>(done) / static_cast<double>(options.runs));
  };
  if (is_part || (options.runs > 0 && !out.coefficients.empty()))
    out.monte_carlo = monte_carlo(plan, options.runs, options.seed, progress, options.sharing ? &*options.sharing : nullptr);
  if (options.requirements.empty()) return out;
  out.missed = shortfalls(plan, options.requirements);
  out.tolerances = tolerances_of(plan, options.requirements);
  return out;
}

}  // namespace imulab::turntable
