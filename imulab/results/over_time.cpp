#include "imulab/results/over_time.hpp"

#include "imulab/formats/text/json_fields.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/results/aid_loss.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/thinned.hpp"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

namespace imulab {

using namespace result_io;
using Eigen::Vector3d;
using fields::How, fields::Presence, json_io::Field;

namespace {

constexpr std::size_t most_times = 200, most_errors = 500;
constexpr int digits = 6;  // of what only pictures need

template <class Fields>
void describe_vertical(Fields& f, VerticalChannel& vertical) {
  using enum VerticalChannel;
  fields::choice(f, "vertical", vertical, std::array{free, fixed, aided, held}, "free, fixed, aided or held");
}

// ---- error budgets

/// Rows of quantities, a column each time; the last column is the end.
template <class Rows>
struct Part {
  const char* name;
  Rows* rows;
};
using BudgetPart = Part<BudgetRows>;
using SampledPart = Part<decltype(ErrorDistribution::mean)>;

/// Fixed errors and sigmas of the nine quantities at the end.
template <class Fields>
void describe_end(Fields& f, BudgetRows& fixed, BudgetRows& sigma) {
  if (Fields::reads) fixed.setZero(budget_quantities, 1), sigma.setZero(budget_quantities, 1);
  for (const auto& [key, first] : {std::pair{"position_m", 0}, {"velocity_mps", 3}, {"attitude_arcsec", 6}})
    f.table(key, [&, begin = first](auto& block) {
      for (const BudgetPart& part : {BudgetPart{"fixed", &fixed}, BudgetPart{"sigma", &sigma}}) {
        auto end = part.rows->rightCols(1).template middleRows<3>(begin);
        fields::via(
            block, part.name, [&] { return Vector3d(end); }, [&](const Vector3d& v) { end = v; }, fields::in(quantity_size(begin)));
      }
    });
}

/// The first `quantities` rows at some times. Where they are read the other rows are zero, and the last column, which is known better, stays.
template <class Fields, class Rows>
void describe_over_time(Fields& f, std::initializer_list<Part<Rows>> parts, Eigen::Index quantities, const std::vector<std::size_t>& at) {
  for (const Part<Rows>& part : parts)
    if (Fields::reads) {
      const Rows end = *part.rows;
      part.rows->setZero(end.rows(), static_cast<Eigen::Index>(at.size()));
      part.rows->rightCols(1) = end;
    }
  for (Eigen::Index q = 0; q < quantities; ++q)
    f.table(quantity_names[static_cast<std::size_t>(q)], [&](auto& quantity) {
      for (const Part<Rows>& part : parts) {
        const auto get = [&] {
          std::vector<double> list;
          for (const std::size_t i : at) list.push_back((*part.rows)(q, static_cast<Eigen::Index>(i)));
          return list;
        };
        const auto set = [&](const std::vector<double>& list) {
          fields::check(quantity, list.size() == at.size(), part.name, "expected " + std::to_string(at.size()) + " numbers");
          for (std::size_t i = 0; i + 1 < at.size(); ++i) (*part.rows)(q, static_cast<Eigen::Index>(i)) = list[i];
        };
        fields::via(quantity, part.name, get, set, {.size = quantity_size(q), .digits = digits});
      }
    });
}

template <class Fields>
void describe_distribution(Fields& f, ErrorDistribution& d, std::uint64_t& runs) {
  const std::initializer_list<SampledPart> parts{{"mean", &d.mean}, {"sigma", &d.sigma}, {"low", &d.low}, {"median", &d.median}, {"high", &d.high}};
  f("runs", runs);
  for (const SampledPart& part : parts)
    if (Fields::reads) part.rows->setZero(budget_quantities + 1, 1);
  for (Eigen::Index q = 0; q <= budget_quantities; ++q)
    f.table(quantity_names[static_cast<std::size_t>(q)], [&](auto& quantity) {
      for (const SampledPart& part : parts) quantity(part.name, (*part.rows)(q, part.rows->cols() - 1), fields::in(quantity_size(q)));
    });
  const How rate = fields::in(unit::nmi_per_h);
  f.table("rate_nmi_per_h", [&](auto& t) { t("rms", d.drift_rms, rate), t("cep", d.drift_cep, rate), t("95_percent", d.drift_95, rate); });
}

/// The pictures over time need all of the total and the horizontal position of each source.
template <class Fields>
void describe_history(Fields& f, BudgetSummary& s, BudgetRows& sigma) {
  constexpr Eigen::Index horizontal = 2;
  ErrorBudget& b = s.budget;
  bool sampled = s.monte_carlo && s.monte_carlo->time.size() == b.time.size();
  if constexpr (Fields::reads) sampled = s.monte_carlo && f.at().has("monte_carlo");
  std::vector<double> time = thinned_rows(b.time, most_times);
  f("time_s", time, {.digits = stamp_digits});
  fields::check(f, !time.empty() && std::is_sorted(time.begin(), time.end()), "time_s", "expected ascending times");
  const std::vector<std::size_t> at = Fields::reads ? thinned(time.size(), time.size()) : thinned(b.time.size(), most_times);
  f.table("total", [&](auto& total) { describe_over_time(total, {BudgetPart{"fixed", &b.mean}, {"sigma", &sigma}}, budget_quantities, at); });
  f.table("sources", [&](auto& all) {
    for (Contribution& c : b.groups)
      all.table(c.name, [&](auto& one) { describe_over_time(one, {BudgetPart{"fixed", &c.fixed}, {"sigma", &c.sigma}}, horizontal, at); });
  });
  if (sampled) {
    ErrorDistribution& d = *s.monte_carlo;
    f.table("monte_carlo", [&](auto& all) {
      describe_over_time(all, {SampledPart{"low", &d.low}, {"median", &d.median}, {"high", &d.high}}, budget_quantities + 1, at);
    });
    if (Fields::reads) d.time = time;
  }
  if (Fields::reads) b.time = time;
}

}  // namespace

template <class Fields>
void describe(Fields& f, Contribution& c) {
  describe_end(f, c.fixed, c.sigma);
}

template <class Fields>
void describe(Fields& f, AidLoss& loss) {
  f("begin_s", loss.begin), f("aids", loss.aids);
}

template <class Fields>
void describe(Fields& f, BudgetSummary& s) {
  ErrorBudget& b = s.budget;
  BudgetRows sigma;
  if constexpr (Fields::reads) {
    b.time.resize(1);
    if (f.at().has("monte_carlo")) s.monte_carlo.emplace().time.resize(1);
  } else {
    sigma = total_sigma(b);
  }
  f("grade", s.grade, fields::if_any), f("noise", s.noise, fields::if_any);
  f("time_s", b.time.back());
  describe_vertical(f, b.vertical);
  f("loss", b.loss, fields::if_any);
  if constexpr (!Fields::reads)
    if (b.loss) f("after_loss", after_loss_json(b));
  f.table("total", [&](auto& total) { describe_end(total, b.mean, sigma); });
  describe_by_name(f, "sources", b.groups, fields::if_any), describe_by_name(f, "coefficients", b.coefficients, fields::if_any);
  if constexpr (!Fields::reads) f("shares", shares_at_end(b));
  if (s.monte_carlo) f.table("monte_carlo", [&](auto& sampled) { describe_distribution(sampled, *s.monte_carlo, s.runs); });
  if (Fields::reads && s.monte_carlo) s.monte_carlo->time = b.time;
  f.table(
      "history", [&](auto& history) { describe_history(history, s, sigma); }, fields::optional);
  if (Fields::reads)
    for (Eigen::Index i = 0; i < sigma.cols(); ++i) b.covariance.emplace_back(sigma.col(i).array().square().matrix().asDiagonal());
}

std::string budget_json(const ErrorBudget& b, const std::optional<ErrorDistribution>& monte_carlo, const std::vector<NavigationState>& track,
                        const std::string& grade, const std::string& noise) {
  JsonWriter writer;
  BudgetSummary summary{b, monte_carlo, monte_carlo ? monte_carlo->runs : 0, thinned_rows(track, most_places), grade, noise};
  describe(writer, summary);
  describe_track(writer, summary.track);
  return result_text("budget", writer.out, JsonLayout::long_lists);
}

// ---- navigation

namespace {

/// The position error at the end; SI.
struct PositionError {
  Vector3d position;
  double horizontal = 0, rate = 0;
};

template <class Fields>
void describe_errors(Fields& f, std::vector<NavigationError>& history) {
  using E = NavigationError;
  fields::column(f, "time_s", history, true, {.digits = stamp_digits}, [](E& e) -> double& { return e.time; });
  for (const auto& [key, member, size] :
       {std::tuple{"position_m", &E::position, 1.0}, {"velocity_mps", &E::velocity, 1.0}, {"attitude_arcsec", &E::attitude, unit::arcsec}}) {
    std::array<std::vector<double>, 3> lists;
    for (std::size_t k = 0; k < 3 && !Fields::reads; ++k)
      for (const E& e : history) lists[k].push_back((e.*member)[static_cast<Eigen::Index>(k)]);
    f(key, lists, {.size = size, .things = "lists of numbers", .digits = digits});
    for (std::size_t k = 0; k < 3 && Fields::reads; ++k) {
      fields::check(f, lists[k].size() == history.size(), key, "expected lists of " + std::to_string(history.size()) + " numbers");
      for (std::size_t i = 0; i < history.size(); ++i) (history[i].*member)[static_cast<Eigen::Index>(k)] = lists[k][i];
    }
  }
}

}  // namespace

template <class Fields>
void describe(Fields& f, PositionError& e) {
  f("east_m", e.position.x()), f("north_m", e.position.y()), f("up_m", e.position.z());
  fields::derived(f, "horizontal_m", e.horizontal);
  f("rate_nmi_per_h", e.rate, fields::in(unit::nmi_per_h));
}

template <class Fields>
void describe(Fields& f, MissingTime& gap) {
  f("begin_s", gap.begin), f("length_s", gap.length);
}

template <class Fields>
void describe(Fields& f, AlignedOn& aligned) {
  FineAlignment& a = aligned.alignment;
  const auto angles = [&] {
    const EulerAngles e = euler_angles(a.attitude.C_nb);
    return Vector3d(e.roll, e.pitch, e.heading);
  };
  f("begin_s", aligned.begin), f("end_s", aligned.end);
  const auto set = [&](const Vector3d& v) { a.attitude.C_nb = attitude_matrix({v[0], v[1], v[2]}); };
  fields::via(f, "roll_pitch_heading_deg", angles, set, fields::in(unit::deg));
  if constexpr (!Fields::reads) f("standard_uncertainty_deg", angle_sigmas(a.attitude), fields::in(unit::deg));
  f("covariance_enu_rad2", a.attitude.covariance);
  f("gyro_noise_density", a.gyro_noise, fields::if_known), f("accel_noise_density", a.accel_noise, fields::if_known);
  f("base_displacement_m", a.base_displacement, fields::if_known), f("innovation_square", a.innovation_square, fields::if_known);
  f("innovation_correlation", a.innovation_correlation, fields::if_known);
}

template <class Fields>
void describe(Fields& f, NavigatedSession& session) {
  Navigated& n = session.navigated;
  std::optional<PositionError> position;
  std::optional<Vector3d> velocity, attitude;
  std::optional<BudgetSummary> explained;
  std::array<double, 2> time{};
  NavigationErrors errors;
  NavigationError end;
  std::vector<std::string> warnings = n.warnings;
  std::vector<NavigationState> track = thinned_rows(n.track, most_places);
  if (!Fields::reads && session.errors) {
    errors = {thinned_rows(session.errors->history, most_errors), session.errors->rate, {}};
    end = errors.history.back(), velocity = end.velocity, attitude = end.attitude;
    position = {end.position, end.horizontal(), errors.rate};
    warnings.insert(warnings.end(), session.errors->warnings.begin(), session.errors->warnings.end());
  }
  if (!Fields::reads) time = {n.solution.time.front(), n.solution.time.back()};
  if (!Fields::reads && session.explained) explained = BudgetSummary{*session.explained, {}};
  f("session", session.session), f("position_error", position), f("velocity_error_mps", velocity, fields::optional);
  f("attitude_error_arcsec", attitude, {.presence = Presence::optional, .size = unit::arcsec});
  fields::check(f, !position || velocity, "velocity_error_mps", "expected 3 numbers");
  fields::check(f, !position || attitude, "attitude_error_arcsec", "expected 3 numbers");
  if (position) f("error_time_s", end.time);
  describe_vertical(f, n.vertical);
  f("time_s", time), f("alignment", n.aligned, fields::optional), f("gaps", n.gaps, fields::optional);
  f("saturated", n.saturated, fields::optional), f("warnings", warnings, fields::optional);
  if (position)
    f.table(
        "errors_over_time", [&](auto& over_time) { describe_errors(over_time, errors.history); }, fields::optional);
  describe_track(f, track);
  f("explained", explained, fields::optional), f("not_explained", session.unexplained, fields::if_any);
  if (!Fields::reads) return;
  n.solution.time.assign(time.begin(), time.end()), n.warnings = std::move(warnings), n.track = std::move(track);
  if (explained) session.explained = std::move(explained->budget);
  if (!position) return;
  if (!errors.history.empty()) errors.history.pop_back();
  errors.history.push_back({end.time, position->position, *velocity, *attitude}), errors.rate = position->rate;
  session.errors = std::move(errors);
}

std::string navigation_json(const std::vector<NavigatedSession>& sessions) {
  if (sessions.size() == 1) {
    JsonValue one = written(sessions[0]);
    std::erase_if(std::get<JsonFields>(one.is).fields, [](const auto& field) { return field.first == "warnings"; });  // the answer's own have them
    return result_text("navigation", one, JsonLayout::long_lists);
  }
  std::vector<double> rates;
  for (const auto& session : sessions)
    if (session.errors) rates.push_back(session.errors->rate / unit::nmi_per_h);
  JsonValue rate;
  if (!rates.empty()) rate = JsonFields{{{"rms", rate_summary(rates).rms}, {"cep", rate_summary(rates).cep}, {"sessions", rates.size()}}};
  return result_text("navigation", JsonFields{{{"sessions", written(sessions)}, {"rate_nmi_per_h", rate}}}, JsonLayout::long_lists);
}

namespace result_io {

BudgetSummary budget_of(const Field& root) {
  BudgetSummary out;
  JsonReader reader(root);
  describe(reader, out);
  describe_track(reader, out.track);
  return out;
}

NavigationSummary navigation_of(const Field& root) {
  NavigationSummary out(1);
  JsonReader reader(root);
  if (!root.has("sessions"))
    describe(reader, out.front());
  else
    reader("sessions", out);
  if (out.empty()) root["sessions"].fail("is empty; expected at least one session");
  return out;
}

}  // namespace result_io

}  // namespace imulab
