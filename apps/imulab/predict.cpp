// imulab predict PROCEDURE
#include "imulab/analysis/requirement.hpp"
#include "imulab/analysis/turntable_prediction.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/prediction_text.hpp"
#include "imulab/io/session_file.hpp"
#include "imulab/io/terminal.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_unit.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include "apps/imulab/command.hpp"
#include <algorithm>
#include <cmath>
#include <memory>

namespace imulab::command {

namespace {

struct Options {
  std::string procedure, require;
  std::uint64_t runs = 20000, seed = 1;
  bool classical = false, json = false;
};

const Coefficient& row_of(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

/// A source's name as a narrow column's.
std::string heading(const std::string& source) {
  if (source == "orthogonality") return "orth.";
  if (source == "gravity") return "g";
  if (source == "accelerometer noise") return "acc noise";
  if (source == "accelerometer turn-on") return "acc on";
  if (source == "gyro turn-on") return "gyro on";
  if (source == "undetermined coefficients") return "undet.";
  return source;
}

void print_prediction(const TurntablePrediction& p, const std::optional<MonteCarloResult>& monte_carlo) {
  const Eigen::VectorXd sigma = p.sigma(), first = p.first_order();
  const bool second = (p.second_order.array() > 0.01 * first.array()).any();  // below, it changes nothing a person reads
  fmt::print("Standard uncertainty of every coefficient, and the share of each source in its variance (%)\n\n{:<22} {:<8} {:>11}", "coefficient", "unit",
             second ? "first order" : "closed form");
  if (second) fmt::print(" {:>9} {:>11}", "second", "closed form");
  if (monte_carlo) fmt::print(" {:>11}", "Monte Carlo");
  fmt::print("  |");
  for (const std::string& source : p.sources) fmt::print(" {:>{}}", heading(source), std::max<std::size_t>(5, heading(source).size()));
  fmt::print("\n");
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Coefficient& c = row_of(p.coefficients[i]);
    const UserUnit unit = user_unit(c, sigma[row]);
    fmt::print("{:<22} {:<8} {:>11.4g}", c.name, unit.name, first[row] / unit.size);
    if (second) fmt::print(" {:>9.2g} {:>11.4g}", p.second_order[row] / unit.size, sigma[row] / unit.size);
    if (monte_carlo) fmt::print(" {:>11.4g}", monte_carlo->sigma[row] / unit.size);
    fmt::print("  |");
    for (std::size_t k = 0; k < p.sources.size(); ++k)
      fmt::print(" {:>{}.1f}", 100 * p.variance(row, static_cast<Eigen::Index>(k)) / (first[row] * first[row]),
                 std::max<std::size_t>(5, heading(p.sources[k]).size()));
    fmt::print("\n");
  }
  if (second) fmt::print("\nSecond order: sigma of products of errors, not in the shares; its mean is taken out by calibrate.\n");
  if (monte_carlo) {
    const double worst = (monte_carlo->sigma.cwiseQuotient(sigma).array() - 1).abs().maxCoeff();
    fmt::print("\nMonte Carlo: {} procedures; at most {:.1f} % from the closed form, where {:.1f} % is one sigma of chance.\n", monte_carlo->runs, 100 * worst,
               100 * monte_carlo->sampling_sigma.maxCoeff());
  }
}

std::string in_user_unit(const Shortfall& s) {
  if (!std::isfinite(s.sigma)) return fmt::format("{} ({})", row_of(s.coefficient).name, s.source);
  const UserUnit& unit = s.requirement.unit;
  return fmt::format("{} <= {:g} {}: {} has {:.3g} {}, most of it from {}", s.requirement.selector, s.requirement.limit / unit.size, unit.name,
                     row_of(s.coefficient).name, s.sigma / unit.size, unit.name, s.source);
}

/// What the knob turns, at this factor.
std::string setting(const TurntablePlan& plan, Knob knob, double factor) {
  const TurntablePlan at = scaled(plan, knob, factor);
  const std::string table = fmt::format("{:.3g} arcsec (angle), {:.3g} arcsec (orthogonality), {:.3g} arcsec (zero)", at.rig.angle.value / unit::arcsec,
                                        at.rig.orthogonality.value / unit::arcsec, at.rig.zero.value / unit::arcsec);
  const std::string timing = fmt::format("{:.3g} ms", 1e3 * at.rig.timing.value);
  const std::string imu =
      fmt::format("{:.3g} deg/sqrt(h), {:.3g} ug/sqrt(Hz)", at.gyro_noise.N / unit::deg_per_sqrt_h, at.accel_noise.N / unit::ug_per_sqrt_hz);
  switch (knob) {
    case Knob::table:
      return table;
    case Knob::timing:
      return timing;
    case Knob::imu:
      return imu;
    case Knob::all:
      break;
  }
  return table + "; " + timing + "; " + imu;
}

std::string answer(const TurntablePlan& plan, Knob knob, const Tolerance& t) {
  if (!t.factor) {
    std::string reasons;
    for (const Shortfall& s : t.shortfalls) reasons += "\n      " + in_user_unit(s);
    return "none meets it: with a perfect one" + reasons;
  }
  return fmt::format("{}{:.3g} x declared: {}", t.unlimited ? "any up to " : "", *t.factor, setting(plan, knob, *t.factor));
}

std::string title(Knob knob) {
  switch (knob) {
    case Knob::table:
      return "coarsest table";
    case Knob::timing:
      return "latest turns";
    case Knob::imu:
      return "noisiest IMU";
    case Knob::all:
      break;
  }
  return "all three together";
}

void print_answers(const TurntablePlan& plan, const std::vector<Shortfall>& missed, const std::vector<KnobAnswer>& answers) {
  if (missed.empty()) fmt::print("\nAs declared, every requirement is met.\n");
  if (!missed.empty()) fmt::print("\nAs declared, these requirements are not met:\n");
  for (const Shortfall& s : missed) fmt::print("  {}\n", in_user_unit(s));
  fmt::print("\nWhat meets them all\n");
  for (const KnobAnswer& a : answers) {
    fmt::print("  {}\n", title(a.knob));
    if (a.alone) fmt::print("    all else perfect:     {}\n", answer(plan, a.knob, *a.alone));
    fmt::print("    {} {}\n", a.alone ? "all else as declared:" : "by one factor:       ", answer(plan, a.knob, a.declared));
  }
}

void run(const Options& options) {
  const std::vector<Requirement> requirements = options.require.empty() ? std::vector<Requirement>{} : parse_requirements(options.require);
  TurntablePlan plan = turntable_plan(read_session(options.procedure));
  plan.classical = options.classical;
  const TurntablePrediction prediction = predict(plan);
  std::optional<MonteCarloResult> sampled;
  if (options.runs > 0 && !prediction.coefficients.empty()) {
    Progress progress("Monte Carlo", options.runs);
    sampled = monte_carlo(plan, options.runs, options.seed, [&](std::uint64_t done) { progress.report(done); });
  }
  std::vector<KnobAnswer> answers;
  if (!requirements.empty()) {
    answers = {{Knob::table, {}, {}}, {Knob::timing, {}, {}}, {Knob::imu, {}, {}}, {Knob::all, {}, {}}};
    tbb::parallel_for(std::size_t{0}, 2 * answers.size() - 1, [&](std::size_t k) {
      KnobAnswer& a = answers[k / 2];
      if (k % 2 == 0)
        a.declared = tolerance(plan, a.knob, requirements);
      else
        a.alone = tolerance_alone(plan, a.knob, requirements);
    });
  }
  const std::vector<Shortfall> missed = requirements.empty() ? std::vector<Shortfall>{} : shortfalls(plan, requirements);
  if (options.json) {
    fmt::print("{}", prediction_json(prediction, sampled, missed, answers));
  } else {
    print_prediction(prediction, sampled);
    if (!requirements.empty()) print_answers(plan, missed, answers);
  }
  for (const std::string& note : plan.observations.notes) warn(note);
  std::string names;
  for (const int index : prediction.undetermined) names += fmt::format(" {}", row_of(index).name);
  if (!names.empty()) throw Unsupported(fmt::format("the procedure does not determine:{}", names));
  if (std::any_of(answers.begin(), answers.end(), [](const KnobAnswer& a) { return a.knob == Knob::all && !a.declared.factor; }))
    throw Unsupported("no table, timing and noise meet the requirements with this procedure");
}

}  // namespace

void add_predict(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("predict", "How good a turntable calibration will be, and what limits it, before any table time is spent");
  verb->add_option("procedure", options->procedure, "the procedure or session to predict")->required();
  verb->add_option("--require", options->require, "requirements, as in \"gyro.matrix.off_diagonal <= 5 arcsec, accel.offset <= 20 ug\": which table, "
                                                  "timing and noise meet them");
  verb->add_option("--runs", options->runs, "procedures of the Monte Carlo; 0 for none")->capture_default_str();
  verb->add_option("--seed", options->seed, "the same seed, the same bits")->capture_default_str();
  verb->add_flag("--classical", options->classical, "weights from the sensors' noise alone, and the gyros' bias in turns apart (Zhang 2010)");
  verb->add_flag("--json", options->json, "print the result for machines");
  verb->callback([options] { run(*options); });
}

}  // namespace imulab::command
