// Comparisons, predictions and small results as JSON. In few sources: the JSON library is slow to compile.
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/formats/text/json_dump.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/results/comparison.hpp"
#include "imulab/results/fields.hpp"
#include "imulab/results/json_parts.hpp"
#include "imulab/results/prediction.hpp"

#include <cmath>
#include <type_traits>

namespace imulab {
namespace {

using result_io::Json;

std::string name_of(CoefficientIndex index) { return std::string(coefficient(index).name); }

// ---- comparisons

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const CoefficientDifference& d) {
  return {{"a", d.a},
          {"b", d.b},
          {"difference", d.difference},
          {"standard_uncertainty", or_null(d.uncertainty)},
          {"sigmas", or_null(d.sigmas())},
          {"user", {{"difference", d.user_difference}, {"standard_uncertainty", or_null(d.user_uncertainty)}, {"unit", d.user_unit}}}};
}

Json to_json(const Consistency& c) { return {{"chi2", c.chi2}, {"degrees_of_freedom", c.degrees_of_freedom}, {"p_value", c.p_value}}; }

Json to_json(const std::string& a, const std::string& b, const Comparison& comparison) {
  Json coefficients = Json::object();
  for (const auto& d : comparison.coefficients) coefficients[name_of(d.index)] = to_json(d);
  return {
      {"a", a}, {"b", b}, {"frame", "accelerometers"}, {"coefficients", std::move(coefficients)}, {"consistency", to_json(comparison.consistency)}};
}

Json to_json(const Agreement& agreement) {
  Json coefficients = Json::object(), differing = Json::array();
  for (const auto& c : agreement.coefficients) {
    coefficients[name_of(c.index)] = to_json(c.consistency);
    if (c.differs) differing.push_back(name_of(c.index));
  }
  return {{"calibrations", agreement.calibrations},
          {"coefficients", std::move(coefficients)},
          {"consistency", to_json(agreement.consistency)},
          {"differing", std::move(differing)}};
}

// ---- predictions

Json to_json(const std::vector<Shortfall>& shortfalls) {
  Json list = Json::array();
  for (const Shortfall& s : shortfalls)
    list.push_back({{"selector", s.requirement.selector},
                    {"limit", s.requirement.limit},
                    {"coefficient", name_of(s.coefficient)},
                    {"sigma", std::isfinite(s.sigma) ? Json(s.sigma) : Json(nullptr)},
                    {"source", s.source}});
  return list;
}

Json to_json(const turntable::Tolerance& t) {
  if (!t.factor) return {{"factor", nullptr}, {"not_met", to_json(t.shortfalls)}};
  const turntable::ErrorSizes& s = t.sizes;
  return {{"factor", *t.factor},
          {"unlimited", t.unlimited},
          {"angle", s.angle},
          {"orthogonality", s.orthogonality},
          {"zero", s.zero},
          {"timing", s.timing},
          {"gyro_noise_density", s.gyro_noise},
          {"accel_noise_density", s.accel_noise},
          {"gyro_turn_on", s.gyro_turn_on},
          {"accel_turn_on", s.accel_turn_on}};
}

}  // namespace

std::string comparison_json(const std::vector<NamedCalibration>& calibrations, const std::vector<Comparison>& comparisons,
                            const std::optional<Agreement>& agreement) {
  if (comparisons.size() == 1) return dump_json(to_json(calibrations[0].name, calibrations[1].name, comparisons[0])) + "\n";
  Json list = Json::array();
  for (std::size_t k = 0; k < comparisons.size(); ++k) list.push_back(to_json(calibrations[0].name, calibrations[k + 1].name, comparisons[k]));
  return dump_json(Json{{"comparisons", std::move(list)}, {"agreement", agreement ? to_json(*agreement) : Json(nullptr)}}) + "\n";
}

