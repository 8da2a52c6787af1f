#include "imulab/report/prediction_page.hpp"

#include "imulab/estimate/method.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/model/user_value.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/results/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace imulab {

namespace report {
namespace {

UserUnit unit_in(const PredictionSummary& s, const PredictedCoefficient& c) { return unit_of(c.index, s.indices(), s.sigma()); }

std::string in_unit(double sigma, const UserUnit& unit) { return uncertainty_text(sigma / unit.size) + " " + readable_unit(unit.name); }

std::string shares_section(const PredictionSummary& s) {
  if (s.coefficients.front().budget.empty()) return {};
  std::vector<std::string> sources;
  const auto column_of = [&](const std::string& source) {  // the effects of the table are one: a bar of all of them has no colours that differ
    const std::string name = find_effect(source) ? "effects" : source;
    const auto found = std::find(sources.begin(), sources.end(), name);
    return found == sources.end() ? (sources.push_back(name), sources.size() - 1) : static_cast<std::size_t>(found - sources.begin());
  };
  for (const auto& [source, sigma] : s.coefficients.front().budget) column_of(source);
  std::vector<ShareRow> rows;
  for (const PredictedCoefficient& c : s.coefficients) {
    double all = 0;
    for (const auto& [source, sigma] : c.budget) all += sigma * sigma;
    ShareRow r{std::string(coefficient(c.index).name), in_unit(c.sigma, unit_in(s, c)), std::vector<double>(sources.size())};
    for (const auto& [source, sigma] : c.budget) r.parts[column_of(source)] += all > 0 ? sigma * sigma / all : 0;
    rows.push_back(std::move(r));
  }
  return section("shares", "What limits each coefficient", "The share of each source in the variance (to first order), and the standard uncertainty.",
                 figure(share_bars(sources, rows, "shares of the sources"),
                        "Improve the source with the longest bar first: the others hardly count beside it.", true));
}

std::string uncertainties_section(const PredictionSummary& s) {
  Table t{.head = {"coefficient", "u", ""}, .rows = {}, .left = {2}};
  const auto has = [&](auto number) { return std::any_of(s.coefficients.begin(), s.coefficients.end(), number); };
  const bool bound = has([](const auto& c) { return std::isfinite(c.cramer_rao); });
  const bool sampled = !s.coefficients.empty() && !has([](const auto& c) { return !c.monte_carlo || !std::isfinite(*c.monte_carlo); });
  if (sampled) t.head.emplace_back("Monte Carlo");
  if (bound) t.head.emplace_back("Cramér-Rao bound");
  for (const PredictedCoefficient& c : s.coefficients) {
    const UserUnit unit = unit_in(s, c);
    std::vector<std::string> cells{"<code>" + escaped(coefficient(c.index).name) + "</code>", number_text(c.sigma / unit.size),
                                   escaped(readable_unit(unit.name))};
    if (sampled) cells.push_back(number_text(*c.monte_carlo / unit.size));
    if (bound) cells.push_back(std::isfinite(c.cramer_rao) ? number_text(c.cramer_rao / unit.size) : "");
    t.rows.push_back(std::move(cells));
  }
  std::string undetermined;
  for (const CoefficientIndex index : s.undetermined) undetermined += (undetermined.empty() ? "" : ", ") + std::string(coefficient(index).name);
  return section("uncertainties", "Standard uncertainties to come",
                 s.runs.value_or(0) > 0 ? fmt::format("In closed form, and from a Monte Carlo of {} whole procedures.", *s.runs)
                                        : "In closed form, before any data.",
                 table(t) + (undetermined.empty() ? "" : paragraph("Not determined by this procedure: " + undetermined + ".")));
}

Verdict prediction_verdict(const PredictionReport& report) {
  const PredictionSummary& s = report.summary;
  const std::vector<Shortfall> missed = s.missed.value_or(std::vector<Shortfall>());
  Verdict v{.tone = Tone::neutral,
            .word = "predicted",
            .meaning = "What a calibration by this procedure will know, if rig and noise are as declared.",
            .because = {},
            .actions = {}};
  if (report.required) v.tone = Tone::good, v.word = "requirements met";
  if (!missed.empty()) v.tone = Tone::doubtful, v.word = "requirements not met";
  if (!s.undetermined.empty()) v.tone = Tone::doubtful, v.word = "not all is determined";
  for (const Shortfall& shortfall : missed) v.because.push_back(shortfall_line(shortfall));
  for (const CoefficientIndex index : s.undetermined) v.because.push_back(std::string(coefficient(index).name) + " is not determined");
  if (s.advice) v.actions = s.advice->turns;
  for (const Shortfall& shortfall : missed)
    if (const std::string action = "Reduce the largest source: " + shortfall.source + ".";
        !shortfall.source.empty() && std::find(v.actions.begin(), v.actions.end(), action) == v.actions.end())
      v.actions.push_back(action);
  return v;
}

}  // namespace

std::string shortfall_line(const Shortfall& shortfall) {
  return shortfall_text(shortfall) + (shortfall.source.empty() ? "" : "; most of it comes from: " + shortfall.source);
}

std::string preformatted(const std::string& text) { return "<div class=\"scroll\"><pre>" + escaped(text) + "</pre></div>\n"; }

std::string prediction_sections(const PredictionSummary& summary) {
  return summary.coefficients.empty() ? "" : shares_section(summary) + uncertainties_section(summary);
}

}  // namespace report

