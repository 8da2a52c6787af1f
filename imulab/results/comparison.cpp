#include "imulab/results/comparison.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/result_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

std::string origin(const ComparedCalibration& c) {
  const std::string frame = c.frame == BodyFrame::rig ? "the rig's frame" : "the accelerometers' frame";
  std::string text = fmt::format("{}  (", one_line(c.name));
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

constexpr std::size_t most_pairs_beside = 6;  // of comparisons, in the width of a terminal

/// With one comparison: the difference, its uncertainty, and both in sigmas; per year where the dates are far enough apart. With several: each in
/// sigmas; with more than fit, the largest.
std::string heading(std::size_t comparisons, bool yearly) {
  std::string text = fmt::format("{:<21}", "coefficient");
  if (comparisons == 1) return text + fmt::format(" {:>12} {:>10} {:<15} {:>8}{}\n", "B - A", "u", "unit", "sigmas", yearly ? "  per year" : "");
  if (comparisons > most_pairs_beside) return text + "    largest  in        pairs that differ\n";
  for (std::size_t k = 1; k <= comparisons; ++k) text += fmt::format(" {:>7}", letter_of(k) + " - A");
  return text + "  sigmas\n";
}

std::string coefficient_row(const std::vector<Comparison>& comparisons, std::size_t row, double mark_from, const std::optional<double>& years) {
  const CoefficientDifference& first = comparisons[0].coefficients[row];
  const auto sigmas = [&](const CoefficientDifference& d) { return or_dash(d.user_sigmas(), "{:+.1f}") + (significant(d, mark_from) ? "*" : " "); };
  const std::string_view name = coefficient(first.index).name;
  std::string text;
  if (comparisons.size() == 1) {
    const double sigma = first.user_uncertainty.value_or(0);
    text += fmt::format("{} {:>10} {:<15} {:>9}", text::two_ends(name, text::to_digits_of(sigma, first.user_difference), 34),
                        sigma > 0 ? text::two_digits(sigma) : "-", first.user_unit, sigmas(first));
    if (years) text += fmt::format(" {:>8}", text::to_digits_of(sigma / std::abs(*years), first.user_difference / *years));
  } else if (comparisons.size() <= most_pairs_beside) {
    text = text::two_ends(name, sigmas(first), 29);
    for (std::size_t k = 1; k < comparisons.size(); ++k) text += fmt::format(" {:>7}", sigmas(comparisons[k].coefficients[row]));
  } else {
    const auto size = [&](const Comparison& c) { return std::abs(c.coefficients[row].user_sigmas().value_or(-1)); };
    const auto largest = std::ranges::max_element(comparisons, {}, size);
    const auto differing = std::ranges::count_if(comparisons, [&](const Comparison& c) { return significant(c.coefficients[row], mark_from); });
    text += fmt::format("{}  {:<8} {:>3} of {}", text::two_ends(name, sigmas(largest->coefficients[row]), 32),
                        letter_of(static_cast<std::size_t>(largest - comparisons.begin()) + 1) + " - A", differing, comparisons.size());
  }
  return text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
}

std::string tolerance_text(const RequirementResult& r) {
  const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
  const std::string reached = std::isfinite(r.reached) ? fmt::format("{} {}", text::number(r.reached / unit.size), unit.name) : "not determined";
  return text::wrapped("  tolerance  ", fmt::format("{}: {} ({}: {})", r.text, r.met ? "met" : "not met", r.coefficient, reached));
}

/// The values themselves, in SI, three calibrations beside each other.
std::string value_rows(const std::vector<Comparison>& comparisons) {
  constexpr std::size_t beside = 3;  // in the width of a terminal
  std::string text;
  for (std::size_t from = 0; from <= comparisons.size(); from += beside) {
    const std::size_t to = std::min(from + beside, comparisons.size() + 1);
    text += fmt::format("\n{:<21}", "coefficient, SI");
    for (std::size_t k = from; k < to; ++k) text += fmt::format(" {:>16}", letter_of(k));
    text += "\n";
    for (std::size_t row = 0; row < comparisons[0].coefficients.size(); ++row) {
      const CoefficientDifference& first = comparisons[0].coefficients[row];
      const auto value = [&](std::size_t k) { return fmt::format("{:.9g}", k == 0 ? first.a : comparisons[k - 1].coefficients[row].b); };
      text += text::two_ends(coefficient(first.index).name, value(from), 38);
      for (std::size_t k = from + 1; k < to; ++k) text += fmt::format(" {:>16}", value(k));
      text += "\n";
    }
  }
  return text;
}

std::string count_text(std::size_t marked, std::size_t tested, double mark_from) {
  if (tested == 0) return "nothing to test: no coefficient has an uncertainty on one side and a value to compare it with on the other\n";
  return text::wrapped(
      "", fmt::format("{} of {} coefficients differ significantly (* beyond {:.1f} sigma: 1 % for all together)", marked, tested, mark_from));
}

/// A row a pair, the least probable first.
std::string pair_rows(const ComparisonSummary& summary) {
  std::string out =
      fmt::format("\n{:<8} {:>6} {:>6} {:>10} {:>7} {:>11}  {}\n", "pair", "differ", "tested", "chi2", "freedom", "probability", "differences");
  for (const PairTest& pair : ranked_pairs(summary)) {
    out += fmt::format("{:<8} ", letter_of(pair.k + 1) + " - A");
    if (pair.differences.empty())
      out += "nothing to test\n";
    else
      out += fmt::format("{:>6} {:>6} {:>10} {:>7} {:>11}  {}{}\n", pair.differing, pair.tested, text::number(pair.together.chi2, 4),
                         pair.together.degrees_of_freedom, probability_text(pair.together.p_value), pair.differences,
                         pair.together.differing.empty() ? "" : fmt::format(": {}", coefficient(pair.together.differing.front().index).name));
  }
  return out + text::wrapped("", "Probability: of differences that are larger together, if the stated uncertainties are right.");
}

/// One pair in words, several as rows.
std::string tests_text(const ComparisonSummary& summary, const RankedRows& ranked, double mark_from) {
  const std::string count = count_text(ranked.significant, ranked.tested, mark_from);
  if (summary.comparisons.size() > 1) return count + pair_rows(summary);
  const Consistency& c = summary.comparisons.front().consistency;
  if (c.degrees_of_freedom == 0) return count;
  return count + text::wrapped("", fmt::format("{} coefficients together: {}", c.degrees_of_freedom, judged_text(c)));
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
  constexpr std::size_t named = 6;  // the rows below have all that differ from the first
  std::string differing;
  std::size_t count = 0;
  for (const auto& c : agreement.coefficients)
    if (c.differs && ++count <= named) differing += fmt::format("{}{}", differing.empty() ? "" : ", ", coefficient(c.index).name);
  if (count > named) differing += fmt::format(" and {} more", count - named);
  return text::wrapped("", fmt::format("All {} calibrations about their weighted mean, {} degrees of freedom: {}", agreement.calibrations,
                                       agreement.consistency.degrees_of_freedom, judged_text(agreement.consistency))) +
         text::wrapped("", "Coefficients that differ among them: " + (differing.empty() ? "none" : differing));
}

}  // namespace

