#include "imulab/io/prediction_text.hpp"

#include "imulab/model/coefficient.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace imulab {

namespace {

using Json = nlohmann::ordered_json;

std::string name_of(int index) { return std::string(coefficient_table()[static_cast<std::size_t>(index)].name); }

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

Json to_json(const Tolerance& t) {
  if (!t.factor) return {{"factor", nullptr}, {"not_met", to_json(t.shortfalls)}};
  const TableSetting& s = t.setting;
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

std::string prediction_json(const TurntablePrediction& p, const std::optional<MonteCarloResult>& monte_carlo,
                            const std::vector<Shortfall>& shortfalls, const std::vector<KnobAnswer>& answers) {
  Json coefficients = Json::object();
  const Eigen::VectorXd sigma = p.sigma(), first = p.first_order();
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
  for (const int index : p.undetermined) undetermined.push_back(name_of(index));
  Json out{{"coefficients", std::move(coefficients)}, {"undetermined", std::move(undetermined)}};
  if (monte_carlo) out["monte_carlo_runs"] = monte_carlo->runs;
  if (!answers.empty()) {
    out["not_met"] = to_json(shortfalls);
    for (const KnobAnswer& a : answers) {
      Json& entry = out["tolerance"][std::string(to_string(a.knob))];
      entry["others_as_declared"] = to_json(a.declared);
      if (a.alone) entry["others_perfect"] = to_json(*a.alone);
    }
  }
  return out.dump(2) + "\n";
}

std::string prediction_json(const HybridPrediction& p, const std::vector<Shortfall>& shortfalls, const std::optional<HybridAdvice>& advice) {
  Json coefficients = Json::object(), undetermined = Json::array();
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    coefficients[name_of(p.coefficients[i])] = {{"closed_form", p.sigma[row]}, {"cramer_rao", p.cramer_rao[row]}};
  }
  for (const int index : p.undetermined) undetermined.push_back(name_of(index));
  Json out{{"coefficients", std::move(coefficients)}, {"undetermined", std::move(undetermined)}};
  if (!shortfalls.empty()) out["not_met"] = to_json(shortfalls);
  if (advice) {
    Json direction = Json::array();
    for (const int index : advice->coefficients) direction.push_back(name_of(index));
    out["worst_determined"] = {{"coefficients", std::move(direction)}, {"advice", advice->turns}};
  }
  return out.dump(2) + "\n";
}

}  // namespace imulab
