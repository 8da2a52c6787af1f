// Results back from their JSON, as far as it goes.
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_field.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_value.hpp"
#include "imulab/results/reader_parts.hpp"
#include "imulab/results/summary.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <set>

namespace imulab {
namespace {

using json_text::Json, json_text::parse_json, result_io::Field;

constexpr const char* expected_result = "calibration.json, or what compare, predict, plan, navigate, budget or compensate print with --json";

CoefficientIndex index_at(const Field& parent, const std::string& name) {
  try {
    return coefficient_index(name);
  } catch (const Error& e) {
    parent.fail(e.what());
  }
}

std::optional<double> optional_number(const Field& f) { return f.is_null() ? std::nullopt : std::optional(f.number()); }

// ---- comparisons

Consistency consistency_at(const Field& f) { return {f["chi2"].number(), f["degrees_of_freedom"].whole_number(), f["p_value"].number()}; }

/// The unit's name, as it is stored for good.
std::string_view unit_name(const Field& f, CoefficientIndex index) {
  const std::string name = f.text();
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
  if (const auto at = others.find(name); at != others.end()) return *at;
  f.expected("a unit of " + std::string(coefficient(index).name));
}

void read_comparison(const Field& f, ComparisonSummary& out) {
  if (out.names.empty()) out.names.push_back(f["a"].text());
  out.names.push_back(f["b"].text());
  Comparison comparison;
  const Field all = f["coefficients"];
  for (const std::string& name : all.keys()) {
    const Field at = all[name];
    CoefficientDifference d;
    d.index = index_at(all, name);
    d.a = at["a"].number(), d.b = at["b"].number(), d.difference = at["difference"].number();
    d.uncertainty = optional_number(at["standard_uncertainty"]);
    d.user_difference = at["user"]["difference"].number();
    d.user_uncertainty = optional_number(at["user"]["standard_uncertainty"]);
    d.user_unit = unit_name(at["user"]["unit"], d.index);
    comparison.coefficients.push_back(d);
  }
  comparison.consistency = consistency_at(f["consistency"]);
  out.comparisons.push_back(std::move(comparison));
}

Agreement agreement_at(const Field& f) {
  Agreement out;
  out.calibrations = f["calibrations"].whole_number();
  const std::vector<std::string> differing = f.texts("differing");
  const Field all = f["coefficients"];
  for (const std::string& name : all.keys())
    out.coefficients.push_back(
        {index_at(all, name), consistency_at(all[name]), std::find(differing.begin(), differing.end(), name) != differing.end()});
  out.consistency = consistency_at(f["consistency"]);
  return out;
}

ComparisonSummary comparison_of(const Field& root) {
  ComparisonSummary out;
  if (!root.has("comparisons")) {
    read_comparison(root, out);
    return out;
  }
  root["comparisons"].list([&](const Field& f) {
    read_comparison(f, out);
    return 0;
  });
  if (out.comparisons.empty()) root["comparisons"].fail("is empty; expected at least one comparison");
  if (root.has("agreement") && !root["agreement"].is_null()) out.agreement = agreement_at(root["agreement"]);
  return out;
}

// ---- predictions

Shortfall shortfall_at(const Field& f) {
  Shortfall s;
  s.requirement.selector = f["selector"].text();
  s.requirement.limit = f["limit"].number();
  s.coefficient = index_at(f, f["coefficient"].text());
  s.requirement.coefficients = {s.coefficient};
  s.requirement.unit = user_unit(coefficient(s.coefficient), s.requirement.limit);
  s.sigma = f["sigma"].number_or_infinity();
  s.source = f.text_or_empty("source");
  return s;
}

PredictionSummary prediction_of(const Field& root) {
  PredictionSummary out;
  const Field all = root["coefficients"];
  const std::vector<std::string> names = all.keys();
  const auto n = static_cast<Eigen::Index>(names.size());
  out.sigma.resize(n), out.cramer_rao.resize(n);
  Eigen::VectorXd sampled(n);
  if (n > 0 && all[names[0]].has("budget")) out.sources = all[names[0]]["budget"].keys();
  out.variance.setZero(n, static_cast<Eigen::Index>(out.sources.size()));
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::string& name = names[static_cast<std::size_t>(i)];
    const Field at = all[name];
    out.coefficients.push_back(index_at(all, name));
    out.sigma[i] = at["closed_form"].number();
    out.cramer_rao[i] = at.has("cramer_rao") ? at["cramer_rao"].number_or_nan() : NAN;
    sampled[i] = at.has("monte_carlo") ? at["monte_carlo"].number() : NAN;
    for (std::size_t k = 0; k < out.sources.size(); ++k)
      out.variance(i, static_cast<Eigen::Index>(k)) = std::pow(at["budget"][out.sources[k]].number(), 2);
  }
  if (n > 0 && sampled.array().isFinite().all()) out.monte_carlo = sampled;
  if (root.has("monte_carlo_runs")) out.runs = root["monte_carlo_runs"].size_in_bytes();
  for (const std::string& name : root.texts("undetermined")) out.undetermined.push_back(index_at(root, name));
  out.missed = root.list("not_met", shortfall_at);
  if (root.has("worst_determined")) out.advice = root["worst_determined"].texts("advice");
  return out;
}

// ---- plans

PlanSummary plan_of(const Field& root) {
  PlanSummary out;
  root.list("requirements", [&](const Field& f) {
    try {
      for (Requirement& r : parse_requirements(f.text())) out.requirements.push_back(std::move(r));
    } catch (const Error& e) {
      f.fail(e.what());
    }
    return 0;
  });
  out.path.duration = root["duration_s"].number();
  out.path.first_rest = root["first_rest_s"].number();
  out.path.turns = root["turns"].list([](const Field& f) {
    for (const RigAxis axis : {RigAxis::outer, RigAxis::middle, RigAxis::inner})
      if (f["axis"].text() == to_string(axis)) return TableTurn{axis, f["angle_deg"].number(), f["rest_s"].number()};
    f["axis"].expected("outer, middle or inner");
  });
  if (root.has("prior")) {
    const Field f = root["prior"];
    out.prior = PriorEffect{f["fleet"].text(), f["units"].number(), f["duration_without_s"].number_or_nan()};
  }
  out.prediction = prediction_of(root);
  return out;
}

}  // namespace

SavedResult parse_result(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) throw Error(file + ": is empty; expected " + expected_result);
  const Json json = parse_json(text, file, expected_result);
  const Field root(json, file, "");
  if (root.has("format")) return parse_calibration(text, file);
  if (root.has("comparisons") || root.has("consistency")) return comparison_of(root);
  if (root.has("sessions") || root.has("position_error")) return result_io::navigation_of(root);
  if (root.has("total") && root.has("sources")) return result_io::budget_of(root);
  if (root.has("files") && root.has("calibration")) return result_io::compensation_of(root);
  if (root.has("turns") && root.has("first_rest_s")) return plan_of(root);
  if (root.has("coefficients") && root.has("undetermined")) return prediction_of(root);
  throw Error(fmt::format("{}: not a result; expected {}", file, expected_result));
}

SavedResult read_result(const std::filesystem::path& path) { return parse_result(MappedFile(path, Content::settings).text(), input_name(path)); }

}  // namespace imulab
