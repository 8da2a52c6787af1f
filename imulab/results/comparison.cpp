#include "imulab/results/comparison.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

std::string letter(std::size_t k) { return k < 26 ? std::string(1, static_cast<char>('A' + k)) : fmt::format("#{}", k + 1); }

std::string origin(const ComparedCalibration& c) {
  const std::string frame = c.frame == "rig" ? "the rig's frame" : "the accelerometers' frame";
  std::string text = fmt::format("{}  (", c.name);
  if (c.bare)
    text += "no uncertainties: taken as the truth";
  else
    text += fmt::format("{}{}{}", excerpt(c.imu), c.imu.empty() ? "" : ", ", excerpt(c.method));
  text += fmt::format("; {})", frame);
  if (!c.serial.empty()) text += fmt::format(", serial number {}", excerpt(c.serial));
  if (!c.date.empty()) text += fmt::format(", {} {}", c.dated, c.date);
  return text + (c.doubtful ? ", doubtful" : "");
}

std::string or_dash(const std::optional<double>& value, const char* format) { return value ? fmt::format(fmt::runtime(format), *value) : "-"; }

bool significant(const CoefficientDifference& d, double mark_from) { return std::abs(d.user_sigmas().value_or(0)) > mark_from; }

/// With one comparison: the difference, its uncertainty, and both in sigmas; per year where the dates are far enough apart. With several: each in
/// sigmas.
std::string heading(std::size_t comparisons, bool yearly) {
  std::string text = fmt::format("{:<21}", "coefficient");
  if (comparisons == 1) return text + fmt::format(" {:>12} {:>10} {:<15} {:>8}{}\n", "B - A", "u", "unit", "sigmas", yearly ? "  per year" : "");
  for (std::size_t k = 1; k <= comparisons; ++k) text += fmt::format(" {:>7}", letter(k) + " - A");
  return text + "  sigmas\n";
}

std::string coefficient_row(const std::vector<Comparison>& comparisons, std::size_t row, double mark_from, const std::optional<double>& years) {
  const CoefficientDifference& first = comparisons[0].coefficients[row];
  const auto sigmas = [&](const CoefficientDifference& d) { return or_dash(d.user_sigmas(), "{:+.1f}") + (significant(d, mark_from) ? "*" : " "); };
  std::string text = fmt::format("{:<21}", coefficient(first.index).name);
  if (comparisons.size() == 1) {
    const double sigma = first.user_uncertainty.value_or(0);
    text += fmt::format(" {:>12} {:>10} {:<15} {:>9}", text::to_digits_of(sigma, first.user_difference), sigma > 0 ? text::two_digits(sigma) : "-",
                        first.user_unit, sigmas(first));
    if (years) text += fmt::format(" {:>8}", text::to_digits_of(sigma / std::abs(*years), first.user_difference / *years));
  } else {
    for (const auto& c : comparisons) text += fmt::format(" {:>7}", sigmas(c.coefficients[row]));
  }
  return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

std::string tolerance_text(const RequirementResult& r) {
  const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
  const std::string reached = std::isfinite(r.reached) ? fmt::format("{} {}", text::number(r.reached / unit.size), unit.name) : "not determined";
  return text::wrapped("  tolerance  ", fmt::format("{}: {} ({}: {})", r.text, r.met ? "met" : "not met", r.coefficient, reached));
}

/// The values themselves, in SI.
std::string value_rows(const std::vector<Comparison>& comparisons) {
  std::string text = fmt::format("\n{:<21} {:>16}", "coefficient, SI", "A");
  for (std::size_t k = 1; k <= comparisons.size(); ++k) text += fmt::format(" {:>16}", letter(k));
  text += "\n";
  for (std::size_t row = 0; row < comparisons[0].coefficients.size(); ++row) {
    const CoefficientDifference& first = comparisons[0].coefficients[row];
    text += fmt::format("{:<21} {:>16.9g}", coefficient(first.index).name, first.a);
    for (const auto& c : comparisons) text += fmt::format(" {:>16.9g}", c.coefficients[row].b);
    text += "\n";
  }
  return text;
}

/// A chi-square of differences, judged against the stated uncertainties.
std::string verdict(const Consistency& c) {
  const char* size = c.p_value < 0.001 ? "larger than" : c.p_value > 0.999 ? "smaller than" : "as large as";
  return fmt::format("chi2 = {:.1f}, probability of more {:.2g}: the differences are {} the stated uncertainties say", c.chi2, c.p_value, size);
}

std::string test_text(const std::string& who, const Comparison& comparison, double mark_from) {
  const auto& rows = comparison.coefficients;
  const auto marked = std::count_if(rows.begin(), rows.end(), [&](const auto& d) { return significant(d, mark_from); });
  const auto tested = std::count_if(rows.begin(), rows.end(), [](const auto& d) { return d.user_sigmas().has_value(); });
  const Consistency& c = comparison.consistency;
  if (c.degrees_of_freedom == 0)
    return text::wrapped(who, "nothing to test: no coefficient has an uncertainty on one side and a value to compare it with on the other");
  return text::wrapped(who, fmt::format("{} of {} coefficients differ significantly (* beyond {:.1f} sigma: 1 % for all together)", marked, tested,
                                        mark_from)) +
         text::wrapped(std::string(who.size(), ' '), fmt::format("{} coefficients together: {}", c.degrees_of_freedom, verdict(c)));
}

/// The unit that was mounted elsewhere.
std::string translation_text(const std::optional<Vector3d>& translation) {
  if (!translation) return "";
  const Vector3d mm = 1e3 * *translation;
  return text::wrapped(
      "", fmt::format("Lever arms are compared about their mean point, which moved by ({:.3g}, {:.3g}, {:.3g}) mm.", mm.x(), mm.y(), mm.z()));
}

std::string agreement_text(const Agreement& agreement) {
  if (agreement.consistency.degrees_of_freedom == 0)
    return fmt::format("The {} calibrations have no coefficient in common: nothing to test.\n", agreement.calibrations);
  std::string differing;
  for (const auto& c : agreement.coefficients)
    if (c.differs) differing += fmt::format("{}{}", differing.empty() ? "" : ", ", coefficient(c.index).name);
  return text::wrapped("", fmt::format("All {} calibrations about their weighted mean, {} degrees of freedom: {}", agreement.calibrations,
                                       agreement.consistency.degrees_of_freedom, verdict(agreement.consistency))) +
         text::wrapped("", "Coefficients that differ among them: " + (differing.empty() ? "none" : differing));
}

}  // namespace

