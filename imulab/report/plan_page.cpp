#include "imulab/report/plan_page.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/prediction_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace report {
namespace {

std::string duration_text(double seconds) {
  return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60)));
}

std::string turns_section(const hybrid::Path& path) {
  Table t{.head = {"step", "turn about", "by [deg]", "then rest [s]"}, .rows = {{"1", "", "", number_text(path.first_rest, 5)}}, .left = {1}};
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    t.rows.push_back({fmt::format("{}", k + 2), std::string(to_string(path.turns[k].axis)) + " axis", number_text(path.turns[k].angle_deg, 5),
                      number_text(path.turns[k].rest, 5)});
  return section("turns", "The procedure", "Begin at zero angles; turn and rest in this order.", table(t));
}

/// What is reached of each requirement by its coefficients, relative to the limit.
std::string requirements_figure(const PlanSummary& plan) {
  std::vector<Interval> rows;
  const PredictionSummary& s = plan.prediction;
  for (const Requirement& r : plan.requirements)
    for (const CoefficientIndex index : r.coefficients) {
      const auto at = std::find(s.coefficients.begin(), s.coefficients.end(), index) - s.coefficients.begin();
      if (at == static_cast<std::ptrdiff_t>(s.coefficients.size())) continue;
      const double ratio = s.sigma[at] / r.limit;
      rows.push_back({std::string(coefficient(index).name), ratio, 0,
                      fmt::format("{} {}", uncertainty_text(s.sigma[at] / r.unit.size), readable_unit(r.unit.name)), ratio > 1});
    }
  if (rows.empty()) return {};
  return section("required", "Against the requirements", "",
                 figure(interval_rows(rows, "standard uncertainty over requirement", "requirements", 1), "At most 1 is required."));
}

Verdict plan_verdict(const PlanSummary& plan) {
  const bool met = plan.prediction.missed.empty();
  Verdict v{.tone = met ? Tone::good : Tone::doubtful,
            .word = met ? "requirements met" : "requirements not met",
            .meaning = fmt::format("{} turns in {}.", plan.path.turns.size(), duration_text(plan.path.duration)),
            .because = {},
            .actions = {}};
  for (const Shortfall& s : plan.prediction.missed) v.because.push_back(shortfall_line(s));
  v.actions.emplace_back(met ? "Save the procedure with imulab plan -o, perform it, and calibrate with --method hybrid."
                             : "Allow more time or more axes, or require less.");
  return v;
}

}  // namespace
}  // namespace report

std::string plan_page(const PlanSummary& r) {
  using namespace report;
  Page page;
  page.kind = "Plan";
  std::string required;
  for (const Requirement& requirement : r.requirements) required += (required.empty() ? "" : ", ") + to_string(requirement);
  page.title = "Procedure for " + readable_unit(required);
  page.subtitle = r.prior ? "Hybrid method, " + prior_text(*r.prior) : "Hybrid method";
  page.verdict = plan_verdict(r);
  page.body = turns_section(r.path) + requirements_figure(r) + prediction_sections(r.prediction);
  return page_text(page);
}

}  // namespace imulab
