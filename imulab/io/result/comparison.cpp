#include "imulab/io/result/comparison.hpp"

#include "imulab/model/coefficient.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

std::string letter(std::size_t k) { return k < 26 ? std::string(1, static_cast<char>('A' + k)) : fmt::format("#{}", k + 1); }

std::string origin(const NamedCalibration& named) {
  const Calibration& c = named.calibration;
  const std::string frame = c.frame == "rig" ? "the rig's frame" : "the accelerometers' frame";
  if (c.estimated.empty()) return fmt::format("{}  (no uncertainties: taken as the truth; {})", named.name, frame);
  return fmt::format("{}  ({}{}{}; {})", named.name, c.imu, c.imu.empty() ? "" : ", ", c.method, frame);
}

std::string or_dash(const std::optional<double>& value, const char* format) { return value ? fmt::format(fmt::runtime(format), *value) : "-"; }

bool significant(const CoefficientDifference& d, double mark_from) { return std::abs(d.user_sigmas().value_or(0)) > mark_from; }

/// One comparison has room for b and for the uncertainty.
std::string heading(std::size_t comparisons) {
  const bool pair = comparisons == 1;
  std::string text = fmt::format("{:<24} {:>15}", "coefficient", "A");
  if (pair) text += fmt::format(" {:>15}", "B");
  for (std::size_t k = 1; k <= comparisons; ++k) text += fmt::format(" {:>11}", letter(k) + " - A");
  if (pair) text += fmt::format(" {:>9}", "+/-");
  text += fmt::format(" {:<20}", "unit");
  for (std::size_t k = 1; k <= comparisons; ++k)
    text += fmt::format(" {:>8}{}", pair ? "sigmas" : letter(k) + " sigmas", k < comparisons ? "  " : "");
  return text + "\n";
}

std::string coefficient_row(const std::vector<Comparison>& comparisons, std::size_t row, double mark_from) {
  const bool pair = comparisons.size() == 1;
  const CoefficientDifference& first = comparisons[0].coefficients[row];
  std::string text = fmt::format("{:<24} {:>15.8g}", coefficient(first.index).name, first.a);
  if (pair) text += fmt::format(" {:>15.8g}", first.b);
  for (const auto& c : comparisons) text += fmt::format(" {:>11.4g}", c.coefficients[row].user_difference);
  if (pair) text += fmt::format(" {:>9}", or_dash(first.user_uncertainty, "{:.2g}"));
  text += fmt::format(" {:<20}", first.user_unit);
  for (const auto& c : comparisons)
    text += fmt::format(" {:>8}{}", or_dash(c.coefficients[row].user_sigmas(), "{:+.1f}"), significant(c.coefficients[row], mark_from) ? " *" : "  ");
  return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

/// How a chi-square of differences stands to the stated uncertainties.
std::string verdict(const Consistency& c) {
  const char* size = c.p_value < 0.001 ? "larger than" : c.p_value > 0.999 ? "smaller than" : "as large as";
  return fmt::format("chi2 = {:.1f}, probability of more {:.2g}: the differences are {} the stated uncertainties say", c.chi2, c.p_value, size);
}

std::string test_text(const std::string& who, const Comparison& comparison, double mark_from) {
  const auto& rows = comparison.coefficients;
  const auto marked = std::count_if(rows.begin(), rows.end(), [&](const auto& d) { return significant(d, mark_from); });
  const auto tested = std::count_if(rows.begin(), rows.end(), [](const auto& d) { return d.user_sigmas().has_value(); });
  std::string text =
      fmt::format("{}{} of {} coefficients differ significantly (* beyond {:.1f} sigma: 1 % for all together).\n", who, marked, tested, mark_from);
  const Consistency& c = comparison.consistency;
  if (c.degrees_of_freedom > 0) return text + fmt::format("{}{} coefficients together: {}.\n", who, c.degrees_of_freedom, verdict(c));
  return text + fmt::format("{}No coefficient has an uncertainty on one side and a value to compare it with on the other: nothing to test.\n", who);
}

std::string agreement_text(const Agreement& agreement) {
  if (agreement.consistency.degrees_of_freedom == 0)
    return fmt::format("The {} calibrations have no coefficient in common: nothing to test.\n", agreement.calibrations);
  std::string differing;
  for (const auto& c : agreement.coefficients)
    if (c.differs) differing += fmt::format("{}{}", differing.empty() ? "" : ", ", coefficient(c.index).name);
  return fmt::format("All {} calibrations about their weighted mean, {} degrees of freedom: {}.\nCoefficients that differ among them: {}.\n",
                     agreement.calibrations, agreement.consistency.degrees_of_freedom, verdict(agreement.consistency),
                     differing.empty() ? "none" : differing);
}

}  // namespace

std::string comparison_table(const std::vector<NamedCalibration>& calibrations, const std::vector<Comparison>& comparisons,
                             const std::optional<Agreement>& agreement) {
  std::size_t tests = 0;
  for (const auto& c : comparisons)
    for (const auto& d : c.coefficients) tests += d.user_sigmas().has_value();
  const double mark_from = significant_sigmas(tests);
  const bool pair = comparisons.size() == 1;
  std::string text;
  for (std::size_t k = 0; k < calibrations.size(); ++k) text += fmt::format("{}  {}\n", letter(k), origin(calibrations[k]));
  text += fmt::format("{} in the accelerometers' frame; quadratic and cubic terms are compared unrotated. {} in SI.\n\n", pair ? "Both" : "All",
                      pair ? "A and B" : "A");
  text += heading(comparisons.size());
  for (std::size_t row = 0; row < comparisons[0].coefficients.size(); ++row) text += coefficient_row(comparisons, row, mark_from);
  text += "\n";
  for (std::size_t k = 0; k < comparisons.size(); ++k) text += test_text(pair ? "" : letter(k + 1) + " - A: ", comparisons[k], mark_from);
  return agreement ? text + agreement_text(*agreement) : text;
}

}  // namespace imulab
