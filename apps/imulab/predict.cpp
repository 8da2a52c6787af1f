// imulab predict PROCEDURE
#include "apps/imulab/command.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/estimate/turntable/tolerance.hpp"
#include "imulab/io/result/prediction.hpp"
#include "imulab/io/session/file.hpp"
#include "imulab/io/text/figures.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/io/text/terminal.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/report/prediction_page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

namespace imulab::command {

namespace {

struct Options {
  std::string procedure, method = "turntable", report;
  std::optional<std::string> require;
  std::uint64_t runs = 20000, seed = 1;
  bool classical = false, json = false, verbose = false;
};

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

std::vector<Requirement> requirements_of(const Options& options) {
  return options.require ? errors_at("--require", [&] { return parse_requirements(*options.require); }) : std::vector<Requirement>{};
}

std::string names_of(const std::vector<CoefficientIndex>& coefficients) {
  std::string names;
  for (const CoefficientIndex index : coefficients) names += fmt::format(" {}", coefficient(index).name);
  return names;
}

/// The turns that help most, where something is undetermined or not within its requirement.
std::optional<hybrid::Advice> advice_for(const hybrid::Plan& plan, const hybrid::Prediction& p, const std::vector<Shortfall>& missed,
                                         const std::vector<Requirement>& requirements) {
  if (missed.empty() && p.undetermined.empty()) return std::nullopt;
  return advise(plan, p, missed.empty() ? std::vector<Requirement>{} : requirements);
}

/// By any method but turntable, which has shares, Monte Carlo and tolerances.
void predict_by(const Method& chosen, const Options& options) {
  const std::vector<Requirement> requirements = requirements_of(options);
  const Session procedure = read_session(options.procedure);
  expect_others_stay(options.report, {procedure.file});
  errors_at(procedure.file, [&] { procedure.site.gravity(); });  // where neither g nor the latitude is known
  Prediction p;
  std::vector<Shortfall> missed;
  std::optional<hybrid::Advice> advice;
  if (chosen.name == "hybrid") {
    const hybrid::Plan plan = hybrid::plan_of(procedure);
    errors_at("--require", [&] { expect_estimated(requirements, plan); });
    const hybrid::Prediction own = predict(plan);
    missed = shortfalls(own, requirements);
    advice = advice_for(plan, own, missed, requirements);
    p = own;
  } else {
    p = chosen.predict(procedure);
    missed = shortfalls(p, requirements);
  }
  if (!options.report.empty()) {
    PredictionSummary summary{
        .coefficients = p.coefficients, .undetermined = p.undetermined, .sigma = p.sigma, .cramer_rao = p.cramer_rao, .missed = missed};
    if (advice) summary.advice = advice->turns;
    write_whole(options.report, prediction_page({.procedure = options.procedure, .summary = std::move(summary), .required = !requirements.empty()}));
  }
  if (options.json) {
    fmt::print("{}", prediction_json(p, missed, advice));
  } else {
    fmt::print("{}", prediction_table(p, requirements));
    if (advice) fmt::print("\n{}", advice_text(*advice));
    for (const Shortfall& s : missed) fmt::print("{}", text::wrapped("", shortfall_text(s)));
  }
  if (!p.undetermined.empty())
    throw Unsupported(fmt::format("the procedure does not determine:{}{}", names_of(p.undetermined), advice ? "; " + turns_text(*advice) : ""));
  if (!missed.empty()) throw Unsupported(fmt::format("the requirements are not met: {}", shortfall_text(missed.front())));
}

void run(const Options& options) {
  if (options.method != "turntable") return predict_by(method(options.method), options);
  const std::vector<Requirement> requirements = requirements_of(options);
  const Session procedure = read_session(options.procedure);
  expect_others_stay(options.report, {procedure.file});
  errors_at(procedure.file, [&] { procedure.site.gravity(); });  // where neither g nor the latitude is known
  turntable::Plan plan = turntable::plan_of(procedure);
  plan.classical = options.classical;
  errors_at("--require", [&] { expect_estimated(requirements, plan); });
  const turntable::Prediction prediction = predict(plan);
  std::optional<turntable::MonteCarloResult> sampled;
  if (options.runs > 0 && !prediction.coefficients.empty()) {
    Progress progress("Monte Carlo", static_cast<double>(options.runs));
    sampled = monte_carlo(plan, options.runs, options.seed, [&](std::uint64_t done) { progress.report(static_cast<double>(done)); });
  }
  std::vector<KnobAnswer> answers;
  std::vector<Shortfall> missed;
  if (!requirements.empty()) {
    answers = answers_to(requirements, plan);
    missed = shortfalls(plan, requirements);
  }
  if (!options.report.empty()) {
    PredictionSummary summary{.coefficients = prediction.coefficients,
                              .undetermined = prediction.undetermined,
                              .sigma = prediction.sigma,
                              .cramer_rao = prediction.cramer_rao,
                              .sources = prediction.sources,
                              .variance = prediction.variance,
                              .missed = missed};
    if (sampled) summary.monte_carlo = sampled->sigma, summary.runs = sampled->runs;
    write_whole(options.report, prediction_page({.procedure = options.procedure,
                                                 .summary = std::move(summary),
                                                 .tables = {requirements.empty() ? "" : tolerance_table(plan, missed, answers)},
                                                 .required = !requirements.empty()}));
  }
  if (options.json) {
    fmt::print("{}", prediction_json(prediction, sampled, missed, answers));
  } else {
    if (!requirements.empty()) fmt::print("{}\n", tolerance_table(plan, missed, answers));
    fmt::print("{}", prediction_table(prediction, sampled, options.verbose));
  }
  for (const std::string& text : plan.parts.warnings) warn(text);
  if (!prediction.undetermined.empty()) throw Unsupported(fmt::format("the procedure does not determine:{}", names_of(prediction.undetermined)));
  if (!answers.empty() && !answers.back().declared.factor)
    throw Unsupported("the requirements are not met with this procedure, not even with a hundredth of the declared table errors, timing and noise");
}

/// No Monte Carlo, or one of a useful and finite size.
std::string bad_runs(const std::string& text) {
  const bool digits = !text.empty() && text.size() < 10 && text.find_first_not_of("0123456789") == std::string::npos;
  const long runs = digits ? std::stol(text) : -1;
  return runs == 0 || (runs >= 100 && runs <= 10'000'000) ? "" : fmt::format("{}; expected 0, or 100 to 10000000", text);
}

}  // namespace

void add_predict(Verb app) {
  const auto options = std::make_shared<Options>();
  Verb verb = app.verb("predict", "Predict the uncertainties of a calibration and what limits them");
  verb.option("procedure", options->procedure, "the procedure or session to predict").required();
  std::vector<std::string> names;
  for (const Method& m : methods())
    if (m.predict != nullptr) names.emplace_back(m.name);
  verb.option("--method METHOD", options->method, "the method of the calibration; Monte Carlo and tolerances are of turntable alone")
      .one_of(names)
      .show_default();
  verb.option("--require LIMITS", options->require,
              "requirements, as in \"gyro.matrix.off_diagonal <= 5 arcsec, accel.offset <= 20 ug\"; finds which table, "
              "timing and noise meet them");
  const Option runs =
      verb.option("--runs", options->runs, "number of Monte Carlo procedures, at least 100; 0 for none").check(bad_runs).show_default();
  const Option seed = verb.option("--seed", options->seed, "random seed; the same seed gives the same result").show_default();
  const Option classical =
      verb.flag("--classical", options->classical, "Zhang 2010: weights from the sensors' noise alone, a separate gyro bias in turns");
  add_report_option(verb, options->report);
  verb.flag("--json", options->json, "print the result as JSON");
  verb.flag("-v,--verbose", options->verbose, "print also first and second order and the Monte Carlo, with more digits");
  verb.example("imulab procedure zhang-24 -o procedure.toml");
  verb.example("imulab predict procedure.toml --require \"gyro.matrix.off_diagonal <= 5 arcsec\"");
  verb.does([=] {
    for (const auto& [name, wanted] :
         {std::pair{"--runs", runs.given() && options->runs != 0}, {"--seed", seed.given()}, {"--classical", classical.given()}})
      if (options->method != "turntable" && wanted) throw Error(fmt::format("{}: belongs to --method turntable", name));
    run(*options);
  });
}

}  // namespace imulab::command
