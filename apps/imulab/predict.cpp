// imulab predict PROCEDURE
#include "imulab/tasks/predict.hpp"

#include "apps/imulab/checkpoint.hpp"
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/calibrate.hpp"

#include <fmt/core.h>

#include <memory>
#include <optional>
#include <string_view>

namespace imulab::command {

namespace {

struct Options {
  std::string procedure, method = "turntable", terms = "auto", report;
  std::optional<std::string> require;
  std::uint64_t runs = 20000, seed = 1;
  bool classical = false, json = false, verbose = false;
  CheckpointOptions shared;
};

void run(const Options& options) {
  PredictionOptions asked{.terms = errors_at("--terms", [&] { return parse_terms(options.terms); }),
                          .runs = options.runs,
                          .seed = options.seed,
                          .classical = options.classical,
                          .checkpoint = options.shared.checkpoint()};
  if (options.require) asked.requirements = errors_at("--require", [&] { return parse_requirements(*options.require); });
  const Session procedure = session_at(options.procedure);
  const Prediction prediction = [&] {
    Progress progress("Monte Carlo");
    asked.progress = [&progress](double part) { progress.report(part); };
    try {
      return predicted(options.method, procedure, asked);
    } catch (const TermsError& e) {
      throw Error(fmt::format("--terms: {}", e.what()));
    }
  }();
  if (options.shared.silent()) return;
  if (!options.report.empty()) write_whole(options.report, prediction_page(prediction, options.procedure, !asked.requirements.empty()));
  if (options.json)
    print_json(prediction_json(summary_of(prediction)));
  else
    print(prediction_text(prediction, asked.requirements, options.verbose));
  for (const std::string& text : prediction.warnings) warn(text);
  if (const std::string missing = shortcomings(prediction); !missing.empty()) throw Unsupported(missing);
}

/// No Monte Carlo, or one of a useful and finite size.
std::string bad_runs(const std::string& text) {
  const bool digits = !text.empty() && text.size() < 11 && text.find_first_not_of("0123456789") == std::string::npos;
  const long runs = digits ? std::stol(text) : -1;
  return runs == 0 || (runs >= 100 && runs <= 1'000'000'000) ? "" : fmt::format("{}; expected 0, or 100 to 1000000000", text);
}

}  // namespace

void add_predict(Verb app) {
  const auto options = std::make_shared<Options>();
  Verb verb = app.verb("predict", "Predict the uncertainties of a calibration and what limits them");
  verb.option("procedure", options->procedure, "the procedure or session to predict").required().reads();
  std::vector<std::string> names;
  for (const Method& m : methods())
    if (m.predict != nullptr) names.emplace_back(m.name);
  const std::string with_runs = names_of_methods(&Method::takes_runs);
  verb.option("--method METHOD", options->method, fmt::format("the method of the calibration; Monte Carlo and tolerances are of {} alone", with_runs))
      .one_of(names)
      .show_default();
  verb.option("--terms TERMS", options->terms, "as of imulab calibrate: the coefficients that it estimates; others are taken as exactly zero")
      .show_default();
  verb.option("--require LIMITS", options->require,
              "requirements, as in \"gyro.matrix.off_diagonal <= 5 arcsec, accel.offset <= 20 ug\"; finds which table, "
              "timing and noise meet them");
  const Option runs =
      verb.option("--runs", options->runs, "number of Monte Carlo procedures, at least 100; 0 for none").check(bad_runs).show_default();
  const Option seed = verb.option("--seed", options->seed, "random seed; the same seed gives the same result").show_default();
  const Option classical =
      verb.flag("--classical", options->classical, "Zhang 2010: weights from the sensors' noise alone, a separate gyro bias in turns");
  add_checkpoint_options(verb, options->shared);
  add_report_option(verb, options->report);
  verb.flag("--json", options->json, "print the result as JSON");
  verb.flag("-v,--verbose", options->verbose, "print also first and second order and the Monte Carlo, with more digits");
  verb.example("imulab procedure zhang-24 -o procedure.toml");
  verb.example("imulab predict procedure.toml --require \"gyro.matrix.off_diagonal <= 5 arcsec\"");
  verb.does([=] {
    for (const auto& [name, wanted] : {std::pair{"--runs", runs.given() && options->runs != 0},
                                       {"--seed", seed.given()},
                                       {"--classical", classical.given()},
                                       {"--checkpoint", !options->shared.folder.empty()}})
      if (wanted && !method(options->method).takes_runs) throw Error(fmt::format("{}: belongs to --method {}", name, with_runs));
    if (options->classical && options->terms != "auto") throw Error("--terms: Zhang's estimate is that of offsets and matrices");
    run(*options);
  });
}

}  // namespace imulab::command
