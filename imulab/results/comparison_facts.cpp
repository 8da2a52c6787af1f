// What a comparison of calibrations concludes: dates, tolerances, the order of its rows.
#include "imulab/coefficient.hpp"
#include "imulab/core/stamp_text.hpp"
#include "imulab/core/text.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/results/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace imulab {
namespace {

/// The difference as its tolerance counts it, SI.
double size_of_difference(const CoefficientDifference& d) {
  for (const UserUnit& unit : user_units(coefficient(d.index)))
    if (unit.name == d.user_unit) return std::abs(d.user_difference) * unit.size;
  return std::abs(d.difference);
}

double largest_sigmas(const std::vector<Comparison>& comparisons, std::size_t row) {
  double most = -1;
  for (const Comparison& c : comparisons)
    if (const auto sigmas = c.coefficients[row].user_sigmas()) most = std::max(most, std::abs(*sigmas));
  return most;
}

std::string limit_and_reached(const RequirementResult& r) {
  const std::string unit = r.text.substr(std::min(r.text.size(), r.text.find_last_of(' ') + 1));
  for (const UserUnit& each : user_units(coefficient(coefficient_index(r.coefficient))))
    if (each.name == unit)
      return (std::isfinite(r.reached) ? fmt::format("{} differs by {} {}", r.coefficient, text::number(r.reached / each.size), unit)
                                       : r.coefficient + " is not determined in both") +
             (r.note.empty() ? "" : " (" + r.note + ")");
  return std::string(r.coefficient);
}

}  // namespace

ComparedCalibration compared_calibration(const NamedCalibration& named) {
  const Calibration& c = named.calibration;
  ComparedCalibration out{.name = named.name, .imu = c.imu, .serial = c.serial, .method = c.method, .frame = c.frame, .date = {}, .dated = {}};
  out.bare = c.estimated.empty(), out.doubtful = c.quality.verdict == Verdict::doubtful, out.with_turn_on = c.turn_on.has_value();
  const std::string recorded = c.sources.empty() ? "" : date_text(c.sources.front().first_s);
  for (const auto& [text, what] : {std::pair{c.measured, "measured"}, {recorded, "recorded"}, {c.created, "calibrated"}})
    if (out.date.empty() && time_of(text)) out.date = text.substr(0, 10), out.dated = what;
  return out;
}

std::optional<double> years_between(const ComparisonSummary& summary, std::size_t k) {
  if (summary.calibrations.size() <= k + 1) return {};
  const auto is_of_the_data = [&](std::size_t i) { return summary.calibrations[i].dated != "calibrated"; };
  if (is_of_the_data(0) != is_of_the_data(k + 1)) return {};  // a day of measurement and a day of computation
  constexpr double day = 86400, year = 365.2425 * day, shortest = 30 * day;
  const auto from = time_of(summary.calibrations[0].date), to = time_of(summary.calibrations[k + 1].date);
  if (!from || !to || std::abs(*to - *from) < shortest) return {};
  return (*to - *from) / year;
}

RequirementResult assess(const ComparisonSummary& summary, const Requirement& tolerance) {
  RequirementResult out{to_string(tolerance), std::string(coefficient(tolerance.coefficients.front()).name), tolerance.limit, 0, false};
  const bool all_bare = std::ranges::all_of(summary.calibrations, &ComparedCalibration::bare);
  bool doubtful = false;
  for (const ComparedCalibration& c : summary.calibrations) doubtful = doubtful || c.doubtful;
  for (const Comparison& comparison : summary.comparisons)
    for (const CoefficientIndex index : tolerance.coefficients) {
      if (zero_by_frame(index)) continue;
      const auto d = std::ranges::find_if(comparison.coefficients, [&](const CoefficientDifference& of) { return of.index == index; });
      const bool listed = d != comparison.coefficients.end();
      const bool known = all_bare || (listed && d->user_uncertainty);
      const double size = !known ? std::numeric_limits<double>::infinity() : listed ? size_of_difference(*d) : 0;
      if (!(size > out.reached)) continue;
      out.reached = size, out.coefficient = coefficient(index).name;
    }
  if (std::ranges::all_of(tolerance.coefficients, zero_by_frame)) out.note = "zero by the definition of the axes";
  out.met = out.reached <= out.limit && !doubtful;
  return out;
}

