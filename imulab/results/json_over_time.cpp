// Results over time as JSON: navigation, error budgets, compensated recordings.
#include "imulab/core/units.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/results/budget_quantities.hpp"
#include "imulab/results/compensation.hpp"
#include "imulab/results/json_parts.hpp"
#include "imulab/results/navigation.hpp"

#include <utility>

namespace imulab {
namespace {

using namespace result_io;

constexpr std::size_t most_times = 200, most_errors = 500, most_places = 800;
constexpr int stamp_digits = 16;  // of a clock that counts from 1970 to the microsecond

Json to_json(const Eigen::Vector3d& v, double unit = 1) { return {v.x() / unit, v.y() / unit, v.z() / unit}; }

std::string quantity_name(Eigen::Index q) { return std::string(quantity_names[static_cast<std::size_t>(q)]); }

/// Where it went; null where that is not known.
Json track_json(const std::vector<NavigationState>& states) {
  if (states.size() < 2) return nullptr;
  const std::vector<std::size_t> at = thinned(states.size(), most_places);
  const auto list = [&](auto value) {
    return picture_list(
        at.size(), [&](std::size_t i) { return value(states[at[i]]); }, 10);
  };
  return {{"latitude_deg", list([](const NavigationState& s) { return s.latitude / unit::deg; })},
          {"longitude_deg", list([](const NavigationState& s) { return s.longitude / unit::deg; })},
          {"height_m", list([](const NavigationState& s) { return s.height; })}};
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

/// One quantity at some times.
template <class Rows>
Json quantity_list(const Rows& rows, Eigen::Index q, const std::vector<std::size_t>& at) {
  return picture_list(at.size(), [&](std::size_t i) { return rows(q, static_cast<Eigen::Index>(at[i])) / unit_of(q); });
}

Json quantities_over_time(const BudgetRows& fixed, const BudgetRows& sigma, Eigen::Index quantities, const std::vector<std::size_t>& at) {
  Json out = Json::object();
  for (Eigen::Index q = 0; q < quantities; ++q)
    out[quantity_name(q)] = {{"fixed", quantity_list(fixed, q, at)}, {"sigma", quantity_list(sigma, q, at)}};
  return out;
}

/// What the pictures over time need: all of the total, of the sources the horizontal position.
Json history_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  constexpr Eigen::Index horizontal = 2;
  const std::vector<std::size_t> at = thinned(b.time.size(), most_times);
  Json out{{"time_s", picture_list(
                          at.size(), [&](std::size_t i) { return b.time[at[i]]; }, stamp_digits)}};
  out["total"] = quantities_over_time(b.mean, total_sigma(b), budget_quantities, at);
  out["sources"] = Json::object();
  for (const Contribution& c : b.groups) out["sources"][c.name] = quantities_over_time(c.fixed, c.sigma, horizontal, at);
  if (!monte_carlo || monte_carlo->time.size() != b.time.size()) return out;
  for (Eigen::Index q = 0; q <= budget_quantities; ++q)
    out["monte_carlo"][quantity_name(q)] = {{"low", quantity_list(monte_carlo->low, q, at)},
                                            {"median", quantity_list(monte_carlo->median, q, at)},
                                            {"high", quantity_list(monte_carlo->high, q, at)}};
  return out;
}

Json monte_carlo_json(const ErrorDistribution& d) {
  const Eigen::Index end = d.mean.cols() - 1;
  Json out{{"runs", d.drift.size()}};
  for (Eigen::Index q = 0; q <= budget_quantities; ++q)
    out[quantity_name(q)] = {{"mean", d.mean(q, end) / unit_of(q)},
                             {"sigma", d.sigma(q, end) / unit_of(q)},
                             {"low", d.low(q, end) / unit_of(q)},
                             {"median", d.median(q, end) / unit_of(q)},
                             {"high", d.high(q, end) / unit_of(q)}};
  out["rate_nmi_per_h"] = {
      {"rms", d.drift_rms / unit::nmi_per_h}, {"cep", d.drift_cep / unit::nmi_per_h}, {"95_percent", d.drift_95 / unit::nmi_per_h}};
  return out;
}

Json to_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo) {
  const auto end = static_cast<Eigen::Index>(b.time.size()) - 1;
  Json out{{"time_s", b.time.back()}, {"vertical", to_string(b.vertical)}, {"total", contribution(b.mean, total_sigma(b), end)}};
  for (const auto* list : {&b.groups, &b.coefficients})
    for (const Contribution& c : *list) out[list == &b.groups ? "sources" : "coefficients"][c.name] = contribution(c.fixed, c.sigma, end);
  for (int q = 0; q < budget_quantities; ++q) {
    const std::vector<double> shares = b.shares(q, b.time.size() - 1);
    for (std::size_t k = 0; k < shares.size(); ++k)
      out["shares"][k < b.groups.size() ? b.groups[k].name : "correlation between groups"][quantity_name(q)] = shares[k];
  }
  if (monte_carlo) out["monte_carlo"] = monte_carlo_json(*monte_carlo);
  out["history"] = history_json(b, monte_carlo);
  return out;
}

// ---- navigation

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

Json errors_over_time(const std::vector<NavigationError>& history) {
  const std::vector<std::size_t> at = thinned(history.size(), most_errors);
  const auto list = [&](auto value, int digits = 6) {
    return picture_list(
        at.size(), [&](std::size_t i) { return value(history[at[i]]); }, digits);
  };
  const auto vector = [&](auto value, double unit) {
    Json out = Json::array();
    for (Eigen::Index k = 0; k < 3; ++k) out.push_back(list([&](const NavigationError& e) { return value(e)[k] / unit; }));
    return out;
  };
  return {{"time_s", list([](const NavigationError& e) { return e.time; }, stamp_digits)},
          {"position_m", vector([](const NavigationError& e) { return e.position; }, 1)},
          {"velocity_mps", vector([](const NavigationError& e) { return e.velocity; }, 1)},
          {"attitude_arcsec", vector([](const NavigationError& e) { return e.attitude; }, unit::arcsec)}};
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
  if (session.errors) out["errors_over_time"] = errors_over_time(session.errors->history);
  out["track"] = track_json(n.track);
  out["explained"] = session.explained ? to_json(*session.explained, std::nullopt) : Json(nullptr);
  if (!session.unexplained.empty()) out["not_explained"] = session.unexplained;
  return out;
}

// ---- compensated recordings

Json columns_json(const Columns3& columns, double unit) {
  Json out = Json::array();
  for (const auto& column : columns) out.push_back(picture_list(column.size(), [&](std::size_t i) { return column[i] / unit; }));
  return out;
}

Json to_json(const CompensatedFile& f) {
  Json out{{"file", f.file},
           {"samples", f.samples},
           {"saturated", f.saturated},
           {"outside_calibrated_temperatures", f.out_of_range},
           {"outliers_replaced", f.replaced}};
  if (!f.overview) return out;
  const Overview& o = *f.overview;
  out["recording"] = f.recording;
  out["rate_hz"] = f.rate_hz;
  out["gaps"] = f.gaps;
  out["overview"] = {{"samples_per_interval", o.samples_per_interval},
                     {"first_s", o.first_s},
                     {"time_s", picture_list(
                                    o.time.size(), [&](std::size_t i) { return o.time[i]; }, stamp_digits)},
                     {"rate_deg_per_s", columns_json(o.rate, unit::deg)},
                     {"force_mps2", columns_json(o.force, 1)}};
  if (!o.temperature[0].empty()) out["overview"]["temperature"] = columns_json(o.temperature, 1);
  return out;
}

}  // namespace

