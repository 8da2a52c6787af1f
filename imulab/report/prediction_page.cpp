#include "imulab/report/prediction_page.hpp"

#include "imulab/model/user_value.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/key_figures.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/results/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace report {
namespace {

/// One unit for all coefficients of a term, by the largest of them; the readings are those of an ideal IMU, in SI.
UserUnit unit_in(const PredictionSummary& s, std::size_t k) {
  const Coefficient& c = coefficient(s.coefficients[k]);
  double largest = 0;
  for (std::size_t j = 0; j < s.coefficients.size(); ++j)
    if (coefficient(s.coefficients[j]).triad == c.triad && coefficient(s.coefficients[j]).term == c.term)
      largest = std::max(largest, s.sigma[static_cast<Eigen::Index>(j)]);
  return user_unit(c, largest, TriadModel{});
}

std::string in_unit(double sigma, const UserUnit& unit) { return uncertainty_text(sigma / unit.size) + " " + readable_unit(unit.name); }

std::string shares_section(const PredictionSummary& s) {
  if (s.sources.empty()) return {};
  std::vector<ShareRow> rows;
  for (std::size_t k = 0; k < s.coefficients.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double all = s.variance.row(row).sum();
    ShareRow r{std::string(coefficient(s.coefficients[k]).name), in_unit(s.sigma[row], unit_in(s, k)), {}};
    for (Eigen::Index source = 0; source < s.variance.cols(); ++source) r.parts.push_back(all > 0 ? s.variance(row, source) / all : 0);
    rows.push_back(std::move(r));
  }
  return section("shares", "What limits each coefficient", "The share of each source in the variance (to first order), and the standard uncertainty.",
                 figure(share_bars(s.sources, rows, "shares of the sources"),
                        "Improve the source with the longest bar first: the others hardly count beside it.", true));
}

std::string uncertainties_section(const PredictionSummary& s) {
  Table t{.head = {"coefficient", "u", ""}, .rows = {}, .left = {2}};
  const bool bound = s.cramer_rao.size() == s.sigma.size() && s.cramer_rao.array().isFinite().any();
  if (s.monte_carlo) t.head.emplace_back("Monte Carlo");
  if (bound) t.head.emplace_back("Cramér-Rao bound");
  for (std::size_t k = 0; k < s.coefficients.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const UserUnit unit = unit_in(s, k);
    std::vector<std::string> cells{"<code>" + escaped(coefficient(s.coefficients[k]).name) + "</code>", number_text(s.sigma[row] / unit.size),
                                   escaped(readable_unit(unit.name))};
    if (s.monte_carlo) cells.push_back(number_text((*s.monte_carlo)[row] / unit.size));
    if (bound) cells.push_back(std::isfinite(s.cramer_rao[row]) ? number_text(s.cramer_rao[row] / unit.size) : "");
    t.rows.push_back(std::move(cells));
  }
  std::string undetermined;
  for (const CoefficientIndex index : s.undetermined) undetermined += (undetermined.empty() ? "" : ", ") + std::string(coefficient(index).name);
  return section(
      "uncertainties", "Standard uncertainties to come",
      s.runs > 0 ? fmt::format("In closed form, and from a Monte Carlo of {} whole procedures.", s.runs) : "In closed form, before any data.",
      table(t) + (undetermined.empty() ? "" : paragraph("Not determined by this procedure: " + undetermined + ".")));
}

Verdict prediction_verdict(const PredictionReport& report) {
  const PredictionSummary& s = report.summary;
  Verdict v{.tone = Tone::neutral,
            .word = "predicted",
            .meaning = "What a calibration by this procedure will know, if rig and noise are as declared.",
            .because = {},
            .actions = {}};
  if (report.required) v.tone = Tone::good, v.word = "requirements met";
  if (!s.missed.empty()) v.tone = Tone::doubtful, v.word = "requirements not met";
  if (!s.undetermined.empty()) v.tone = Tone::doubtful, v.word = "not all is determined";
  for (const Shortfall& shortfall : s.missed) v.because.push_back(shortfall_line(shortfall));
  for (const CoefficientIndex index : s.undetermined) v.because.push_back(std::string(coefficient(index).name) + " is not determined");
  v.actions = s.advice;
  for (const Shortfall& shortfall : s.missed)
    if (const std::string action = "Reduce the largest source: " + shortfall.source + ".";
        !shortfall.source.empty() && std::find(v.actions.begin(), v.actions.end(), action) == v.actions.end())
      v.actions.push_back(action);
  return v;
}

std::vector<KeyFigure> prediction_figures(const PredictionSummary& s) {
  return key_figures([&](CoefficientIndex index) {
    const auto at = std::find(s.coefficients.begin(), s.coefficients.end(), index) - s.coefficients.begin();
    return at < s.sigma.size() ? s.sigma[at] : std::numeric_limits<double>::quiet_NaN();
  });
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
  page.figures = prediction_figures(r.summary);
  page.body = worst_axis_note(page.figures) + prediction_sections(r.summary);
  for (const std::string& text : r.tables)
    if (!text.empty()) page.body += section("tolerances", "What would meet the requirements", "", preformatted(text));
  return page_text(page);
}

}  // namespace imulab
