// imulab predict PROCEDURE
#include "apps/imulab/command.hpp"
#include "apps/imulab/hybrid_table.hpp"
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

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

namespace imulab::command {

namespace {

struct Options {
  std::string procedure, method = "turntable";
  std::optional<std::string> require;
  std::uint64_t runs = 20000, seed = 1;
  bool classical = false, json = false;
};

const Coefficient& row_of(int index) { return coefficient_table()[static_cast<std::size_t>(index)]; }

/// A source's name as the two lines of a narrow column's head.
std::array<std::string, 2> heading(const std::string& source) {
  if (source == "orthogonality") return {"", "orth."};
  if (source == "gravity") return {"", "g"};
  if (source == "latitude") return {"", "lat."};
  if (source == "earth rate") return {"Earth", "rate"};
  if (source == "gyro noise") return {"gyro", "noise"};
  if (source == "accelerometer noise") return {"acc.", "noise"};
  if (source == "gyro turn-on") return {"gyro", "turn-on"};
  if (source == "accelerometer turn-on") return {"acc.", "turn-on"};
  if (source == undetermined_source) return {"not", "determ."};
  return {"", source};
}

/// One unit for all of a term.
std::vector<UserUnit> units_of(const TurntablePrediction& p) {
  const Eigen::VectorXd sigma = p.sigma();
  std::vector<UserUnit> units;
  for (const int index : p.coefficients) {
    double largest = 0;
    for (std::size_t k = 0; k < p.coefficients.size(); ++k)
      if (row_of(p.coefficients[k]).triad == row_of(index).triad && row_of(p.coefficients[k]).term == row_of(index).term)
        largest = std::max(largest, sigma[static_cast<Eigen::Index>(k)]);
    units.push_back(user_unit(row_of(index), largest));
  }
  return units;
}

/// The sampled sigmas in sigmas of the closed form, less what the Monte Carlo does not draw.
Eigen::ArrayXd sampled_ratio(const TurntablePrediction& p, const MonteCarloResult& monte_carlo) {
  Eigen::ArrayXd variance = p.sigma().array().square();
  for (std::size_t k = 0; k < p.sources.size(); ++k)
    if (p.sources[k] == undetermined_source) variance -= p.variance.col(static_cast<Eigen::Index>(k)).array();
  return monte_carlo.sigma.array() / variance.sqrt();
}

void print_prediction(const TurntablePrediction& p, const std::optional<MonteCarloResult>& monte_carlo) {
  if (p.coefficients.empty()) return;
  const Eigen::VectorXd sigma = p.sigma(), first = p.first_order();
  const std::vector<UserUnit> units = units_of(p);
  const bool second = (p.second_order.array() > 0.03 * first.array()).any();  // below, it changes nothing a person reads
  const auto width = [&](std::size_t source) {
    const auto head = heading(p.sources[source]);
    return std::max<std::size_t>({5, head[0].size(), head[1].size()});
  };
  fmt::print("Standard uncertainty of every coefficient, and the share of each source in its variance (%)\n\n");
  for (const std::size_t line : {0u, 1u}) {
    std::string text = fmt::format("{:<21} {:<7}", line == 0 ? "" : "coefficient", line == 0 ? "" : "unit");
    if (second) text += fmt::format(" {:>9} {:>9}", line == 0 ? "first" : "order", line == 0 ? "second" : "order");
    text += fmt::format(" {:>9}", line == 0 ? "closed" : "form");
    if (monte_carlo) text += fmt::format(" {:>9}", line == 0 ? "Monte" : "Carlo");
    text += "  |";
    for (std::size_t k = 0; k < p.sources.size(); ++k) text += fmt::format(" {:>{}}", heading(p.sources[k])[line], width(k));
    fmt::print("{}\n", text);
  }
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const UserUnit& unit = units[i];
    fmt::print("{:<21} {:<7}", row_of(p.coefficients[i]).name, unit.name);
    if (second) fmt::print(" {:>9.4g} {:>9.2g}", first[row] / unit.size, p.second_order[row] / unit.size);
    fmt::print(" {:>9.4g}", sigma[row] / unit.size);
    if (monte_carlo) fmt::print(" {:>9.4g}", monte_carlo->sigma[row] / unit.size);
    fmt::print("  |");
    for (std::size_t k = 0; k < p.sources.size(); ++k)
      fmt::print(" {:>{}.1f}", 100 * p.variance(row, static_cast<Eigen::Index>(k)) / (first[row] * first[row]), width(k));
    fmt::print("\n");
  }
  if (second)
    fmt::print("\nSecond order: sigma of the products of errors. It is in the closed form but not in the shares; its mean calibrate takes out.\n");
  const bool open = std::find(p.sources.begin(), p.sources.end(), undetermined_source) != p.sources.end();
  if (open) fmt::print("\nNot determ.: what coefficients that the procedure does not determine, left where they start, may do to the others.\n");
  if (monte_carlo) {
    const Eigen::ArrayXd off = (sampled_ratio(p, *monte_carlo) - 1).abs();
    Eigen::Index worst;
    const double most = off.maxCoeff(&worst);
    fmt::print("\nMonte Carlo: {} procedures{}. At most {:.1f} % from the closed form ({}), where one sigma of chance is {:.1f} %.\n",
               monte_carlo->runs, open ? ", without what is not determined" : "", 100 * most,
               row_of(p.coefficients[static_cast<std::size_t>(worst)]).name, 100 * monte_carlo->sampling_sigma[worst]);
  }
}

/// Three digits, the last rounded down: still within a limit.
std::string number(double x) {
  if (x <= 0) return "0";
  const double step = std::pow(10, std::floor(std::log10(x)) - 2), rounded = step * std::floor(x / step + 1e-9);
  return x >= 100 && x < 1e7 ? fmt::format("{:.0f}", rounded) : fmt::format("{:.3g}", rounded);
}

std::string text_of(const Shortfall& s) {
  const UserUnit& unit = s.requirement.unit;
  const std::string required = fmt::format("{} <= {:g} {}", s.requirement.selector, s.requirement.limit / unit.size, unit.name);
  const auto name = row_of(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{}: the procedure does not determine {}", required, name);
  return fmt::format("{}: {} has {:.3g} {}, most of it from {}", required, name, s.sigma / unit.size, unit.name, s.source);
}

std::string table_text(const TableSetting& s) {
  const std::array<std::pair<const char*, double>, 3> parts{{{"angle", s.angle}, {"orthogonality", s.orthogonality}, {"zero", s.zero}}};
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].second == 0) continue;
    const bool shared = k + 1 < parts.size() && parts[k + 1].second == parts[k].second;
    text += parts[k].first + (shared ? std::string(", ") : fmt::format(" {} arcsec, ", number(parts[k].second / unit::arcsec)));
  }
  return text.substr(0, text.size() - 2);
}