std::string comparison_table(const ComparisonSummary& summary, bool details) {
  const std::vector<Comparison>& comparisons = summary.comparisons;
  const double mark_from = significant_from(summary);
  const bool pair = comparisons.size() == 1;
  const std::optional<double> years = pair ? years_between(summary, 0) : std::nullopt;
  std::string out;
  if (const Conclusion about = conclusion_about(summary); about.verdict != Verdict::none) out += text::wrapped("", conclusion_text(about));
  for (const RequirementResult& r : summary.requirements) out += tolerance_text(r);
  const RankedRows ranked = ranked_rows(comparisons, mark_from);
  out += tests_text(summary, ranked, mark_from);
  if (summary.agreement) out += "\n" + agreement_text(*summary.agreement);
  out += "\n";
  for (std::size_t k = 0; k < summary.calibrations.size(); ++k) out += text::wrapped(letter_of(k) + "  ", origin(summary.calibrations[k]));
  if (years) out += text::wrapped("", fmt::format("{:.2f} years from A to B.", *years));
  out += text::wrapped("", fmt::format("{} in the accelerometers' frame; quadratic and cubic terms are compared unrotated.", pair ? "Both" : "All"));
  if (std::ranges::any_of(summary.calibrations, &ComparedCalibration::with_turn_on))
    out += text::wrapped("", "Offsets are compared with their declared repeatability from turn-on to turn-on.");
  for (const auto& c : comparisons) out += translation_text(c.translation);
  const std::size_t shown = details || ranked.tested == 0 ? ranked.rows.size() : ranked.significant;
  if (shown > 0) out += "\n" + heading(comparisons.size(), years.has_value());
  for (std::size_t k = 0; k < shown; ++k) out += coefficient_row(comparisons, ranked.rows[k], mark_from, years);
  if (shown < ranked.rows.size()) out += text::wrapped(shown > 0 ? "" : "\n", rest_text(comparisons, ranked, shown) + "; --verbose lists them");
  return details ? out + value_rows(comparisons) : out;
}

}  // namespace imulab
