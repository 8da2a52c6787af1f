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

/// As good as perfect, times what is declared: weights need some noise, the less the worse their condition.
double perfect(Knob knob) { return knob == Knob::table || knob == Knob::timing ? 1e-6 : 1e-2; }

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\n"), end = text.find_last_not_of(" \t\n");
  return begin == std::string_view::npos ? std::string_view{} : text.substr(begin, end - begin + 1);
}

Requirement parse_requirement(std::string_view text) {
  const auto sign = text.find("<=");
  if (trimmed(text).empty() || sign == std::string_view::npos)
    throw Error(fmt::format("--require: \"{}\": COEFFICIENTS <= NUMBER UNIT was expected, as in \"gyro.matrix.off_diagonal <= 5 arcsec\"", trimmed(text)));
  Requirement out{.selector = std::string(trimmed(text.substr(0, sign))), .coefficients = {}, .limit = 0, .unit = {}};
  try {
    out.coefficients = select_coefficients(out.selector);
  } catch (const Error& e) {
    throw Error(fmt::format("--require: {}", e.what()));
  }
  const std::string_view value = trimmed(text.substr(sign + 2));
  const auto [end, failure] = std::from_chars(value.data(), value.data() + value.size(), out.limit);
  if (failure != std::errc() || !(out.limit > 0) || !std::isfinite(out.limit))
    throw Error(fmt::format("--require: {} <= {}: a number above 0 was expected", out.selector, value));
  const std::string_view unit = trimmed(std::string_view(end, static_cast<std::size_t>(value.data() + value.size() - end)));
  for (const int index : out.coefficients) {  // a group may have scales and misalignments: a unit that both can have
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
    std::string names;
    const UserUnit* found = nullptr;
    for (const UserUnit& u : user_units(c)) {
      if (u.name == unit) found = &u;
      names += fmt::format("{}{}", names.empty() ? "" : ", ", u.name);
    }
    if (names.empty()) throw Error(fmt::format("--require: {} is not estimated on a turntable", c.name));
    if (found == nullptr)
      throw Error(fmt::format("--require: {} <= {}: \"{}\" is no unit of {}: one of {} was expected", out.selector, value, unit, c.name, names));
    out.unit = *found;
  }
  out.limit *= out.unit.size;
  return out;
}

/// The declared sizes, or where there is none one that a factor can be found for.
TurntablePlan with_something_to_scale(TurntablePlan plan) {
  RigDeclaration& rig = plan.rig;
  if (rig.angle.value == 0 && rig.orthogonality.value == 0 && rig.zero.value == 0)
    rig.angle.value = rig.orthogonality.value = rig.zero.value = unit::arcsec;
  if (rig.timing.value == 0) rig.timing.value = 1e-3;
  return plan;
}

double largest_factor(const TurntablePlan& plan, Knob knob) {
  const double table = unit::deg / std::max({plan.rig.angle.value, plan.rig.orthogonality.value, plan.rig.zero.value, 1e-6 * unit::arcsec});
  const double timing = 10 / std::max(plan.rig.timing.value, 1e-9);
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

TurntablePlan scaled(TurntablePlan plan, Knob knob, double factor) {
  if (knob == Knob::table || knob == Knob::all)
    for (Spread* spread : {&plan.rig.angle, &plan.rig.orthogonality, &plan.rig.zero}) spread->value *= factor;
  if (knob == Knob::timing || knob == Knob::all) plan.rig.timing.value *= factor;
  if (knob == Knob::imu || knob == Knob::all)
    for (NoiseModel* noise : {&plan.accel_noise, &plan.gyro_noise}) {
      noise->N *= factor;
      noise->turn_on.value *= factor;
    }
  plan.observations = planned_observations(plan.observations.steps, plan.rig);
  return plan;
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
  return search(alone, knob, requirements);
}

}  // namespace imulab
