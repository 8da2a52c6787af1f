// All results as JSON, in one source: the JSON library is slow to compile.
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/io/result/budget.hpp"
#include "imulab/io/result/budget_quantities.hpp"
#include "imulab/io/result/comparison.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/result/navigation.hpp"
#include "imulab/io/result/prediction.hpp"
#include "imulab/model/coefficient.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <type_traits>

namespace imulab {
namespace {

using namespace result_io;
using Json = nlohmann::ordered_json;

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

// ---- navigation

Json to_json(const Eigen::Vector3d& v, double unit = 1) { return {v.x() / unit, v.y() / unit, v.z() / unit}; }

Json to_json(const AlignedOn& aligned) {
  const FineAlignment& a = aligned.alignment;
  const EulerAngles angles = euler_angles(a.attitude.C_nb);
  Json covariance = Json::array();
  for (int i = 0; i < 3; ++i) covariance.push_back(to_json(Eigen::Vector3d(a.attitude.covariance.row(i).transpose())));
  return {{"begin_s", aligned.begin},
          {"end_s", aligned.end},
          {"roll_pitch_heading_deg", to_json({angles.roll, angles.pitch, angles.heading}, unit::deg)},
          {"standard_uncertainty_deg", to_json(angle_sigmas(a.attitude), unit::deg)},
          {"covariance_enu_rad2", std::move(covariance)},
          {"gyro_noise_density", a.gyro_noise},
          {"accel_noise_density", a.accel_noise},
          {"base_displacement_m", a.base_displacement},
          {"innovation_square", a.innovation_square},
          {"innovation_correlation", a.innovation_correlation}};
}

Json to_json(const NavigatedSession& session) {
  const Navigated& n = session.navigated;
  Json out{{"session", session.session}, {"position_error", nullptr}, {"velocity_error_mps", nullptr}, {"attitude_error_arcsec", nullptr}};
  if (session.errors) {
    const NavigationError& end = session.errors->history.back();
    out["position_error"] = {{"east_m", end.position.x()},
                             {"north_m", end.position.y()},
                             {"up_m", end.position.z()},
                             {"horizontal_m", end.horizontal()},
                             {"rate_nmi_per_h", session.errors->rate / unit::nmi_per_h}};
    out["velocity_error_mps"] = to_json(end.velocity);
    out["attitude_error_arcsec"] = to_json(end.attitude, unit::arcsec);
    out["error_time_s"] = end.time;
  }
  out["vertical"] = to_string(n.vertical);
  out["time_s"] = {n.solution.time.front(), n.solution.time.back()};
  out["alignment"] = n.aligned ? to_json(*n.aligned) : Json(nullptr);
  Json gaps = Json::array();
  for (const MissingTime& gap : n.gaps) gaps.push_back({{"begin_s", gap.begin}, {"length_s", gap.length}});
  out["gaps"] = std::move(gaps);
  out["saturated"] = n.saturated;
  out["warnings"] = n.warnings;
  if (session.errors)
    for (const auto& text : session.errors->warnings) out["warnings"].push_back(text);
  return out;
}

// ---- error budgets

Json vector_of(const BudgetRows& rows, Eigen::Index first, Eigen::Index at) {
  Json list = Json::array();
  for (Eigen::Index q = first; q < first + 3; ++q) list.push_back(rows(q, at) / unit_of(q));
  return list;
}

Json contribution(const BudgetRows& fixed, const BudgetRows& sigma, Eigen::Index at) {
  const auto part = [&](Eigen::Index first) { return Json{{"fixed", vector_of(fixed, first, at)}, {"sigma", vector_of(sigma, first, at)}}; };
  return {{"position_m", part(0)}, {"velocity_mps", part(3)}, {"attitude_arcsec", part(6)}};
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
  if (comparisons.size() == 1) return to_json(calibrations[0].name, calibrations[1].name, comparisons[0]).dump(2) + "\n";
  Json list = Json::array();
  for (std::size_t k = 0; k < comparisons.size(); ++k) list.push_back(to_json(calibrations[0].name, calibrations[k + 1].name, comparisons[k]));
  return Json{{"comparisons", std::move(list)}, {"agreement", agreement ? to_json(*agreement) : Json(nullptr)}}.dump(2) + "\n";
}

std::string navigation_json(const std::vector<NavigatedSession>& sessions) {
  if (sessions.size() == 1) return to_json(sessions[0]).dump(2) + "\n";
  Json list = Json::array();
  std::vector<double> rates;
  for (const auto& session : sessions) {
    list.push_back(to_json(session));
    if (session.errors) rates.push_back(session.errors->rate / unit::nmi_per_h);
  }
  Json rate = nullptr;
  if (!rates.empty()) rate = {{"rms", rate_summary(rates).rms}, {"cep", rate_summary(rates).cep}, {"sessions", rates.size()}};
  return Json{{"sessions", std::move(list)}, {"rate_nmi_per_h", std::move(rate)}}.dump(2) + "\n";
}

std::string budget_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  Json out{{"time_s", b.time.back()}, {"vertical", to_string(b.vertical)}, {"total", contribution(b.mean, total_sigma(b), end)}};
  for (const auto* list : {&b.groups, &b.coefficients})
    for (const Contribution& c : *list) out[list == &b.groups ? "sources" : "coefficients"][c.name] = contribution(c.fixed, c.sigma, end);
  for (int q = 0; q < budget_quantities; ++q) {
    const std::vector<double> shares = b.shares(q, b.time.size() - 1);
    for (std::size_t k = 0; k < shares.size(); ++k)
      out["shares"][k < b.groups.size() ? b.groups[k].name : "correlation between groups"][std::string(quantity_names[static_cast<std::size_t>(q)])] =
          shares[k];
  }
  if (monte_carlo) {
    const ErrorDistribution& d = *monte_carlo;
    Json& m = out["monte_carlo"];
    m["runs"] = d.drift.size();
    for (Eigen::Index q = 0; q <= budget_quantities; ++q)
      m[std::string(quantity_names[static_cast<std::size_t>(q)])] = {{"mean", d.mean(q, end) / unit_of(q)},
                                                                     {"sigma", d.sigma(q, end) / unit_of(q)},
                                                                     {"low", d.low(q, end) / unit_of(q)},
                                                                     {"median", d.median(q, end) / unit_of(q)},
                                                                     {"high", d.high(q, end) / unit_of(q)}};
    m["rate_nmi_per_h"] = {
        {"rms", d.drift_rms / unit::nmi_per_h}, {"cep", d.drift_cep / unit::nmi_per_h}, {"95_percent", d.drift_95 / unit::nmi_per_h}};
  }
  return out.dump(2) + "\n";
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

std::string fields_json(const JsonFields& object, bool one_line) {
  return to_json(object).dump(one_line ? -1 : 2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string path_json(const hybrid::Path& path, const Prediction& p, const std::vector<Shortfall>& missed) {
  Json turns = Json::array();
  for (const TableTurn& turn : path.turns)
    turns.push_back({{"axis", std::string(to_string(turn.axis))}, {"angle_deg", turn.angle_deg}, {"rest_s", turn.rest}});
  Json out{{"duration_s", path.duration}, {"first_rest_s", path.first_rest}, {"turns", std::move(turns)}};
  out.update(Json::parse(prediction_json(p, missed, std::nullopt)));
  return out.dump(2) + "\n";
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
  return out.dump(2) + "\n";
}

}  // namespace imulab
