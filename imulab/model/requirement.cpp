#include "imulab/calibration.hpp"
#include "imulab/core/nearest_name.hpp"
#include "imulab/core/stated_limit.hpp"
#include "imulab/core/unit_expression.hpp"
#include "imulab/error.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/model/relative_uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

/// A usual unit, and the size of the one that is stated, which may be a multiple of it.
struct RequiredUnit {
  UserUnit unit;
  double size;
};

/// Returns the unit of this name if all coefficients can have it: a group may contain scales and misalignments. `stated`: text of the requirement.
RequiredUnit required_unit(const Requirement& requirement, const std::string& stated, std::string_view name) {
  const auto has = [](CoefficientIndex index, std::string_view unit) {
    const auto units = user_units(coefficient(index));
    return std::any_of(units.begin(), units.end(), [&](const UserUnit& u) { return u.name == unit; });
  };
  std::vector<std::string> names;
  std::optional<RequiredUnit> other;  // another spelling or a multiple
  for (const UserUnit& u : user_units(coefficient(requirement.coefficients.front()))) {
    if (!std::all_of(requirement.coefficients.begin(), requirement.coefficients.end(), [&](CoefficientIndex i) { return has(i, u.name); })) continue;
    if (u.name == name) return {u, u.size};
    if (const auto size = size_of_unit_like(name, u.name, u.size); size && (!other || is_same_unit(name, u.name))) other = {u, *size};
    names.emplace_back(u.name);
  }
  if (other) return *other;
  if (name.empty()) throw Error(fmt::format("{}: no unit after the number; expected one of {}", stated, fmt::join(names, ", ")));
  throw Error(fmt::format("{}: \"{}\" is no unit of {}{}", stated, name, requirement.selector, expected_name(name, names)));
}

constexpr const char* cannot_be_required = "cannot be required; expected coefficients of offset (or bias), matrix or g_sensitivity";
bool can_be_required(CoefficientIndex index) {
  const Term term = coefficient(index).term;
  return term == Term::offset || term == Term::matrix || term == Term::g_sensitivity;
}

Requirement requirement_of(const StatedLimit& stated) {
  Requirement out;
  out.selector = stated.name;
  out.coefficients = select_coefficients(out.selector);
  for (const CoefficientIndex index : out.coefficients)
    if (!can_be_required(index)) throw Error(fmt::format("{}: {}", out.selector, cannot_be_required));
  if (stated.at_s) throw Error(to_string(stated) + ": a coefficient has no time; expected the number and its unit alone");
  const RequiredUnit unit = required_unit(out, to_string(stated), stated.unit);
  out.unit = unit.unit;
  out.limit = stated.number * unit.size;
  return out;
}

}  // namespace

std::vector<std::string> problems_of(const Requirement& r) {
  std::vector<std::string> problems = problems_of(r.coefficients);
  if (!problems.empty()) return problems;
  if (r.coefficients.empty()) return {r.selector + ": a requirement of no coefficient; expected one or more"};
  for (const CoefficientIndex index : r.coefficients)
    if (!can_be_required(index)) problems.push_back(fmt::format("{}: {}", coefficient(index).name, cannot_be_required));
  if (!(r.limit > 0 && std::isfinite(r.limit))) problems.push_back(fmt::format("{}: the limit is {:g}; expected more than 0", r.selector, r.limit));
  return problems;
}

std::string to_string(const Requirement& r) { return fmt::format("{} <= {:g} {}", r.selector, r.limit / r.unit.size, r.unit.name); }

bool is_result(const Calibration& calibration, CoefficientIndex index) {
  const Quality& q = calibration.quality;
  const auto named = [&](const std::vector<std::string>& list) { return std::ranges::find(list, coefficient(index).name) != list.end(); };
  return contains(calibration.estimated, index) && !named(q.considered) && !named(q.unobservable);
}

double relative_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  const std::optional<double> sigma = standard_uncertainty(calibration, index);
  if (!sigma) return std::numeric_limits<double>::infinity();
  const Coefficient& c = coefficient(index);
  if (c.term != Term::matrix) return *sigma;
  return *sigma / std::abs(triad_model(calibration.model, c.triad).matrix(c.row, c.row));
}

double StatedSigma::compared() const {
  return std::isfinite(sigma) ? sigma * std::max(1.0, 0.5 * coverage_factor(std::max(1.0, degrees_of_freedom))) : sigma;
}

RequirementResult compared(const Requirement& requirement, const std::function<StatedSigma(CoefficientIndex)>& of) {
  throw_problems("", problems_of(requirement));
  RequirementResult out{to_string(requirement), std::string(coefficient(requirement.coefficients.front()).name), requirement.limit, 0, true};
  StatedSigma worst;
  for (const CoefficientIndex index : requirement.coefficients) {
    const StatedSigma stated = of(index);
    out.met = out.met && stated.meets(requirement.limit);
    if (!(stated.compared() > out.reached)) continue;
    worst = stated;
    out.reached = stated.compared();
    out.coefficient = coefficient(index).name;
  }
  constexpr double alike = 1.02;  // equal in two digits of u
  if (std::isfinite(out.reached) && !worst.has_enough())
    out.note = fmt::format("{:.2g} degree{} of freedom, fewer than 3", worst.degrees_of_freedom, worst.degrees_of_freedom == 1 ? "" : "s");
  else if (std::isfinite(out.reached) && out.reached > alike * worst.sigma)
    out.note = fmt::format("U/2 at {:.0f} degrees of freedom", worst.degrees_of_freedom);
  return out;
}

RequirementResult assess(const Calibration& calibration, const Requirement& requirement) {
  validate(calibration);
  const auto fixed = [&](CoefficientIndex index) { return calibration.frame == BodyFrame::accelerometers && zero_by_frame(index); };
  RequirementResult out = compared(requirement, [&](CoefficientIndex index) {
    if (fixed(index)) return StatedSigma{};
    const double sigma = is_result(calibration, index) ? relative_uncertainty(calibration, index) : std::numeric_limits<double>::infinity();
    return StatedSigma{sigma, std::isfinite(sigma) ? expanded_uncertainty(calibration, index).degrees_of_freedom : 0};
  });
  if (std::ranges::all_of(requirement.coefficients, fixed)) out.note = "zero by the definition of the axes";
  if (calibration.quality.verdict == Verdict::doubtful) {
    out.met = false;
    if (out.note.empty() || out.reached > 0) out.note = "the calibration is doubtful";
  }
  return out;
}

std::vector<Requirement> parse_requirements(std::string_view text) {
  std::vector<Requirement> out;
  for (const StatedLimit& stated : parse_limits(text, "COEFFICIENTS <= NUMBER UNIT", "gyro.matrix.off_diagonal <= 5 arcsec"))
    out.push_back(requirement_of(stated));
  return out;
}

}  // namespace imulab
