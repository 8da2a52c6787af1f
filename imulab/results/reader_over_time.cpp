// Navigation, error budgets and compensated recordings back from their JSON.
#include "imulab/core/units.hpp"
#include "imulab/navigation/integration/strapdown.hpp"
#include "imulab/results/budget_quantities.hpp"
#include "imulab/results/reader_parts.hpp"

#include <algorithm>

namespace imulab::result_io {
namespace {

VerticalChannel vertical_at(const Field& f) {
  const std::string vertical = f.text();
  for (const VerticalChannel channel : {VerticalChannel::free, VerticalChannel::fixed, VerticalChannel::aided, VerticalChannel::held})
    if (to_string(channel) == vertical) return channel;
  f.expected("free, fixed, aided or held");
}

/// Empty where it is not known.
std::vector<NavigationState> track_at(const Field& root) {
  std::vector<NavigationState> states;
  if (!root.has("track") || root["track"].is_null()) return states;
  const Field track = root["track"];
  const std::vector<double> latitude = numbers_at(track["latitude_deg"]);
  const std::vector<double> longitude = numbers_at(track["longitude_deg"], latitude.size()), height = numbers_at(track["height_m"], latitude.size());
  states.resize(latitude.size());
  for (std::size_t i = 0; i < states.size(); ++i)
    states[i].latitude = latitude[i] * unit::deg, states[i].longitude = longitude[i] * unit::deg, states[i].height = height[i];
  return states;
}

// ---- error budgets

/// Fixed errors or sigmas of the nine quantities at the end, SI.
BudgetRows rows_at(const Field& f, const char* part) {
  BudgetRows out(budget_quantities, 1);
  // Read first: Eigen's list of initial values must not be left by an exception.
  const Eigen::Vector3d position = vector_at(f["position_m"][part]), velocity = vector_at(f["velocity_mps"][part]);
  const Eigen::Vector3d attitude = vector_at(f["attitude_arcsec"][part]) * unit::arcsec;
  out.col(0) << position, velocity, attitude;
  return out;
}

std::vector<Contribution> contributions_at(const Field& root, const char* key) {
  std::vector<Contribution> out;
  if (!root.has(key)) return out;
  const Field all = root[key];
  for (const std::string& name : all.keys()) out.push_back({name, rows_at(all[name], "fixed"), rows_at(all[name], "sigma")});
  return out;
}

ErrorDistribution distribution_at(const Field& f) {
  ErrorDistribution d;
  for (auto* rows : {&d.mean, &d.sigma, &d.low, &d.median, &d.high}) rows->resize(budget_quantities + 1, 1);
  for (Eigen::Index q = 0; q <= budget_quantities; ++q) {
    const Field at = f[quantity_names.at(static_cast<std::size_t>(q))];
    const double unit = unit_of(q);
    d.mean(q, 0) = at["mean"].number() * unit, d.sigma(q, 0) = at["sigma"].number() * unit;
    d.low(q, 0) = at["low"].number() * unit, d.median(q, 0) = at["median"].number() * unit, d.high(q, 0) = at["high"].number() * unit;
  }
  d.drift_rms = f["rate_nmi_per_h"]["rms"].number() * unit::nmi_per_h;
  d.drift_cep = f["rate_nmi_per_h"]["cep"].number() * unit::nmi_per_h;
  d.drift_95 = f["rate_nmi_per_h"]["95_percent"].number() * unit::nmi_per_h;
  return d;
}

/// Over time in the first `quantities` rows and zero in the others; the last column, which is known better, stays.
template <class Rows>
void spread_over_time(Rows& rows, const Field& f, const char* part, Eigen::Index quantities, std::size_t times) {
  const Rows end = rows;
  rows.setZero(end.rows(), static_cast<Eigen::Index>(times));
  for (Eigen::Index q = 0; q < quantities; ++q) {
    const std::vector<double> list = numbers_at(f[quantity_names.at(static_cast<std::size_t>(q))][part], times, unit_of(q));
    rows.row(q) = Eigen::Map<const Eigen::RowVectorXd>(list.data(), static_cast<Eigen::Index>(times));
  }
  rows.col(rows.cols() - 1) = end.col(0);
}

/// The end alone becomes what there was over time.
void add_history(BudgetSummary& out, BudgetRows& sigma, const Field& history) {
  constexpr Eigen::Index horizontal = 2;
  ErrorBudget& b = out.budget;
  const std::vector<double> time = numbers_at(history["time_s"]);
  if (time.empty() || !std::is_sorted(time.begin(), time.end())) history["time_s"].fail("expected ascending times");
  spread_over_time(b.mean, history["total"], "fixed", budget_quantities, time.size());
  spread_over_time(sigma, history["total"], "sigma", budget_quantities, time.size());
  for (Contribution& c : b.groups) {
    spread_over_time(c.fixed, history["sources"][c.name], "fixed", horizontal, time.size());
    spread_over_time(c.sigma, history["sources"][c.name], "sigma", horizontal, time.size());
  }
  b.time = time;
  if (!out.monte_carlo || !history.has("monte_carlo")) return;
  ErrorDistribution& d = *out.monte_carlo;
  for (const auto& [rows, part] : {std::pair{&d.low, "low"}, std::pair{&d.median, "median"}, std::pair{&d.high, "high"}})
    spread_over_time(*rows, history["monte_carlo"], part, budget_quantities + 1, time.size());
  d.time = time;
}

// ---- navigation

AlignedOn aligned_at(const Field& f) {
  AlignedOn out;
  out.begin = f["begin_s"].number(), out.end = f["end_s"].number();
  const Eigen::Vector3d angles = vector_at(f["roll_pitch_heading_deg"]) * unit::deg;
  out.alignment.attitude.C_nb = attitude_matrix({angles[0], angles[1], angles[2]});
  for (std::size_t i = 0; i < 3; ++i)
    out.alignment.attitude.covariance.row(static_cast<Eigen::Index>(i)) = vector_at(f["covariance_enu_rad2"].item(i, 3, "rows of 3 numbers"));
  return out;
}

std::vector<NavigationError> errors_at(const Field& f) {
  const std::vector<double> time = numbers_at(f["time_s"]);
  std::vector<NavigationError> out(time.size());
  for (std::size_t k = 0; k < 3; ++k) {
    const auto row = [&](const char* key, double unit) { return numbers_at(f[key].item(k, 3, "lists of numbers"), time.size(), unit); };
    const std::vector<double> position = row("position_m", 1), velocity = row("velocity_mps", 1), attitude = row("attitude_arcsec", unit::arcsec);
    const auto axis = static_cast<Eigen::Index>(k);
    for (std::size_t i = 0; i < time.size(); ++i)
      out[i].time = time[i], out[i].position[axis] = position[i], out[i].velocity[axis] = velocity[i], out[i].attitude[axis] = attitude[i];
  }
  return out;
}

NavigatedSession session_of(const Field& f) {
  NavigatedSession out;
  out.session = f["session"].text();
  out.navigated.solution.time = {f["time_s"].item(0, 2, "numbers").number(), f["time_s"].item(1, 2, "numbers").number()};
  out.navigated.track = track_at(f);
  out.navigated.vertical = vertical_at(f["vertical"]);
  if (f.has("alignment") && !f["alignment"].is_null()) out.navigated.aligned = aligned_at(f["alignment"]);
  out.navigated.gaps = f.list("gaps", [](const Field& g) { return MissingTime{g["begin_s"].number(), g["length_s"].number()}; });
  if (f.has("saturated")) out.navigated.saturated = f["saturated"].size_in_bytes();
  out.navigated.warnings = f.texts("warnings");
  if (f.has("explained") && !f["explained"].is_null()) out.explained = budget_of(f["explained"]).budget;
  out.unexplained = f.text_or_empty("not_explained");
  if (f["position_error"].is_null()) return out;
  const Field position = f["position_error"];
  NavigationErrors errors;
  if (f.has("errors_over_time")) errors.history = errors_at(f["errors_over_time"]);
  const NavigationError end{f["error_time_s"].number(),
                            {position["east_m"].number(), position["north_m"].number(), position["up_m"].number()},
                            vector_at(f["velocity_error_mps"]),
                            vector_at(f["attitude_error_arcsec"]) * unit::arcsec};
  if (!errors.history.empty()) errors.history.pop_back();
  errors.history.push_back(end);
  errors.rate = position["rate_nmi_per_h"].number() * unit::nmi_per_h;
  out.errors = std::move(errors);
  return out;
}

// ---- compensated recordings

Overview overview_at(const Field& f) {
  Overview o;
  o.samples_per_interval = f["samples_per_interval"].size_in_bytes();
  o.time = numbers_at(f["time_s"]);
  o.first_s = f.has("first_s") ? f["first_s"].number() : o.time.empty() ? 0 : o.time.front();
  const auto columns = [&](const char* key, double unit) {
    Columns3 out;
    for (std::size_t k = 0; k < 3; ++k) out[k] = numbers_at(f[key].item(k, 3, "lists of numbers"), o.time.size(), unit);
    return out;
  };
  o.rate = columns("rate_deg_per_s", unit::deg);
  o.force = columns("force_mps2", 1);
  if (f.has("temperature")) o.temperature = columns("temperature", 1);
  return o;
}

CompensatedFile compensated_at(const Field& f) {
  CompensatedFile out;
  out.file = f["file"].text();
  out.samples = f["samples"].size_in_bytes(), out.saturated = f["saturated"].size_in_bytes();
  out.out_of_range = f["outside_calibrated_temperatures"].size_in_bytes(), out.replaced = f["outliers_replaced"].size_in_bytes();
  if (!f.has("overview")) return out;
  out.recording = f["recording"].text();
  out.rate_hz = f["rate_hz"].number();
  out.gaps = f["gaps"].size_in_bytes();
  out.overview = overview_at(f["overview"]);
  return out;
}

}  // namespace

BudgetSummary budget_of(const Field& root) {
  BudgetSummary out;
  ErrorBudget& b = out.budget;
  b.time = {root["time_s"].number()};
  b.vertical = vertical_at(root["vertical"]);
  b.mean = rows_at(root["total"], "fixed");
  BudgetRows sigma = rows_at(root["total"], "sigma");
  b.groups = contributions_at(root, "sources");
  b.coefficients = contributions_at(root, "coefficients");
  if (root.has("monte_carlo")) {
    out.monte_carlo = distribution_at(root["monte_carlo"]);
    out.monte_carlo->time = b.time;
    out.runs = root["monte_carlo"]["runs"].size_in_bytes();
  }
  if (root.has("history")) add_history(out, sigma, root["history"]);
  for (Eigen::Index i = 0; i < sigma.cols(); ++i) b.covariance.emplace_back(sigma.col(i).array().square().matrix().asDiagonal());
  out.track = track_at(root);
  return out;
}

NavigationSummary navigation_of(const Field& root) {
  NavigationSummary out = root.has("sessions") ? root["sessions"].list(session_of) : NavigationSummary{session_of(root)};
  if (out.empty()) root["sessions"].fail("is empty; expected at least one session");
  return out;
}

CompensationSummary compensation_of(const Field& root) {
  CompensationSummary out;
  const Field calibration = root["calibration"];
  out.calibration_file = calibration["file"].text();
  out.imu = calibration["imu"].text();
  out.quality.verdict = calibration["verdict"].text();
  out.quality.because = calibration.texts("because");
  out.files = root["files"].list(compensated_at);
  if (out.files.empty()) root["files"].fail("is empty; expected at least one recording");
  return out;
}

}  // namespace imulab::result_io
