#include "imulab/results/summary.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/model/calibration_fields.hpp"
#include "imulab/noise/noise_fields.hpp"
#include "imulab/results/compare_results.hpp"
#include "imulab/results/comparison.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/extrinsics.hpp"
#include "imulab/results/over_time.hpp"
#include "imulab/results/result_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace imulab {

using json_io::Field;

std::optional<std::string_view> stored_unit(CoefficientIndex index, const std::string& name) {
  for (const UserUnit& unit : user_units(coefficient(index)))
    if (unit.name == name) return unit.name;
  if (name == coefficient(index).unit) return coefficient(index).unit;
  TriadModel triad;
  if (user_units(coefficient(index)).empty())
    for (const char* temperature : {"K", "raw"}) {
      triad.temperature = ThermalReading{.unit = temperature};
      if (const UserUnit unit = unit_of_si_readings(coefficient(index), triad); unit.name == name) return unit.name;
    }
  static const std::set<std::string, std::less<>> others{"", "ppm", "arcsec"};
  const auto at = others.find(name);
  return at != others.end() ? std::optional<std::string_view>(*at) : std::nullopt;
}

// ---- written

std::string comparison_json(const ComparisonSummary& summary) {
  std::vector<JsonValue> list;
  for (std::size_t k = 0; k < summary.comparisons.size(); ++k)
    list.push_back(written(NamedComparison{summary.names[0], summary.names[k + 1], summary.comparisons[k]}));
  JsonWriter writer;
  if (list.size() == 1) {
    NamedComparison only{summary.names[0], summary.names[1], summary.comparisons[0]};
    describe(writer, only);
  } else {
    writer.out.fields.emplace_back("comparisons", list), writer("agreement", summary.agreement);
  }
  std::vector<ComparedCalibration> calibrations = summary.calibrations;
  std::vector<RequirementResult> requirements = summary.requirements;
  writer("calibrations", calibrations, fields::if_any), writer("requirements", requirements, fields::if_any);
  return result_text("comparison", writer.out);
}

std::string prediction_json(const PredictionSummary& prediction) { return result_text("prediction", written(prediction)); }
std::string plan_json(const PlanSummary& plan) { return result_text("plan", written(plan)); }

// ---- predictions

std::vector<CoefficientIndex> PredictionSummary::indices() const {
  std::vector<CoefficientIndex> out;
  for (const PredictedCoefficient& c : coefficients) out.push_back(c.index);
  return out;
}

Eigen::VectorXd PredictionSummary::sigma() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(coefficients.size()));
  for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = coefficients[static_cast<std::size_t>(i)].sigma;
  return out;
}

PredictionSummary summary_of(const Prediction& p) {
  PredictionSummary out{.undetermined = p.undetermined, .considered = p.considered, .notes = p.notes, .rig_errors = p.rig_errors, .advice = p.advice};
  const Eigen::VectorXd first = p.first_order();
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    PredictedCoefficient& c = out.coefficients.emplace_back();
    c.index = p.coefficients[i], c.sigma = p.sigma[row], c.cramer_rao = p.cramer_rao[row];
    c.degrees_of_freedom = predicted(p, c.index).degrees_of_freedom;
    if (p.sigma_of_half.size() > 0 && std::isfinite(p.sigma_of_half[row])) c.sigma_of_half = p.sigma_of_half[row];
    if (p.sigma_of_twice.size() > 0 && std::isfinite(p.sigma_of_twice[row])) c.sigma_of_twice = p.sigma_of_twice[row];
    if (p.monte_carlo) c.monte_carlo = p.monte_carlo->sigma[row];
    if (p.sources.empty()) continue;
    c.first_order = first[row], c.second_order = p.second_order[row], c.bias = p.bias[row];
    for (std::size_t k = 0; k < p.sources.size(); ++k) c.budget.emplace_back(p.sources[k], std::sqrt(p.variance(row, static_cast<Eigen::Index>(k))));
  }
  for (const TermSource& term : p.terms) out.priors.emplace_back(term.name, term.prior);
  if (p.monte_carlo) out.runs = p.monte_carlo->runs;
  if (p.tolerances || !p.missed.empty()) out.missed = p.missed;
  if (p.tolerances)
    for (const Tolerances::Answer& answer : p.tolerances->answers) out.tolerance.emplace_back(to_string(answer.knob), answer);
  return out;
}

// ---- read