std::string noise_text(const TableSetting& s) {
  std::string text = fmt::format("noise {} deg/sqrt(h) and {} ug/sqrt(Hz)", number(s.gyro_noise / unit::deg_per_sqrt_h),
                                 number(s.accel_noise / unit::ug_per_sqrt_hz));
  if (s.gyro_turn_on > 0 || s.accel_turn_on > 0)
    text += fmt::format(", turn-on {} deg/h and {} ug", number(s.gyro_turn_on / unit::deg_per_h), number(s.accel_turn_on / unit::ug));
  return text;
}

std::string setting_text(Knob knob, const TableSetting& s) {
  const std::string timing = fmt::format("timing {} ms", number(1e3 * s.timing));
  if (knob == Knob::table) return table_text(s);
  if (knob == Knob::timing) return timing;
  if (knob == Knob::imu) return noise_text(s);
  return table_text(s) + "; " + timing + "; " + noise_text(s);
}

std::string title(Knob knob) {
  if (knob == Knob::table) return "coarsest table";
  if (knob == Knob::timing) return "longest timing error of a turn";
  if (knob == Knob::imu) return "noisiest unit";
  return "table, timing and unit together, all times one factor";
}

std::string answer(Knob knob, const Tolerance& t) {
  if (t.factor) return fmt::format("{}{} x declared: {}", t.unlimited ? "any, tried up to " : "", number(*t.factor), setting_text(knob, t.setting));
  std::string text = "none: not even ";
  if (knob == Knob::table) text += "a perfect table";
  if (knob == Knob::timing) text += "perfect timing";
  if (knob == Knob::imu) text += "a hundredth of the noise";
  if (knob == Knob::all) text += "a hundredth of all";
  for (const Shortfall& s : t.shortfalls) text += "\n      " + text_of(s);
  return text;
}

void print_answers(const TurntablePlan& plan, const std::vector<Shortfall>& missed, const std::vector<KnobAnswer>& answers) {
  fmt::print("\nAs declared, {}\n", missed.empty() ? "every requirement is met." : "these requirements are not met:");
  for (const Shortfall& s : missed) fmt::print("  {}\n", text_of(s));
  fmt::print("\nWhat meets every requirement:\n");
  for (const KnobAnswer& a : answers) {
    fmt::print("  {}\n", title(a.knob));
    if (a.knob == Knob::timing && plan.observations.turns.empty()) {
      fmt::print("    the procedure has no turns\n");
      continue;
    }
    if (a.alone) fmt::print("    all else perfect      {}\n", answer(a.knob, *a.alone));
    fmt::print("    {}{}\n", a.alone ? "all else as declared  " : "", answer(a.knob, a.declared));
  }
  fmt::print("Perfect: a millionth of the table's and the timing's errors, a hundredth of the noise, g and latitude exact.\n");
  const TableSetting s = setting_of(plan);
  if ((s.angle == 0 && s.orthogonality == 0 && s.zero == 0) || s.timing == 0)
    fmt::print("Where no error is declared, factors are those of 1 arcsec and 1 ms.\n");
}