std::string prediction_page(const PredictionReport& r) {
  using namespace report;
  Page page;
  page.kind = "Prediction";
  page.title = r.procedure;
  page.subtitle = "Before any data are taken";
  page.verdict = prediction_verdict(r);
  page.figures = key_figures([&](CoefficientIndex index) { return sigma_of(index, r.summary.indices(), r.summary.sigma()); });
  page.body = worst_axis_note(page.figures) + prediction_sections(r.summary);
  for (const std::string& text : r.tables)
    if (!text.empty()) page.body += section("tolerances", "What would meet the requirements", "", preformatted(text));
  return page_text(page);
}

namespace report {
namespace {

std::string duration_text(double seconds) {
  return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60)));
}

std::string turns_section(const TurnPath& path) {
  Table t{.head = {"step", "turn about", "by [deg]", "then rest [s]"}, .rows = {{"1", "", "", number_text(path.first_rest, 5)}}, .left = {1}};
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    t.rows.push_back({fmt::format("{}", k + 2), std::string(to_string(path.turns[k].axis)) + " axis", number_text(path.turns[k].angle_deg, 5),
                      number_text(path.turns[k].rest, 5)});
  return section("turns", "The procedure", "Begin at zero angles; turn and rest in this order.", table(t));
}

/// The uncertainty of each required coefficient, relative to its limit.
std::string requirements_figure(const PlanSummary& plan) {
  std::vector<Interval> rows;
  const PredictionSummary& s = plan.prediction;
  for (const Requirement& r : plan.requirements)
    for (const CoefficientIndex index : r.coefficients) {
      const double sigma = sigma_of(index, s.indices(), s.sigma());
      if (std::isnan(sigma)) continue;
      rows.push_back({std::string(coefficient(index).name), sigma / r.limit, 0,
                      fmt::format("{} {}", uncertainty_text(sigma / r.unit.size), readable_unit(r.unit.name)), sigma / r.limit > 1});
    }
  if (rows.empty()) return {};
  return section("required", "Against the requirements", "",
                 figure(interval_rows(rows, "standard uncertainty over requirement", "requirements", 1), "At most 1 is required."));
}

Verdict plan_verdict(const PlanSummary& plan) {
  const std::vector<Shortfall> missed = plan.prediction.missed.value_or(std::vector<Shortfall>());
  const bool met = missed.empty();
  Verdict v{.tone = met ? Tone::good : Tone::doubtful,
            .word = met ? "requirements met" : "requirements not met",
            .meaning = fmt::format("{} turns in {}.", plan.path.turns.size(), duration_text(plan.path.duration)),
            .because = {},
            .actions = {}};
  for (const Shortfall& s : missed) v.because.push_back(shortfall_line(s));
  v.actions.emplace_back(
      met ? fmt::format("Save the procedure with imulab plan -o, perform it, and calibrate with --method {}.", planning_method().name)
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
  std::string method(planning_method().name);
  method[0] = static_cast<char>(std::toupper(method[0]));
  page.subtitle = method + " method" + (r.prior ? ", " + prior_text(*r.prior) : "");
  page.verdict = plan_verdict(r);
  page.body = turns_section(r.path) + requirements_figure(r) + prediction_sections(r.prediction);
  return page_text(page);
}

}  // namespace imulab
