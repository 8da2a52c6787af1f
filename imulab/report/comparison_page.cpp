#include "imulab/report/comparison_page.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace report {
namespace {

std::string consistency_text(const Consistency& c) {
  if (c.degrees_of_freedom == 0) return "no coefficient has an uncertainty in both: nothing is tested";
  return fmt::format("all together, {} degrees of freedom: {}", c.degrees_of_freedom, judged_text(c));
}

PageVerdict comparison_verdict(const ComparisonSummary& summary) {
  PageVerdict v{.tone = Tone::good, .word = "consistent", .meaning = {}, .because = {}, .actions = {}};
  const std::vector<PairTest> pairs = ranked_pairs(summary);
  v.meaning = size_text(pairs.front().together) + (pairs.size() > 1 ? " even in the least probable pair." : ".");
  v.meaning[0] = 'T';
  const double limit = significant_from(summary);
  const RankedRows ranked = ranked_rows(summary.comparisons, limit);
  const bool any = ranked.tested > 0;
  v.because.push_back(fmt::format("{} of {} coefficients differ significantly{} (beyond {:.1f} sigma: 1 % for all together)", ranked.significant,
                                  ranked.tested, pairs.size() > 1 ? " in one pair at least" : "", limit));
  if (pairs.size() == 1) v.because.push_back(consistency_text(pairs.front().together));
  if (ranked.significant > 0 || std::ranges::any_of(pairs, [](const PairTest& p) { return p.differences == "larger"; })) v.tone = Tone::doubtful;
  if (v.tone == Tone::doubtful) {
    v.word = "different";
    v.meaning = "The calibrations differ by more than their stated uncertainties explain.";
    v.actions = {
        "The IMU changed between them (temperature, power cycle, age), or one of the uncertainties is too small: calibrate once more, and see which "
        "one agrees."};
  } else if (!any) {
    v = {.tone = Tone::neutral,
         .word = "not tested",
         .meaning = "Uncertainties are missing, so differences cannot be judged.",
         .because = v.because,
         .actions = {}};
  }
  return v;
}

constexpr std::size_t most_drawn = 9;  // besides what is significant

/// Differences of a triad in sigmas, in the order of the table.
std::string sigmas_figure(const Comparison& comparison, const RankedRows& ranked, double limit, Triad triad) {
  std::vector<Interval> rows;
  for (const std::size_t row : ranked.rows) {
    const CoefficientDifference& d = comparison.coefficients[row];
    const auto sigmas = d.user_sigmas();
    if (coefficient(d.index).triad != triad || !sigmas) continue;
    if (rows.size() >= most_drawn && std::abs(*sigmas) <= limit) break;
    const std::string_view name = coefficient(d.index).name;
    rows.push_back({std::string(name.substr(name.find('.') + 1)), *sigmas, 1,
                    d.user_unit == coefficient(d.index).unit ? "" : fmt::format("{} {}", number_text(d.user_difference), readable_unit(d.user_unit)),
                    std::abs(*sigmas) > limit});
  }
  return rows.empty() ? ""
                      : figure(interval_rows(rows, "difference in its standard uncertainties", "differences"),
                               triad == Triad::accel ? "Accelerometers" : "Gyros");
}

/// Differences in user units, of these rows.
std::string difference_table(const Comparison& comparison, const std::vector<std::size_t>& rows, double limit, const std::optional<double>& years) {
  Table t{.head = {"coefficient", "difference", "u", "", "sigmas"}, .rows = {}, .left = {3}};
  if (years) t.head.insert(t.head.end(), {"per year", "u"});
  for (const std::size_t row : rows) {
    const CoefficientDifference& d = comparison.coefficients[row];
    const auto sigmas = d.user_sigmas();
    const bool marked = sigmas && std::abs(*sigmas) > limit;
    const double u = d.user_uncertainty.value_or(NAN);
    const auto stated = [&](double size) {
      return d.user_uncertainty ? rounded_to(d.user_difference / size, u / std::abs(size)) : number_text(d.user_difference / size, 4);
    };
    const auto uncertain = [&](double size) { return d.user_uncertainty ? uncertainty_text(u / std::abs(size)) : ""; };
    t.rows.push_back({"<code>" + escaped(coefficient(d.index).name) + "</code>", stated(1), uncertain(1), escaped(readable_unit(d.user_unit)),
                      sigmas ? fmt::format("{0}{1:+.1f}{2}", marked ? "<strong>" : "", *sigmas, marked ? "</strong>" : "") : ""});
    if (years) t.rows.back().insert(t.rows.back().end(), {stated(*years), uncertain(*years)});
  }
  return t.rows.empty() ? "" : table(t);
}

std::string si_table(const Comparison& comparison) {
  Table t{.head = {"coefficient", "first", "second", "difference", "u", ""}, .rows = {}, .left = {5}};
  for (const CoefficientDifference& d : comparison.coefficients)
    t.rows.push_back({"<code>" + escaped(coefficient(d.index).name) + "</code>", number_text(d.a, 8), number_text(d.b, 8),
                      d.uncertainty ? rounded_to(d.difference, *d.uncertainty) : number_text(d.difference, 4),
                      d.uncertainty ? uncertainty_text(*d.uncertainty) : "", escaped(readable_unit(coefficient(d.index).unit))});
  return table(t);
}

std::string comparison_section(const ComparisonSummary& summary, std::size_t k) {
  const Comparison& comparison = summary.comparisons[k];
  const double limit = significant_from(summary);
  const RankedRows ranked = ranked_rows({comparison}, limit);
  const std::optional<double> years = years_between(summary, k);
  const std::size_t open = ranked.tested == 0 ? ranked.rows.size() : ranked.significant;
  const auto middle = ranked.rows.begin() + static_cast<std::ptrdiff_t>(open);
  const std::string rest = difference_table(comparison, {middle, ranked.rows.end()}, limit, years);
  std::string lead =
      "Second less first, in the accelerometers' frame, the most significant first; the pictures have the first of each triad. A bar is one standard "
      "uncertainty to each side; red: "
      "significant among all.";
  if (years) lead += fmt::format(" Time between them: {} years.", number_text(*years, 2));
  return section("comparison", shortened(summary.names[0], 60) + " and " + shortened(summary.names[k + 1], 60), lead,
                 beside({sigmas_figure(comparison, ranked, limit, Triad::accel), sigmas_figure(comparison, ranked, limit, Triad::gyro)}) +
                     difference_table(comparison, {ranked.rows.begin(), middle}, limit, years) +
                     (rest.empty() ? "" : folded(rest_text({comparison}, ranked, open), rest)) + folded("All values in SI", si_table(comparison)));
}

std::string calibrations_section(const std::vector<ComparedCalibration>& calibrations) {
  Table t{.head = {"file", "IMU", "serial number", "method", "date"}, .rows = {}, .text_columns = true};
  for (const ComparedCalibration& c : calibrations) {
    const std::string method = c.bare ? "no uncertainties: taken as the truth" : c.method + (c.doubtful ? ", doubtful" : "");
    t.rows.push_back({escaped(shortened(c.name, 60)), escaped(shortened(c.imu, 60)), escaped(shortened(c.serial, 60)), escaped(shortened(method, 60)),
                      escaped(c.date.empty() ? "not known" : c.dated + " " + c.date)});
  }
  return t.rows.empty() ? "" : section("calibrations", "Calibrations", "", table(t));
}

/// A row a pair, where there are several.
std::string pairs_section(const ComparisonSummary& summary) {
  if (summary.comparisons.size() < 2) return "";
  Table t{.head = {"with the first", "differences", "differ", "tested", "chi-square", "degrees of freedom", "probability"}, .rows = {}, .left = {1}};
  for (const PairTest& pair : ranked_pairs(summary)) {
    const bool none = pair.differences.empty();
    t.rows.push_back({escaped(shortened(summary.names[pair.k + 1], 40)), none ? "nothing to test" : pair.differences, std::to_string(pair.differing),
                      std::to_string(pair.tested), none ? "" : number_text(pair.together.chi2, 4),
                      none ? "" : std::to_string(pair.together.degrees_of_freedom), none ? "" : escaped(probability_text(pair.together.p_value))});
  }
  return section("pairs", "Each with the first",
                 "How many coefficients differ significantly, and all of a pair together against the stated uncertainties: the probability of "
                 "differences that are larger, if these are right; the least probable first.",
                 table(t));
}

std::string tolerance_section(const std::vector<RequirementResult>& requirements) {
  Table t{.head = {"tolerance", "largest difference, of", "reached", ""}, .rows = {}, .text_columns = true};
  for (const RequirementResult& r : requirements) {
    const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
    t.rows.push_back(
        {escaped(readable_unit(r.text)), "<code>" + escaped(r.coefficient) + "</code>",
         escaped(std::isfinite(r.reached) ? number_text(r.reached / unit.size) + " " + readable_unit(unit.name) : "not determined in both"),
         r.met ? "met" : "<strong>not met</strong>"});
  }
  return t.rows.empty() ? ""
                        : section("tolerances", "Tolerances",
                                  "The size of each difference against the limit (simple acceptance: its uncertainty is not taken off), of matrices "
                                  "relative to the row's scale.",
                                  table(t));
}

std::string agreement_section(const Agreement& agreement) {
  std::vector<std::string> differing;
  for (const Agreement::Coefficient& c : agreement.coefficients)
    if (c.differs) differing.emplace_back(coefficient(c.index).name);
  return section("agreement", "All calibrations together",
                 fmt::format("{} calibrations against one truth: {}. {}", agreement.calibrations, consistency_text(agreement.consistency),
                             differing.empty() ? "No coefficient differs significantly." : "These differ significantly:"),
                 differing.size() > most_drawn ? folded(fmt::format("{} coefficients", differing.size()), list(differing)) : list(differing));
}

}  // namespace
}  // namespace report

std::string comparison_page(const ComparisonSummary& summary, const std::vector<std::string>& warnings) {
  using namespace report;
  Page page;
  page.kind = "Comparison of calibrations";
  page.title = summary.names.size() == 2 ? shortened(summary.names[0], 50) + " and " + shortened(summary.names[1], 50)
                                         : fmt::format("{} calibrations", summary.names.size());
  page.subtitle = "Errors of different calibrations are taken as independent.";
  page.verdict = comparison_verdict(summary);
  take_conclusion(page.verdict, conclusion_about(summary));
  page.body = (warnings.empty() ? "" : section("warnings", "Warnings", "", list(warnings))) + calibrations_section(summary.calibrations) +
              tolerance_section(summary.requirements) + pairs_section(summary);
  if (summary.agreement) page.body += agreement_section(*summary.agreement);
  for (std::size_t k = 0; k < summary.comparisons.size(); ++k) page.body += comparison_section(summary, k);
  return page_text(page);
}

}  // namespace imulab