std::string prediction_json(const turntable::Prediction& p, const std::optional<turntable::MonteCarloResult>& monte_carlo,
                            const std::vector<Shortfall>& shortfalls, const std::vector<KnobAnswer>& answers) {
  Json coefficients = Json::object();
  const Eigen::VectorXd sigma = p.sigma, first = p.first_order();
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Json budget = Json::object();
    for (std::size_t k = 0; k < p.sources.size(); ++k) budget[p.sources[k]] = std::sqrt(p.variance(row, static_cast<Eigen::Index>(k)));
    Json entry{{"closed_form", sigma[row]}, {"first_order", first[row]}, {"second_order", p.second_order[row]}, {"bias_taken_out", p.bias[row]}};
    if (monte_carlo) entry["monte_carlo"] = monte_carlo->sigma[row];
    entry["cramer_rao"] = std::isfinite(p.cramer_rao[row]) ? Json(p.cramer_rao[row]) : Json(nullptr);
    entry["budget"] = std::move(budget);
    coefficients[name_of(p.coefficients[i])] = std::move(entry);
  }
  Json undetermined = Json::array();
  for (const CoefficientIndex index : p.undetermined) undetermined.push_back(name_of(index));
  Json out{{"coefficients", std::move(coefficients)}, {"undetermined", std::move(undetermined)}};
  for (const CoefficientIndex index : p.considered) out["considered"].push_back(name_of(index));
  for (const turntable::TermSource& term : p.terms) out["priors"][term.name] = term.prior;
  if (monte_carlo) out["monte_carlo_runs"] = monte_carlo->runs;
  if (!answers.empty()) {
    out["not_met"] = to_json(shortfalls);
    for (const KnobAnswer& a : answers) {
      Json& entry = out["tolerance"][std::string(to_string(a.knob))];
      entry["others_as_declared"] = to_json(a.declared);
      if (a.alone) entry["others_perfect"] = to_json(*a.alone);
    }
  }
  return dump_json(out) + "\n";
}

namespace {

Json to_json(const JsonFields& object) {
  Json out = Json::object();
  for (const auto& [key, value] : object.fields) {
    if (const auto* list = std::get_if<std::vector<JsonFields>>(&value)) {
      out[key] = Json::array();
      for (const JsonFields& item : *list) out[key].push_back(to_json(item));
    } else if (const auto* object_inside = std::get_if<JsonObject>(&value)) {
      out[key] = object_inside->one.empty() ? Json::object() : to_json(object_inside->one.front());
    } else {
      std::visit(
          [&out, &key = key](const auto& own) {
            using Own = std::decay_t<decltype(own)>;
            if constexpr (!std::is_same_v<Own, std::vector<JsonFields>> && !std::is_same_v<Own, JsonObject>) out[key] = own;
          },
          value);
    }
  }
  return out;
}

}  // namespace

std::string fields_json(const JsonFields& object, bool one_line) { return dump_json(to_json(object), one_line ? -1 : 2) + "\n"; }

std::string path_json(const hybrid::Path& path, const std::vector<Requirement>& requirements, const Prediction& p,
                      const std::vector<Shortfall>& missed, const std::optional<PriorEffect>& prior) {
  Json required = Json::array();
  for (const Requirement& r : requirements) required.push_back(to_string(r));
  Json turns = Json::array();
  for (const TableTurn& turn : path.turns)
    turns.push_back({{"axis", std::string(to_string(turn.axis))}, {"angle_deg", turn.angle_deg}, {"rest_s", turn.rest}});
  Json out{{"requirements", std::move(required)}, {"duration_s", path.duration}, {"first_rest_s", path.first_rest}, {"turns", std::move(turns)}};
  if (prior) out["prior"] = {{"fleet", prior->fleet}, {"units", prior->units}, {"duration_without_s", prior->duration_without}};
  out.update(Json::parse(prediction_json(p, missed, std::nullopt)));
  return dump_json(out) + "\n";
}

std::string prediction_json(const Prediction& p, const std::vector<Shortfall>& shortfalls, const std::optional<hybrid::Advice>& advice) {
  Json coefficients = Json::object(), undetermined = Json::array();
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    coefficients[name_of(p.coefficients[i])] = {{"closed_form", p.sigma[row]}, {"cramer_rao", p.cramer_rao[row]}};
  }
  for (const CoefficientIndex index : p.undetermined) undetermined.push_back(name_of(index));
  Json out{{"coefficients", std::move(coefficients)}, {"undetermined", std::move(undetermined)}};
  for (const CoefficientIndex index : p.considered) out["considered"].push_back(name_of(index));
  if (!p.notes.empty()) out["notes"] = p.notes;
  if (!shortfalls.empty()) out["not_met"] = to_json(shortfalls);
  if (advice) {
    Json direction = Json::array();
    for (const CoefficientIndex index : advice->coefficients) direction.push_back(name_of(index));
    out["worst_determined"] = {{"coefficients", std::move(direction)}, {"advice", advice->turns}};
  }
  return dump_json(out) + "\n";
}

}  // namespace imulab
