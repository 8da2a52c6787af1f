#include "imulab/analysis/requirement.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/coefficient.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace imulab {

using Eigen::Index;

namespace {

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\n"), end = text.find_last_not_of(" \t\n");
  return begin == std::string_view::npos ? std::string_view{} : text.substr(begin, end - begin + 1);
}

/// The unit of this name that all of the coefficients can have: a group may be of scales and misalignments.
UserUnit unit_of(const Requirement& requirement, std::string_view value, std::string_view name) {
  const auto row = [&](std::size_t k) -> const Coefficient& { return coefficient_table()[static_cast<std::size_t>(requirement.coefficients[k])]; };
  std::string names;
  for (const UserUnit& u : user_units(row(0))) {
    bool common = true;
    for (std::size_t k = 0; k < requirement.coefficients.size(); ++k) {
      const auto units = user_units(row(k));
      common = common && std::any_of(units.begin(), units.end(), [&](const UserUnit& other) { return other.name == u.name; });
    }
    if (common && u.name == name) return u;
    if (common) names += fmt::format("{}{}", names.empty() ? "" : ", ", u.name);
  }
  if (name.empty())
    throw Error(fmt::format("--require: {} <= {}: a unit was expected after the number, one of {}", requirement.selector, value, names));
  throw Error(fmt::format("--require: {} <= {}: \"{}\" is no unit of {}, one of {} was expected", requirement.selector, value, name,
                          requirement.selector, names));
}

Requirement parse_requirement(std::string_view text) {
  const auto sign = text.find("<=");
  if (trimmed(text).empty() || sign == std::string_view::npos)
    throw Error(
        fmt::format("--require: \"{}\": COEFFICIENTS <= NUMBER UNIT was expected, as in \"gyro.matrix.off_diagonal <= 5 arcsec\"", trimmed(text)));
  Requirement out{.selector = std::string(trimmed(text.substr(0, sign))), .coefficients = {}, .limit = 0, .unit = {}};
  try {
    out.coefficients = select_coefficients(out.selector);
  } catch (const Error& e) {
    throw Error(fmt::format("--require: {}", e.what()));
  }
  for (const int index : out.coefficients) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    if (c.term != Term::offset && c.term != Term::matrix && c.term != Term::g_sensitivity)
      throw Error(fmt::format("--require: {} is not estimated on a turntable: offset, matrix and g_sensitivity are", out.selector));
  }
  const std::string_view value = trimmed(text.substr(sign + 2));
  const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), out.limit);
  if (failure != std::errc() || !(out.limit > 0) || !std::isfinite(out.limit))
    throw Error(fmt::format("--require: {} <= {}: a number above 0 was expected", out.selector, value));
  const std::string_view unit = trimmed(std::string_view(end, static_cast<std::size_t>(value.data() + value.size() - end)));
  out.unit = unit_of(out, value, unit);
  out.limit *= out.unit.size;
  return out;
}

/// The declared sizes, or where there is none one that a factor can be found for.
TurntablePlan with_something_to_scale(TurntablePlan plan) {
  RigDeclaration& rig = plan.rig;
  const TableSetting declared = setting_of(plan);
  if (declared.angle == 0 && declared.orthogonality == 0 && declared.zero == 0) rig.angle = rig.orthogonality = rig.zero = {unit::arcsec, false};
  if (declared.timing == 0) rig.timing = {1e-3, false};
  return plan;
}

double shortest_hold(const TurntablePlan& plan) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Step& step : plan.observations.steps)
    if (step.kind == StepKind::hold) shortest = std::min(shortest, step.end - step.start);
  return shortest;
}

Tolerance search(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  const auto missed = [&](double factor) { return shortfalls(scaled(plan, knob, factor), requirements); };
  Tolerance out;
  double high = std::log(largest_factor(plan, knob)), low = std::log(perfect(knob));
  out.shortfalls = missed(std::exp(low));
  if (!out.shortfalls.empty()) return out;
  out.unlimited = missed(std::exp(high)).empty();
  if (out.unlimited) low = high;
  // Uncertainties grow with every source, so the limit is where they cross it; 0.5 % is finer than any declaration.
  while (high - low > 5e-3) {
    const double middle = 0.5 * (low + high);
    (missed(std::exp(middle)).empty() ? low : high) = middle;
  }
  out.factor = std::exp(low);
  out.setting = setting_of(scaled(plan, knob, *out.factor));
  return out;
}

}  // namespace

