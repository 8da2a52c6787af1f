#include "imulab/tasks/predict.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/navigation/motion/mission.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/tasks/aid_files.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/tasks/content.hpp"
#include "imulab/tasks/plan.hpp"
#include "imulab/tasks/trajectory.hpp"

#include <fmt/format.h>

#include <utility>

namespace imulab {
namespace {

/// Everything that the Monte Carlo depends on.
std::string identity_of(const Session& procedure, const PredictionOptions& options) {
  std::vector<IdentityField> fields = content_of(procedure);
  for (const CoefficientIndex index : options.terms) fields.emplace_back("term", coefficient(index).name);
  fields.emplace_back("classical", options.classical ? "true" : "false");  // which has no effects
  fields.emplace_back("effects", options.effects ? "table" : "none");
  fields.emplace_back("runs", fmt::format("{}", options.runs));
  fields.emplace_back("seed", fmt::format("{}", options.seed));
  return work_identity("predict", fields);
}

std::string page_of(const Prediction& p, const std::string& procedure, const Conclusion& conclusion) {
  PredictionReport report{.procedure = procedure, .summary = summary_of(p), .conclusion = conclusion};
  if (p.tolerances) report.tables = {tolerance_table(*p.tolerances, p.missed)};
  return prediction_page(report);
}

/// No Monte Carlo, or one of a useful and finite size.
std::string bad_runs(const std::string& text) {
  const bool digits = !text.empty() && text.size() < 11 && text.find_first_not_of("0123456789") == std::string::npos;
  const long runs = digits ? std::stol(text) : -1;
  return runs == 0 || (runs >= 100 && runs <= 1'000'000'000) ? "" : fmt::format("{}; expected 0, or 100 to 1000000000", text);
}

}  // namespace

Verb& declare(Verb& command, PredictOptions& o) {
  Verb& verb = command.verb("predict", "Predict the uncertainties of a calibration and what limits them");
  verb.option("procedure", o.procedure, "the procedure or session to predict; of a drive the mission, with [[aid]]").required().reads();
  verb.option("--method METHOD", o.method,
              fmt::format("method of the calibration; Monte Carlo and tolerances only for {}", names_of_methods(&Method::takes_runs)))
      .one_of(offered_methods([](const Method& m) { return bool{m.predict}; }))
      .show_default();
  verb.option("--terms TERMS", o.terms, "coefficients to estimate, as for imulab calibrate; all others are taken as zero").show_default();
  effects_option(verb, o.effects);
  prior_option(verb, o.prior);
  verb.option("--require LIMITS", o.require,
              "limits, as in \"gyro.matrix.off_diagonal <= 5 arcsec, accel.bias <= 20 ug\"; on a turntable also finds the "
              "coarsest table, timing and noise that meet them; exit code 1 otherwise");
  verb.option("--runs", o.runs, "number of Monte Carlo procedures of a turntable, at least 100; 0 for none").check(bad_runs).show_default();
  seed_option(verb, o.seed);
  verb.option("--classical", o.classical, "Zhang's own estimator: weights from the sensors' noise alone, a separate gyro bias in rotations");
  verb.option("-o,--output FILE", o.output, "the part's file, with --part").writes().of_command();
  sharing_options(verb, o.shared);
  report_option(verb, o.report);
  json_option(verb, o.json);
  verb.option("-v,--verbose", o.verbose, "also print first and second order and the Monte Carlo, with more digits").of_command();
  verb.example("imulab procedure zhang-24 -o procedure.toml");
  verb.example("imulab predict procedure.toml --require \"gyro.matrix.off_diagonal <= 5 arcsec\"");
  return verb;
}

PredictionOptions task_of(const PredictOptions& o) {
  if (o.classical && !method(o.method).takes_runs) throw OptionError("classical", "belongs to --method " + names_of_methods(&Method::takes_runs));
  if (o.classical && o.terms != "auto") throw OptionError("terms", "Zhang's estimate is that of biases and matrices");
  if (o.shared.is_divided() && !method(o.method).takes_runs)
    throw OptionError("part", "belongs to --method " + names_of_methods(&Method::takes_runs));
  if (o.shared.is_divided() && o.runs == 0) throw OptionError("part", "divides a Monte Carlo; expected --runs");
  if (!o.output.empty() && o.shared.part.empty()) throw OptionError("output", "is the file of a --part; a prediction goes to standard output");
  PredictionOptions options{.terms = errors_of_option("terms", [&] { return parse_terms(o.terms); }),
                            .effects = o.effects == "table" && !o.classical,
                            .sizes = true,
                            .runs = o.runs,
                            .seed = o.seed,
                            .classical = o.classical};
  if (std::optional<Sharing> sharing = o.shared.sharing()) options.sharing = std::make_shared<Sharing>(*std::move(sharing));
  if (o.require) options.requirements = errors_of_option("require", [&] { return parse_requirements(*o.require); });
  return options;
}

ReadProcedure read_procedure(const std::string& name, std::string_view method_name) {
  return method(method_name).takes_aids ? procedure_of(read_mission(name), name) : ReadProcedure{read_session(name)};
}

ReadProcedure procedure_of(const MissionFile& file, const std::string& name) {
  ReadProcedure out;
  const motion::Trajectory motion = errors_at(name, [&] { return trajectory_of(file.mission); });
  out.motion = std::make_shared<const motion::NominalMotion>(nominal_motion(motion, 1 / file.mission.rate));
  Session& session = out.session;
  session.file = name, session.sha256 = file.sha256;
  session.imu = declared_imu(file, name, out.warnings);
  const NavigationState& start = out.motion->states.front();
  session.site.latitude = start.latitude, session.site.longitude = start.longitude, session.site.height = start.height;
  constexpr std::uint64_t any = 1;  // what the aids measure hardly matters
  simulate_aids(session, file.mission.aids, motion, any);
  return out;
}

std::string prediction_headline(const Prediction& p) {
  if (!p.undetermined.empty())
    return fmt::format("{} coefficient{} not determined, {} first", p.undetermined.size(), p.undetermined.size() == 1 ? " is" : "s are",
                       coefficient(p.undetermined.front()).name);
  const auto sigma = [&](CoefficientIndex index) { return sigma_of(index, p.coefficients, p.sigma); };
  std::string out;
  for (const auto& [name, triad] : {std::pair{"gyro", "gyro"}, std::pair{"accelerometer", "accel"}})
    if (const std::string worst = worst_terms(triad, sigma); !worst.empty())
      out += fmt::format("{}{} {}", out.empty() ? "worst axes: " : "; ", name, worst);
  return out.empty() ? "no bias or matrix is predicted" : out;
}

Conclusion conclusion_of(const Prediction& p, const std::vector<Requirement>& requirements) {
  return conclude(p.undetermined.empty() ? Verdict::none : Verdict::doubtful, prediction_headline(p), assess(p, requirements));
}

AnswerOf<Prediction> prediction_answer(std::string_view method_name, const Session& procedure, const std::string& name, PredictionOptions options,
                                       const std::optional<FleetPrior>& prior) {
  const Session session = prior ? with_sizes(procedure, *prior) : procedure;
  options.sizes = options.sizes && !prior;  // the prior is added to one sigma of each coefficient
  if (options.sharing) options.sharing->identity = identity_of(session, options);
  const auto p = [&] {
    try {
      Prediction prediction = predict(method(method_name), session, options);
      if (prior) add_prior(prediction, *prior), prediction.missed = shortfalls(prediction, options.requirements);
      return std::make_shared<const Prediction>(std::move(prediction));
    } catch (const TermsError& e) {
      throw OptionError("terms", e.what());
    }
  }();
  const Conclusion conclusion = conclusion_of(*p, options.requirements);
  return {{.json = [p] { return prediction_json(summary_of(*p)); },
           .table = [p, requirements = options.requirements](bool details) { return prediction_text(*p, requirements, details); },
           .page = [p, name, conclusion] { return page_of(*p, name, conclusion); },
           .warnings = p->warnings,
           .shortcomings = shortcomings(*p),
           .conclusion = conclusion},
          p};
}

std::string prediction_text(const Prediction& p, const std::vector<Requirement>& requirements, bool details) {
  std::string text = prediction_table(p, requirements, details);
  if (p.tolerances) return tolerance_table(*p.tolerances, p.missed) + "\n" + text;
  if (p.advice) text += "\n" + advice_text(*p.advice);
  return text;
}

std::string shortcomings(const Prediction& p) {
  if (!p.undetermined.empty()) {
    std::string names;
    for (const CoefficientIndex index : p.undetermined) names += fmt::format(" {}", coefficient(index).name);
    return fmt::format("the procedure does not determine:{}{}", names, p.advice ? "; " + turns_text(*p.advice) : "");
  }
  if (p.tolerances && !p.tolerances->answers.back().declared.factor)
    return "the requirements are not met with this procedure, not even with a hundredth of the declared table errors, timing and noise";
  if (p.missed.empty()) return "";
  return fmt::format("the requirements are not met: {}{}", shortfall_text(p.missed.front()),
                     p.tolerances ? "; they are with the table, timing and noise that were found" : "");
}

}  // namespace imulab
