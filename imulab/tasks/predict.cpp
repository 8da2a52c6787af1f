#include "imulab/tasks/predict.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/estimate/turntable/tolerance.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/tasks/content.hpp"

#include <fmt/format.h>

#include <utility>

namespace imulab {
namespace {

std::vector<KnobAnswer> answers_to(const std::vector<Requirement>& requirements, const turntable::Plan& plan) {
  std::vector<KnobAnswer> answers{
      {turntable::Knob::table, {}, {}}, {turntable::Knob::timing, {}, {}}, {turntable::Knob::imu, {}, {}}, {turntable::Knob::all, {}, {}}};
  parallel_for(2 * answers.size() - 1, [&](std::size_t k) {
    KnobAnswer& a = answers[k / 2];
    if (k % 2 == 0)
      a.declared = tolerance(plan, a.knob, requirements);
    else
      a.alone = tolerance_alone(plan, a.knob, requirements);
  });
  return answers;
}

/// Everything that the Monte Carlo depends on.
std::string identity_of(const Session& procedure, const PredictionTask& task) {
  std::vector<IdentityField> fields = content_of(procedure);
  for (const CoefficientIndex index : task.terms) fields.emplace_back("term", coefficient(index).name);
  fields.emplace_back("classical", task.classical ? "true" : "false");
  fields.emplace_back("runs", fmt::format("{}", task.runs));
  fields.emplace_back("seed", fmt::format("{}", task.seed));
  return work_identity("predict", fields);
}

PredictedProcedure::OnTurntable predict_turntable(const Session& procedure, const PredictionTask& task) {
  PredictedProcedure::OnTurntable out;
  out.plan = turntable::plan_of(procedure, task.terms);
  if (task.classical) out.plan = classical(std::move(out.plan));
  expect_estimated(task.requirements, out.plan);
  out.prediction = predict(out.plan);
  std::optional<Checkpoint> checkpoint = task.checkpoint;
  if (checkpoint) checkpoint->identity = identity_of(procedure, task);
  if (task.runs > 0 && !out.prediction.coefficients.empty())
    out.monte_carlo = monte_carlo(
        out.plan, task.runs, task.seed,
        [&](std::uint64_t done) {
          if (task.progress) task.progress(static_cast<double>(done) / static_cast<double>(task.runs));
        },
        checkpoint ? &*checkpoint : nullptr);
  if (!task.requirements.empty()) out.answers = answers_to(task.requirements, out.plan);
  return out;
}

}  // namespace

PredictedProcedure predict(const Session& procedure, const PredictionTask& task) {
  const Method& chosen = method(task.method);
  errors_at(procedure.file, [&] { procedure.site.gravity(); });  // where neither g nor the latitude is known
  PredictedProcedure out;
  out.required = !task.requirements.empty();
  if (chosen.name == "turntable") {
    out.on_turntable = predict_turntable(procedure, task);
    out.prediction = out.on_turntable->prediction;
    if (out.required) out.missed = shortfalls(out.on_turntable->plan, task.requirements);
    if (out.on_turntable->monte_carlo) out.runs = out.on_turntable->monte_carlo->runs;
    return out;
  }
  if (chosen.predict == nullptr) throw Error(fmt::format("the method {} has no prediction", chosen.name));
  if (chosen.name != "hybrid") {
    out.prediction = chosen.predict(procedure, task.terms);
    out.missed = shortfalls(out.prediction, task.requirements);
    return out;
  }
  const hybrid::Plan plan = hybrid::plan_of(procedure, task.terms);
  expect_estimated(task.requirements, plan);
  const hybrid::Prediction own = predict(plan);
  out.missed = shortfalls(own, task.requirements);
  if (!out.missed.empty() || !own.undetermined.empty())
    out.advice = advise(plan, own, out.missed.empty() ? std::vector<Requirement>{} : task.requirements);
  out.prediction = own;
  return out;
}

namespace {

PredictionSummary summary_of(const PredictedProcedure& p) {
  if (const auto& t = p.on_turntable) return summary_of(t->prediction, t->monte_carlo, p.missed, t->answers);
  return summary_of(p.prediction, p.missed, p.advice);
}

}  // namespace

std::string prediction_json(const PredictedProcedure& p) { return prediction_json(summary_of(p)); }

std::string prediction_text(const PredictedProcedure& p, const std::vector<Requirement>& requirements, bool details) {
  if (const auto& t = p.on_turntable)
    return (p.required ? tolerance_table(t->plan, p.missed, t->answers) + "\n" : "") + prediction_table(t->prediction, t->monte_carlo, details);
  std::string text = prediction_table(p.prediction, requirements);
  if (p.advice) text += "\n" + advice_text(*p.advice);
  for (const Shortfall& s : p.missed) text += text::wrapped("", shortfall_text(s));
  return text;
}

std::string prediction_page(const PredictedProcedure& p, const std::string& procedure) {
  PredictionReport report{.procedure = procedure, .summary = summary_of(p), .required = p.required};
  if (const auto& t = p.on_turntable) report.tables = {p.required ? tolerance_table(t->plan, p.missed, t->answers) : ""};
  return prediction_page(report);
}

std::string shortcomings(const PredictedProcedure& p) {
  if (!p.prediction.undetermined.empty()) {
    std::string names;
    for (const CoefficientIndex index : p.prediction.undetermined) names += fmt::format(" {}", coefficient(index).name);
    return fmt::format("the procedure does not determine:{}{}", names, p.advice ? "; " + turns_text(*p.advice) : "");
  }
  if (const auto& t = p.on_turntable)
    return t->answers.empty() || t->answers.back().declared.factor
               ? ""
               : "the requirements are not met with this procedure, not even with a hundredth of the declared table errors, timing and noise";
  return p.missed.empty() ? "" : fmt::format("the requirements are not met: {}", shortfall_text(p.missed.front()));
}

}  // namespace imulab