std::string navigation_json(const std::vector<NavigatedSession>& sessions) {
  if (sessions.size() == 1) return json_text_of(to_json(sessions[0]));
  Json list = Json::array();
  std::vector<double> rates;
  for (const auto& session : sessions) {
    list.push_back(to_json(session));
    if (session.errors) rates.push_back(session.errors->rate / unit::nmi_per_h);
  }
  Json rate = nullptr;
  if (!rates.empty()) rate = {{"rms", rate_summary(rates).rms}, {"cep", rate_summary(rates).cep}, {"sessions", rates.size()}};
  return json_text_of(Json{{"sessions", std::move(list)}, {"rate_nmi_per_h", std::move(rate)}});
}

std::string budget_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo, const std::vector<NavigationState>& track) {
  Json out = to_json(b, monte_carlo);
  out["track"] = track_json(track);
  return json_text_of(out);
}

std::string compensation_json(const CompensationSummary& summary) {
  Json files = Json::array();
  for (const CompensatedFile& file : summary.files) files.push_back(to_json(file));
  return json_text_of(
      Json{{"files", std::move(files)},
           {"calibration",
            {{"file", summary.calibration_file}, {"imu", summary.imu}, {"verdict", summary.quality.verdict}, {"because", summary.quality.because}}}});
}

}  // namespace imulab
