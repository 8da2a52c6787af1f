#include "imulab/report/comparison_page.hpp"

#include "imulab/model/coefficient.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace report {
namespace {

/// Coefficients that both determined, and those of them that differ significantly.
struct Tested {
  std::size_t compared = 0;
  double limit = 0;  ///< sigmas
  std::vector<std::string> different;
};

Tested tested(const Comparison& comparison) {
  Tested t;
  for (const CoefficientDifference& d : comparison.coefficients) t.compared += d.user_sigmas().has_value();
  t.limit = significant_sigmas(std::max<std::size_t>(1, t.compared));
  for (const CoefficientDifference& d : comparison.coefficients)
    if (const auto sigmas = d.user_sigmas(); sigmas && std::abs(*sigmas) > t.limit) t.different.emplace_back(coefficient(d.index).name);
  return t;
}

constexpr double improbable = 1e-3;

std::string consistency_text(const Consistency& c) {
  if (c.degrees_of_freedom == 0) return "no coefficient has an uncertainty in both: nothing is tested";
  return fmt::format("all together: chi-square {} with {} degrees of freedom, probability of more {}", number_text(c.chi2), c.degrees_of_freedom,
                     number_text(c.p_value, 2));
}

Verdict comparison_verdict(const ComparisonSummary& summary) {
  Verdict v{.tone = Tone::good,
            .word = "consistent",
            .meaning = "The differences are as large as the stated uncertainties say.",
            .because = {},
            .actions = {}};
  bool any = false;
  for (std::size_t k = 0; k < summary.comparisons.size(); ++k) {
    const Comparison& c = summary.comparisons[k];
    const Tested t = tested(c);
    any = any || c.consistency.degrees_of_freedom > 0;
    const std::string who = summary.comparisons.size() > 1 ? summary.names[k + 1] + ": " : "";
    v.because.push_back(fmt::format("{}{} of {} coefficients differ significantly (beyond {} sigma: 1 % for all together)", who, t.different.size(),
                                    t.compared, number_text(t.limit, 2)));
    v.because.push_back(who + consistency_text(c.consistency));
    if (!t.different.empty() || (c.consistency.degrees_of_freedom > 0 && c.consistency.p_value < improbable)) v.tone = Tone::doubtful;
  }
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

std::string sigmas_figure(const Comparison& comparison, double limit, Triad triad) {
  std::vector<Interval> rows;
  for (const CoefficientDifference& d : comparison.coefficients) {
    const auto sigmas = d.user_sigmas();
    if (coefficient(d.index).triad != triad || !sigmas) continue;
    const std::string_view name = coefficient(d.index).name;
    rows.push_back({std::string(name.substr(name.find('.') + 1)), *sigmas, 1,
                    d.user_unit == coefficient(d.index).unit ? "" : fmt::format("{} {}", number_text(d.user_difference), readable_unit(d.user_unit)),
                    std::abs(*sigmas) > limit});
  }
  return rows.empty() ? ""
                      : figure(interval_rows(rows, "difference in its standard uncertainties", "differences"),
                               triad == Triad::accel ? "Accelerometers" : "Gyros");
}

std::string comparison_section(const std::string& a, const std::string& b, const Comparison& comparison) {
  Table t{.head = {"coefficient", "first", "second", "difference", "u", "", "sigmas"}, .rows = {}, .left = {5}};
  const Tested judged = tested(comparison);
  for (const CoefficientDifference& d : comparison.coefficients) {
    const auto sigmas = d.user_sigmas();
    const bool marked = sigmas && std::abs(*sigmas) > judged.limit;
    t.rows.push_back({"<code>" + escaped(coefficient(d.index).name) + "</code>", number_text(d.a, 7), number_text(d.b, 7),
                      d.user_uncertainty ? rounded_to(d.user_difference, *d.user_uncertainty) : number_text(d.user_difference, 4),
                      d.user_uncertainty ? uncertainty_text(*d.user_uncertainty) : "", escaped(readable_unit(d.user_unit)),
                      sigmas ? fmt::format("{0}{1}{2}", marked ? "<strong>" : "", fmt::format("{:+.1f}", *sigmas), marked ? "</strong>" : "") : ""});
  }
  return section("comparison", shortened(a, 60) + " and " + shortened(b, 60),
                 "Second less first, in the accelerometers' frame. A bar is one standard uncertainty to each side; red: significant among all.",
                 beside({sigmas_figure(comparison, judged.limit, Triad::accel), sigmas_figure(comparison, judged.limit, Triad::gyro)}) + table(t));
}

std::string agreement_section(const Agreement& agreement) {
  std::vector<std::string> differing;
  for (const Agreement::Coefficient& c : agreement.coefficients)
    if (c.differs) differing.emplace_back(coefficient(c.index).name);
  return section("agreement", "All calibrations together",
                 fmt::format("{} calibrations against one truth: {}. {}", agreement.calibrations, consistency_text(agreement.consistency),
                             differing.empty() ? "No coefficient differs significantly." : "These differ significantly:"),
                 list(differing));
}

}  // namespace
}  // namespace report

std::string comparison_page(const ComparisonSummary& summary) {
  using namespace report;
  Page page;
  page.kind = "Comparison of calibrations";
  page.title = summary.names.size() == 2 ? shortened(summary.names[0], 50) + " and " + shortened(summary.names[1], 50)
                                         : fmt::format("{} calibrations", summary.names.size());
  page.subtitle = "Errors of different calibrations are taken as independent.";
  page.verdict = comparison_verdict(summary);
  for (std::size_t k = 0; k < summary.comparisons.size(); ++k)
    page.body += comparison_section(summary.names[0], summary.names[k + 1], summary.comparisons[k]);
  if (summary.agreement) page.body += agreement_section(*summary.agreement);
  return page_text(page);
}

}  // namespace imulab