std::vector<KnobAnswer> answers_to(const std::vector<Requirement>& requirements, const TurntablePlan& plan) {
  std::vector<KnobAnswer> answers{{Knob::table, {}, {}}, {Knob::timing, {}, {}}, {Knob::imu, {}, {}}, {Knob::all, {}, {}}};
  tbb::parallel_for(std::size_t{0}, 2 * answers.size() - 1, [&](std::size_t k) {
    KnobAnswer& a = answers[k / 2];
    if (k % 2 == 0)
      a.declared = tolerance(plan, a.knob, requirements);
    else
      a.alone = tolerance_alone(plan, a.knob, requirements);
  });
  return answers;
}

void run(const Options& options) {
  if (options.method == "hybrid") return predict_hybrid(options.procedure, options.require, options.json);
  const std::vector<Requirement> requirements = options.require ? parse_requirements(*options.require) : std::vector<Requirement>{};
  TurntablePlan plan = turntable_plan(read_session(options.procedure));
  plan.classical = options.classical;
  expect_estimated(requirements, plan);
  const TurntablePrediction prediction = predict(plan);
  std::optional<MonteCarloResult> sampled;
  if (options.runs > 0 && !prediction.coefficients.empty()) {
    Progress progress("Monte Carlo", options.runs);
    sampled = monte_carlo(plan, options.runs, options.seed, [&](std::uint64_t done) { progress.report(done); });
  }
  std::vector<KnobAnswer> answers;
  std::vector<Shortfall> missed;
  if (!requirements.empty()) {
    answers = answers_to(requirements, plan);
    missed = shortfalls(plan, requirements);
  }
  if (options.json) {
    fmt::print("{}", prediction_json(prediction, sampled, missed, answers));
  } else {
    print_prediction(prediction, sampled);
    if (!requirements.empty()) print_answers(plan, missed, answers);
  }
  for (const std::string& text : plan.observations.warnings) warn(text);
  std::string names;
  for (const int index : prediction.undetermined) names += fmt::format(" {}", row_of(index).name);
  if (!names.empty()) throw Unsupported(fmt::format("the procedure does not determine:{}", names));
  if (!answers.empty() && !answers.back().declared.factor)
    throw Unsupported("the requirements are not met with this procedure, not even with a hundredth of the declared table errors, timing and noise");
}

/// No Monte Carlo, or one that says something and ends.
std::string bad_runs(const std::string& text) {
  const bool digits = !text.empty() && text.size() < 10 && text.find_first_not_of("0123456789") == std::string::npos;
  const long runs = digits ? std::stol(text) : -1;
  return runs == 0 || (runs >= 100 && runs <= 10'000'000) ? "" : fmt::format("{}: 0 or 100 to 10000000 was expected", text);
}

}  // namespace

void add_predict(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("predict", "How good a calibration will be, and what limits it, before any table time is spent");
  verb->add_option("procedure", options->procedure, "the procedure or session to predict")->required();
  verb->add_option("--method", options->method, "turntable, or hybrid: no table angles are used, and no Monte Carlo is made")
      ->check(CLI::IsMember({"turntable", "hybrid"}))
      ->capture_default_str();
  verb->add_option("--require", options->require,
                   "requirements, as in \"gyro.matrix.off_diagonal <= 5 arcsec, accel.offset <= 20 ug\": which table, "
                   "timing and noise meet them");
  verb->add_option("--runs", options->runs, "procedures of the Monte Carlo, at least 100; 0 for none")->check(bad_runs)->capture_default_str();
  verb->add_option("--seed", options->seed, "the same seed, the same bits")->capture_default_str();
  verb->add_flag("--classical", options->classical, "weights from the sensors' noise alone, and the gyros' bias in turns apart (Zhang 2010)");
  verb->add_flag("--json", options->json, "print the result for machines");
  verb->callback([options, verb] {
    for (const char* name : {"--runs", "--seed", "--classical"})
      if (options->method == "hybrid" && verb->count(name) > 0 && !(std::string_view(name) == "--runs" && options->runs == 0))
        throw Error(fmt::format("{}: it belongs to --method turntable", name));
    run(*options);
  });
}

}  // namespace imulab::command