namespace {

constexpr const char* expected_result =
    "calibration.json, noise.json, extrinsics.json, or what compare, predict, plan, navigate, budget or compensate print with --json";

ComparisonSummary comparison_of(const Field& root) {
  std::vector<NamedComparison> all(1);
  ComparisonSummary out;
  if (root.has("comparisons")) {
    JsonReader reader(root);
    reader("comparisons", all);
    reader("agreement", out.agreement, fields::optional);
    if (all.empty()) root["comparisons"].fail("is empty; expected at least one comparison");
  } else {
    read_into(root, all.front());
  }
  JsonReader rest(root);
  rest("calibrations", out.calibrations, fields::optional), rest("requirements", out.requirements, fields::optional);
  out.names.push_back(all.front().a);
  for (NamedComparison& c : all) {
    out.names.push_back(std::move(c.b));
    out.comparisons.push_back(std::move(c.comparison));
  }
  return out;
}

/// Every coefficient has the sources of the first.
PredictionSummary checked(PredictionSummary p, const Field& root) {
  const auto same = [](const auto& x, const auto& y) { return x.first == y.first; };
  for (const PredictedCoefficient& c : p.coefficients)
    if (const auto& first = p.coefficients.front().budget; !std::equal(first.begin(), first.end(), c.budget.begin(), c.budget.end(), same))
      root["coefficients"][coefficient(c.index).name].fail("expected a budget of the same sources as the first coefficient's");
  return p;
}

template <class Summary>
Summary read_summary(const Field& root) {
  Summary out;
  read_into(root, out);
  return out;
}

}  // namespace

namespace {

SavedResult noise_of(const Field& root) {
  if (root.has("logs")) return read_summary<NoiseBatch>(root);
  return read_summary<NoiseAnalysis>(root);
}

SavedResult one_or_several_budgets(const Field& root) {
  if (!root.has("budgets")) return result_io::budget_of(root);
  if (root["budgets"].size() < 2) root["budgets"].fail("has less than two budgets; expected several");
  return compare_grades(root["budgets"].list(result_io::budget_of));
}

SavedResult plan_of(const Field& root) {
  auto plan = read_summary<PlanSummary>(root);
  plan.prediction = checked(std::move(plan.prediction), root);
  return plan;
}

struct ResultFormat {
  std::string_view name;
  SavedResult (*read)(const Field& root);
};

template <auto read>
SavedResult result_of(const Field& root) {
  return read(root);
}

SavedResult prediction_of(const Field& root) { return checked(read_summary<PredictionSummary>(root), root); }

constexpr std::array result_formats{
    ResultFormat{"imulab.noise/1", noise_of},
    ResultFormat{"imulab.comparison/1", result_of<comparison_of>},
    ResultFormat{"imulab.prediction/1", prediction_of},
    ResultFormat{"imulab.plan/1", plan_of},
    ResultFormat{"imulab.budget/1", one_or_several_budgets},
    ResultFormat{"imulab.navigation/1", result_of<result_io::navigation_of>},
    ResultFormat{"imulab.aided/1", result_of<result_io::aided_of>},
    ResultFormat{"imulab.compensation/1", result_of<result_io::compensation_of>},
    ResultFormat{"imulab.result-comparison/1", result_of<result_comparison_of>},
    ResultFormat{"imulab.extrinsics/1", result_of<result_io::extrinsics_of>},
};

SavedResult read_result(const Field& root, std::string_view text, const std::string& file) {
  if (!root.has("format")) throw Error(fmt::format("{}: not a result; expected {}, with their \"format\"", file, expected_result));
  const std::string format = root["format"].text();
  if (format.starts_with("imulab.calibration/")) return parse_calibration(text, file);
  std::string names = "\"imulab.calibration/1\"";
  for (const ResultFormat& known : result_formats) {
    if (known.name == format) return known.read(root);
    names += fmt::format(", \"{}\"", known.name);
  }
  root["format"].expected(names);
}

}  // namespace

SavedAnswer parse_answer(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) throw Error(file + ": is empty; expected " + expected_result);
  const JsonValue json = json_io::parse_json(text, file, expected_result);
  const Field root(json, file, "");
  SavedAnswer out{read_result(root, text, file), conclusion_of(root), {}};
  const bool has_them = std::holds_alternative<Calibration>(out.result) || std::holds_alternative<NoiseAnalysis>(out.result) ||
                        std::holds_alternative<NoiseBatch>(out.result);  // among its own fields
  if (!has_them && root.has("warnings")) out.warnings = root["warnings"].texts();
  return out;
}

SavedResult parse_result(std::string_view text, const std::string& file) { return parse_answer(text, file).result; }

SavedAnswer read_answer(const std::filesystem::path& path) { return parse_answer(MappedFile(path, Content::settings).text(), input_name(path)); }

}  // namespace imulab
