#include "imulab/report/prediction_page.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/shares.hpp"
#include "imulab/rig/pose_on_table.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace imulab {

namespace report {
namespace {

UserUnit unit_in(const PredictionSummary& s, const PredictedCoefficient& c) { return unit_of(c.index, s.indices(), s.sigma()); }

std::string in_unit(double sigma, const UserUnit& unit) { return uncertainty_text(sigma / unit.size) + " " + readable_unit(unit.name); }

/// The bars of these coefficients: the parts of a bar are the sources, in the colors of their groups.
std::string share_figure(const PredictionSummary& s, bool optional_terms) {
  std::vector<ShareRow> rows;
  for (const PredictedCoefficient& c : s.coefficients) {
    if (is_optional(coefficient(c.index).term) != optional_terms) continue;
    double all = 0;
    for (const auto& [source, sigma] : c.budget) all += sigma * sigma;
    ShareRow r{std::string(coefficient(c.index).name), in_unit(c.sigma, unit_in(s, c)), {}, {}};
    const std::pair<std::string, double>* largest = nullptr;
    for (const auto& part : c.budget) {
      r.parts.push_back({source_group(part.first), all > 0 ? part.second * part.second / all : 0, part.first});
      if (largest == nullptr || part.second > largest->second) largest = &part;
    }
    std::stable_sort(r.parts.begin(), r.parts.end(), [](const SharePart& x, const SharePart& y) { return x.color < y.color; });
    if (largest != nullptr && all > 0) r.largest = fmt::format("{} {:.0f} %", largest->first, 100 * largest->second * largest->second / all);
    rows.push_back(std::move(r));
  }
  return rows.empty() ? "" : share_bars(rows, "shares of the sources");
}

/// The groups that occur, each with its sources.
std::string share_key(const PredictionSummary& s) {
  std::array<std::string, source_groups.size()> members;
  for (const auto& [source, sigma] : s.coefficients.front().budget) {
    std::string& group = members[source_group(source)];
    if (!find_effect(source) && source != undetermined_source) group += (group.empty() ? ": " : ", ") + source;
    if (group.empty()) group = " ";
  }
  std::vector<std::pair<std::string, std::string_view>> names;
  for (std::size_t k = 0; k < members.size(); ++k)
    if (!members[k].empty()) names.emplace_back(std::string(source_groups[k]) + (members[k] == " " ? "" : members[k]), color::series(k));
  return key(names);
}

std::string shares_section(const PredictionSummary& s) {
  if (s.coefficients.front().budget.empty()) return {};
  const std::string optional_terms = share_figure(s, true);
  return section(
      "shares", "What limits each coefficient",
      "The share of each source in the variance (to first order), the standard uncertainty, and the source with the largest share: improve "
      "that one first, since the others hardly count beside it.",
      share_key(s) + figure(share_figure(s, false), "", true) +
          (optional_terms.empty() ? "" : folded("Terms that the IMU may have", figure(optional_terms, "", true))));
}

std::string uncertainties_section(const PredictionSummary& s) {
  Table t{.head = {"coefficient", "u", ""}, .rows = {}, .left = {2}};
  const auto has = [&](auto number) { return std::any_of(s.coefficients.begin(), s.coefficients.end(), number); };
  const bool bound = has([](const auto& c) { return std::isfinite(c.cramer_rao); });
  const bool sampled = !s.coefficients.empty() && !has([](const auto& c) { return !c.monte_carlo || !std::isfinite(*c.monte_carlo); });
  if (sampled) t.head.emplace_back("Monte Carlo");
  if (bound) t.head.emplace_back("Cramér-Rao bound");
  const bool sizes = has([](const auto& c) { return c.sigma_of_half || c.sigma_of_twice; });
  if (sizes) t.head.insert(t.head.end(), {"half the effects", "twice the effects"});
  for (const PredictedCoefficient& c : s.coefficients) {
    const UserUnit unit = unit_in(s, c);
    std::vector<std::string> cells{"<code>" + escaped(coefficient(c.index).name) + "</code>", number_text(c.sigma / unit.size),
                                   escaped(readable_unit(unit.name))};
    if (sampled) cells.push_back(number_text(*c.monte_carlo / unit.size));
    if (bound) cells.push_back(std::isfinite(c.cramer_rao) ? number_text(c.cramer_rao / unit.size) : "");
    if (sizes)
      for (const std::optional<double>& sigma : {c.sigma_of_half, c.sigma_of_twice}) cells.push_back(sigma ? number_text(*sigma / unit.size) : "");
    t.rows.push_back(std::move(cells));
  }
  std::string undetermined;
  for (const CoefficientIndex index : s.undetermined) undetermined += (undetermined.empty() ? "" : ", ") + std::string(coefficient(index).name);
  std::string notes;
  for (const std::string& note : s.notes) notes += paragraph(escaped(note));
  return section("uncertainties", "Standard uncertainties to come",
                 s.runs.value_or(0) > 0 ? fmt::format("In closed form, and from a Monte Carlo of {} whole procedures.", *s.runs)
                                        : "In closed form, before any data.",
                 table(t) + (undetermined.empty() ? "" : paragraph("Not determined by this procedure: " + undetermined + ".")) + notes);
}

PageVerdict prediction_verdict(const PredictionReport& report) {
  const PredictionSummary& s = report.summary;
  const std::vector<Shortfall> missed = s.missed.value_or(std::vector<Shortfall>());
  PageVerdict v{.tone = Tone::neutral,
                .word = "predicted",
                .meaning = "What a calibration by this procedure will know, if rig and noise are as declared.",
                .because = {},
                .actions = {}};
  if (!missed.empty()) v.tone = Tone::doubtful;
  take_conclusion(v, report.conclusion);
  if (report.conclusion.requirements.empty())  // of a saved prediction of an earlier version
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

/// The rows of the terminal's table: the first rest, then each turn by its number.
std::string turns_section(const TurnPath& path) {
  const std::vector<std::string> words = in_words(path.turns);
  Table t{.head = {"turn", "axis", "angle [deg]", "rest [s]", "in the IMU's own terms"}, .rows = {}, .left = {1, 4}};
  t.rows.push_back({"", "", "", number_text(path.first_rest, 5), "rest at zero angles"});
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    t.rows.push_back({fmt::format("{}", k + 1), std::string(to_string(path.turns[k].axis)),
                      (path.turns[k].angle_deg > 0 ? "+" : "") + number_text(path.turns[k].angle_deg, 5), number_text(path.turns[k].rest, 5),
                      escaped(words[k])});
  return section("turns", "The procedure", "Begin at zero angles; turn, then rest, in this order.", table(t));
}

/// "gyro scale to 3 ppm" for gyro.matrix.diagonal <= 3 ppm.
std::string required_in_words(const Requirement& r) {
  constexpr std::array<std::array<std::string_view, 2>, 8> words{{{"accel.matrix.diagonal", "accelerometer scale"},
                                                                  {"accel.matrix.off_diagonal", "accelerometer misalignment"},
                                                                  {"accel.offset", "accelerometer bias"},
                                                                  {"accel.matrix", "accelerometer matrix"},
                                                                  {"gyro.matrix.diagonal", "gyro scale"},
                                                                  {"gyro.matrix.off_diagonal", "gyro misalignment"},
                                                                  {"gyro.offset", "gyro bias"},
                                                                  {"gyro.matrix", "gyro matrix"}}};
  std::string name = r.selector;
  for (const auto& [selector, word] : words)
    if (r.selector == selector) name = word;
  return fmt::format("{} to {} {}", name, number_text(r.limit / r.unit.size), readable_unit(r.unit.name));
}

std::string plan_title(const PlanSummary& plan) {
  std::string goals;
  for (std::size_t k = 0; k < plan.requirements.size(); ++k)
    goals += (k == 0 ? "" : k + 1 == plan.requirements.size() ? " and " : ", ") + required_in_words(plan.requirements[k]);
  return "Turns and rests for " + goals;
}

/// The uncertainty of each required coefficient, relative to its limit.
std::string requirements_figure(const PlanSummary& plan) {
  std::vector<Interval> rows;
  const PredictionSummary& s = plan.prediction;
  for (const Requirement& r : plan.requirements)
    for (const CoefficientIndex index : r.coefficients) {
      const auto c = std::ranges::find(s.coefficients, index, &PredictedCoefficient::index);
      if (c == s.coefficients.end()) continue;
      const double sigma = StatedSigma{c->sigma, c->degrees_of_freedom}.compared();
      rows.push_back({std::string(coefficient(index).name), sigma / r.limit, 0,
                      fmt::format("{} {}", uncertainty_text(sigma / r.unit.size), readable_unit(r.unit.name)), sigma / r.limit > 1});
    }
  if (rows.empty()) return {};
  return section("required", "Against the requirements", "",
                 figure(interval_rows(rows, "u, or U/2 where that is larger, over requirement", "requirements", 1), "At most 1 is required."));
}

PageVerdict plan_verdict(const PlanSummary& plan, const std::string& written) {
  const std::vector<Shortfall> missed = plan.prediction.missed.value_or(std::vector<Shortfall>());
  const bool met = missed.empty();
  PageVerdict v{.tone = met ? Tone::good : Tone::doubtful,
                .word = met ? "met" : "not met",
                .meaning = fmt::format("{} turns in {}.", plan.path.turns.size(), text::minutes(plan.path.duration)),
                .because = {},
                .actions = {}};
  for (const Shortfall& s : missed) v.because.push_back(shortfall_line(s));
  v.actions.emplace_back(met ? fmt::format("{}, and calibrate with --method {}.",
                                           written.empty() ? "Save the procedure with imulab plan -o, perform it" : "Perform " + written,
                                           planning_method().name)
                             : "Allow more time or more axes, or require less.");
  return v;
}

}  // namespace
}  // namespace report

std::string plan_page(const PlanSummary& r, const Conclusion& conclusion, const std::string& written) {
  using namespace report;
  Page page;
  page.kind = "Plan";
  page.title = plan_title(r);
  std::string method(planning_method().name);
  method[0] = static_cast<char>(std::toupper(method[0]));
  page.subtitle = method + " method" + (r.prior ? ", " + prior_text(*r.prior) : "") + (written.empty() ? "" : "; written: " + written);
  page.verdict = plan_verdict(r, written);
  take_conclusion(page.verdict, conclusion);
  page.figures = {{fmt::format("{}", r.path.turns.size()), "turns"}, {text::minutes(r.path.duration), "duration"}};
  for (const KeyFigure& figure : key_figures([&](CoefficientIndex index) { return sigma_of(index, r.prediction.indices(), r.prediction.sigma()); }))
    page.figures.push_back(figure);
  page.body = worst_axis_note(page.figures) + requirements_figure(r) + turns_section(r.path) + prediction_sections(r.prediction);
  return page_text(page);
}

}  // namespace imulab
