#include "imulab/model/requirement.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/text.hpp"
#include "imulab/model/frame.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

constexpr std::string_view blanks = " \t\n";

/// The unit of this name that all of the coefficients can have: a group may be of scales and misalignments. `stated`: the requirement's text.
UserUnit required_unit(const Requirement& requirement, const std::string& stated, std::string_view name) {
  const auto has = [](CoefficientIndex index, std::string_view unit) {
    const auto units = user_units(coefficient(index));
    return std::any_of(units.begin(), units.end(), [&](const UserUnit& u) { return u.name == unit; });
  };
  std::string names;
  for (const UserUnit& u : user_units(coefficient(requirement.coefficients.front()))) {
    if (!std::all_of(requirement.coefficients.begin(), requirement.coefficients.end(), [&](CoefficientIndex i) { return has(i, u.name); })) continue;
    if (u.name == name) return u;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", u.name);
  }
  if (name.empty()) throw Error(fmt::format("{}: no unit after the number; expected one of {}", stated, names));
  throw Error(fmt::format("{}: \"{}\" is no unit of {}; expected one of {}", stated, name, requirement.selector, names));
}

Requirement parse_requirement(std::string_view text) {
  const auto sign = text.find("<=");
  if (sign == std::string_view::npos)
    throw Error(fmt::format("\"{}\": expected COEFFICIENTS <= NUMBER UNIT, as in \"gyro.matrix.off_diagonal <= 5 arcsec\"", trimmed(text, blanks)));
  Requirement out;
  out.selector = trimmed(text.substr(0, sign), blanks);
  out.coefficients = select_coefficients(out.selector);
  for (const CoefficientIndex index : out.coefficients)
    if (const Term term = coefficient(index).term; term != Term::offset && term != Term::matrix && term != Term::g_sensitivity)
      throw Error(fmt::format("{}: cannot be required; expected coefficients of offset, matrix or g_sensitivity", out.selector));
  const std::string_view value = trimmed(text.substr(sign + 2), blanks);
  const std::string stated = fmt::format("{} <= {}", out.selector, value);
  const char* const end = value.data() + value.size();
  const auto [after, failure] = std::from_chars(value.data(), end, out.limit);
  if (failure != std::errc() || !(out.limit > 0) || !std::isfinite(out.limit)) throw Error(stated + ": expected a number above 0");
  out.unit = required_unit(out, stated, trimmed({after, end}, blanks));
  out.limit *= out.unit.size;
  return out;
}

}  // namespace

std::string to_string(const Requirement& r) { return fmt::format("{} <= {:g} {}", r.selector, r.limit / r.unit.size, r.unit.name); }

double relative_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  const std::optional<double> sigma = standard_uncertainty(calibration, index);
  if (!sigma) return std::numeric_limits<double>::infinity();
  const Coefficient& c = coefficient(index);
  if (c.term != Term::matrix) return *sigma;
  return *sigma / std::abs(triad_model(calibration.model, c.triad).matrix(c.row, c.row));
}

RequirementResult assess(const Calibration& calibration, const Requirement& requirement) {
  RequirementResult out{to_string(requirement), std::string(coefficient(requirement.coefficients.front()).name), requirement.limit, 0, false};
  for (const CoefficientIndex index : requirement.coefficients) {
    if (calibration.frame == "accelerometers" && zero_by_frame(index)) continue;  // nothing to be determined
    const double reached = relative_uncertainty(calibration, index);
    if (!(reached > out.reached)) continue;
    out.coefficient = coefficient(index).name;
    out.reached = reached;
  }
  out.met = out.reached <= out.limit && calibration.quality.verdict != "doubtful";
  return out;
}

std::vector<Requirement> parse_requirements(std::string_view text) {
  std::vector<Requirement> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    out.push_back(parse_requirement(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return out;
}

}  // namespace imulab