Conclusion conclusion_about(const ComparisonSummary& summary) {
  Conclusion out;
  if (summary.requirements.empty()) {
    const RankedRows rows = ranked_rows(summary.comparisons, significant_from(summary));
    const PairTest first = ranked_pairs(summary).front();
    if (rows.significant == 0 && first.differences == "larger") {
      out.headline = "no coefficient differs significantly by itself, but all together do, most in " + differing_text(first.together);
      return out;
    }
    out.headline = rows.tested == 0 ? "nothing is tested: no coefficient has an uncertainty on one side and a value to compare it with on the other"
                                    : fmt::format("{} of {} coefficients differ significantly", rows.significant, rows.tested);
    return out;
  }
  std::string doubtful;
  for (const ComparedCalibration& c : summary.calibrations)
    if (c.doubtful) doubtful += fmt::format("{}{}", doubtful.empty() ? "" : ", ", excerpt(c.name));
  out.verdict = verdict_about(doubtful.empty() ? Verdict::none : Verdict::doubtful, summary.requirements);
  if (!doubtful.empty()) {
    out.headline = "a doubtful calibration meets no tolerance: " + doubtful;
    return out;
  }
  for (const RequirementResult& r : summary.requirements)
    if (r.met == (out.verdict == Verdict::met))
      out.headline += fmt::format("{}{}; tolerance: {}", out.headline.empty() ? "" : "; ", limit_and_reached(r), r.text);
  return out;
}

double significant_from(const ComparisonSummary& summary) {
  std::size_t tests = 0;
  for (const Comparison& c : summary.comparisons)
    for (const CoefficientDifference& d : c.coefficients) tests += d.user_sigmas().has_value();
  return significant_sigmas(std::max<std::size_t>(1, tests));
}

std::string differing_text(const Consistency& c) {
  constexpr std::size_t named = 3;
  std::string out;
  for (std::size_t k = 0; k < std::min(named, c.differing.size()); ++k)
    out += fmt::format("{}{} ({:+.1f} sigmas)", k == 0 ? "" : ", ", coefficient(c.differing[k].index).name, c.differing[k].sigmas);
  return c.differing.size() > named ? out + fmt::format(" and {} more", c.differing.size() - named) : out;
}

std::string probability_text(double p) { return p < 1e-99 ? "< 1e-99" : fmt::format("{:.2g}", p); }

namespace {

/// Against the stated uncertainties.
enum class SizeOfDifferences { larger, as_stated, smaller };
SizeOfDifferences differences_of(const Consistency& c) {
  return c.p_value < improbable_differences       ? SizeOfDifferences::larger
         : c.p_value > 1 - improbable_differences ? SizeOfDifferences::smaller
                                                  : SizeOfDifferences::as_stated;
}

}  // namespace

std::string size_text(const Consistency& c) {
  constexpr std::array words{"larger than", "as large as", "smaller than"};
  return fmt::format("the differences are {} the stated uncertainties say", words[static_cast<std::size_t>(differences_of(c))]);
}

std::string judged_text(const Consistency& c) {
  return fmt::format("chi2 = {}, probability of more {}: {}{}", c.chi2 < 1e4 ? fmt::format("{:.1f}", c.chi2) : text::number(c.chi2, 4),
                     probability_text(c.p_value), size_text(c), c.differing.empty() ? "" : "; given the others, most in " + differing_text(c));
}

std::string rest_text(const std::vector<Comparison>& comparisons, const RankedRows& ranked, std::size_t shown) {
  if (shown >= ranked.rows.size()) return "";
  const bool together = shown == 0 && std::ranges::any_of(comparisons, [](const Comparison& c) { return !c.consistency.differing.empty(); });
  const std::size_t untested = ranked.rows.size() - std::max(shown, ranked.tested);
  return fmt::format("{} coefficients do not differ significantly{}{}", ranked.tested - std::min(shown, ranked.tested),
                     together ? " by themselves" : "", untested > 0 ? fmt::format(", {} are not tested", untested) : "");
}

std::vector<PairTest> ranked_pairs(const ComparisonSummary& summary) {
  const double from = significant_from(summary);
  std::vector<PairTest> out;
  for (const Comparison& c : summary.comparisons) {
    PairTest& pair = out.emplace_back(PairTest{.k = out.size(), .together = c.consistency, .differences = {}});
    for (const CoefficientDifference& d : c.coefficients)
      if (const auto sigmas = d.user_sigmas()) ++pair.tested, pair.differing += std::abs(*sigmas) > from;
    if (c.consistency.degrees_of_freedom == 0) continue;
    pair.differences = std::array{"larger", "as stated", "smaller"}[static_cast<std::size_t>(differences_of(c.consistency))];
  }
  std::ranges::stable_sort(out, [](const PairTest& a, const PairTest& b) {
    return a.together.p_value != b.together.p_value ? a.together.p_value < b.together.p_value : a.together.chi2 > b.together.chi2;
  });
  return out;
}

RankedRows ranked_rows(const std::vector<Comparison>& comparisons, double from) {
  RankedRows out;
  if (comparisons.empty()) return out;
  out.rows.resize(comparisons.front().coefficients.size());
  std::iota(out.rows.begin(), out.rows.end(), std::size_t{0});
  std::ranges::stable_sort(out.rows, [&](std::size_t i, std::size_t j) { return largest_sigmas(comparisons, i) > largest_sigmas(comparisons, j); });
  for (const std::size_t row : out.rows) {
    const double sigmas = largest_sigmas(comparisons, row);
    out.tested += sigmas >= 0, out.significant += sigmas > from;
  }
  return out;
}

}  // namespace imulab