std::vector<Requirement> parse_requirements(std::string_view text) {
  std::vector<Requirement> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    out.push_back(parse_requirement(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return out;
}

void expect_estimated(const std::vector<Requirement>& requirements, const TurntablePlan& plan) {
  for (const Requirement& requirement : requirements)
    for (const int index : requirement.coefficients)
      if (std::find(plan.terms.begin(), plan.terms.end(), index) == plan.terms.end())
        throw Error(
            fmt::format("--require: {}: this unit's calibration does not estimate it; g-sensitivity is that of a grade that has it, such as mems",
                        requirement.selector));
}

std::string_view to_string(Knob knob) {
  switch (knob) {
    case Knob::table:
      return "table";
    case Knob::timing:
      return "timing";
    case Knob::imu:
      return "imu";
    case Knob::all:
      break;
  }
  return "all";
}

std::vector<Shortfall> shortfalls(const TurntablePlan& plan, const std::vector<Requirement>& requirements) {
  const TurntablePrediction prediction = predict(plan);
  const Eigen::VectorXd sigma = prediction.sigma();
  std::vector<Shortfall> out;
  for (const Requirement& requirement : requirements) {
    Shortfall worst{requirement, -1, requirement.limit, {}};
    for (const int index : requirement.coefficients) {
      const auto found = std::find(prediction.coefficients.begin(), prediction.coefficients.end(), index);
      if (found == prediction.coefficients.end()) {
        worst = {requirement, index, std::numeric_limits<double>::infinity(), "the procedure does not determine it"};
        break;
      }
      const Index row = found - prediction.coefficients.begin();
      if (sigma[row] <= worst.sigma) continue;
      Index largest;
      const double share = prediction.variance.row(row).maxCoeff(&largest);
      const bool second = std::pow(prediction.second_order[row], 2) > share;
      worst = {requirement, index, sigma[row], second ? "second order of the table's errors" : prediction.sources[static_cast<std::size_t>(largest)]};
    }
    if (worst.coefficient >= 0) out.push_back(worst);
  }
  return out;
}

TableSetting setting_of(const TurntablePlan& plan) {
  const RigDeclaration& rig = plan.rig;
  const auto drawn = [](const Spread& spread, const auto& given) {
    const bool known = std::all_of(given.begin(), given.end(), [](const auto& axis) { return axis.has_value(); });
    return spread.fixed || known ? 0 : spread.value;
  };
  const double angle = rig.angle.fixed ? 0 : rig.angle.value, timing = rig.timing.fixed ? 0 : rig.timing.value;
  return {angle,
          drawn(rig.orthogonality, rig.given_orthogonality),
          drawn(rig.zero, rig.given_zero),
          timing,
          plan.gyro_noise.N,
          plan.accel_noise.N,
          plan.gyro_noise.turn_on.value,
          plan.accel_noise.turn_on.value};
}

TurntablePlan scaled(TurntablePlan plan, Knob knob, double factor) {
  const auto scale = [&](Spread& spread) {  // what is fixed is known, and no uncertainty
    if (!spread.fixed) spread.value *= factor;
  };
  if (knob == Knob::table || knob == Knob::all)
    for (Spread* spread : {&plan.rig.angle, &plan.rig.orthogonality, &plan.rig.zero}) scale(*spread);
  if (knob == Knob::timing || knob == Knob::all) scale(plan.rig.timing);
  if (knob == Knob::imu || knob == Knob::all)
    for (NoiseModel* noise : {&plan.accel_noise, &plan.gyro_noise}) {
      noise->N *= factor;
      noise->turn_on.value *= factor;  // a fixed one too: the calibration does not know it
    }
  plan.observations = planned_observations(plan.observations.steps, plan.rig);
  return plan;
}

double perfect(Knob knob) { return knob == Knob::table || knob == Knob::timing ? 1e-6 : 1e-2; }

double largest_factor(const TurntablePlan& plan, Knob knob) {
  const TableSetting s = setting_of(with_something_to_scale(plan));
  // What is declared is taken as it is, even beyond.
  const double table = std::max(1.0, 600 * unit::arcsec / std::max({s.angle, s.orthogonality, s.zero}));
  const double timing = std::max(1.0, std::min(10.0, 0.05 * shortest_hold(plan)) / s.timing);
  switch (knob) {
    case Knob::table:
      return table;
    case Knob::timing:
      return timing;
    case Knob::imu:
      return 1e6;
    case Knob::all:
      break;
  }
  return std::min({table, timing, 1e6});
}

Tolerance tolerance(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  return search(with_something_to_scale(plan), knob, requirements);
}

Tolerance tolerance_alone(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements) {
  TurntablePlan alone = with_something_to_scale(plan);
  for (const Knob other : {Knob::table, Knob::timing, Knob::imu})
    if (other != knob) alone = scaled(alone, other, perfect(other));
  alone.site.given_gravity = alone.site.gravity();
  alone.site.given_gravity_sigma = 0;
  alone.site.latitude_sigma = 0;
  if (!alone.site.latitude) alone.site.latitude = 45 * unit::deg;  // any: Earth's rate is then known
  return search(alone, knob, requirements);
}

}  // namespace imulab