std::string comparison_table(const ComparisonSummary& summary, bool details) {
  const std::vector<Comparison>& comparisons = summary.comparisons;
  const double mark_from = significant_from(summary);
  const bool pair = comparisons.size() == 1;
  const std::optional<double> years = pair ? years_between(summary, 0) : std::nullopt;
  std::string out;
  if (const Conclusion about = conclusion_about(summary); !about.verdict.empty()) out += text::wrapped("", about.verdict + ": " + about.headline);
  for (const RequirementResult& r : summary.requirements) out += tolerance_text(r);
  for (std::size_t k = 0; k < comparisons.size(); ++k) out += test_text(pair ? "" : letter(k + 1) + " - A: ", comparisons[k], mark_from);
  if (summary.agreement) out += agreement_text(*summary.agreement);
  out += "\n";
  for (std::size_t k = 0; k < summary.calibrations.size(); ++k) out += text::wrapped(letter(k) + "  ", origin(summary.calibrations[k]));
  if (years) out += text::wrapped("", fmt::format("{:.2f} years from A to B.", *years));
  out += text::wrapped("", fmt::format("{} in the accelerometers' frame; quadratic and cubic terms are compared unrotated.", pair ? "Both" : "All"));
  for (const auto& c : comparisons) out += translation_text(c.translation);
  const RankedRows ranked = ranked_rows(comparisons, mark_from);
  const std::size_t shown = details || ranked.tested == 0 ? ranked.rows.size() : ranked.significant;
  if (shown > 0) out += "\n" + heading(comparisons.size(), years.has_value());
  for (std::size_t k = 0; k < shown; ++k) out += coefficient_row(comparisons, ranked.rows[k], mark_from, years);
  if (shown < ranked.rows.size())
    out +=
        text::wrapped(shown > 0 ? "" : "\n",
                      fmt::format("{} coefficients do not differ significantly{}; --verbose lists them", ranked.tested - shown,
                                  ranked.rows.size() > ranked.tested ? fmt::format(", {} are not tested", ranked.rows.size() - ranked.tested) : ""));
  return details ? out + value_rows(comparisons) : out;
}

}  // namespace imulab
