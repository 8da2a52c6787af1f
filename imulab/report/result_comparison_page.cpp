// A page of saved results of one kind: one figure, one table.
#include "imulab/report/comparison_page.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace report {
namespace {

std::string compared_key(const ResultComparison& c) {
  std::vector<std::pair<std::string, std::string_view>> entries;
  for (std::size_t k = 0; k < c.names.size(); ++k) entries.emplace_back(shortened(c.names[k], 60), color::series(k));
  return key(entries);
}

/// On a linear axis the largest result would hide the others.
bool far_apart(const ResultComparison& c, const std::string& panel) {
  constexpr double far = 20;
  double least = HUGE_VAL, most = 0;
  for (const ComparedCurve& curve : c.curves)
    if (curve.panel == panel && !curve.y.empty()) least = std::min(least, curve.y.back()), most = std::max(most, curve.y.back());
  return least > 0 && most > far * least;
}

/// Curves of one panel on one pair of axes.
std::string panel_plot(const ResultComparison& c, const std::string& panel, bool wide) {
  std::vector<double> x, y;
  for (const ComparedCurve& curve : c.curves)
    if (curve.panel == panel) x.insert(x.end(), curve.x.begin(), curve.x.end()), y.insert(y.end(), curve.y.begin(), curve.y.end());
  const bool decades = c.logarithmic || far_apart(c, panel);
  const double most = y.empty() ? 0 : *std::max_element(y.begin(), y.end());
  for (const auto& [text, limit] : c.limits) y.push_back(limit);
  if (decades)
    std::erase_if(y, [most](double v) { return v < 1e-5 * most; });  // errors begin at zero
  else
    y.push_back(0);
  const Axis beside = axis_over(panel, y, decades);
  Plot plot(axis_over(c.x_label, x, c.logarithmic), beside, panel, wide ? PlotSize{960, 330} : PlotSize{});
  for (const ComparedCurve& curve : c.curves) {
    if (curve.panel != panel) continue;
    std::vector<double> shown = curve.y;
    for (double& v : shown)
      if (v < beside.low) v = NAN;  // it would lie on the axis, as if it were constant
    plot.line(curve.x, shown, color::series(curve.result), 2);
  }
  for (const auto& [text, limit] : c.limits) plot.rule(limit, color::gray), plot.note(x.empty() ? 0 : x.front(), limit, text, Anchor::start, 4, -4);
  return figure(plot.svg(), "", wide);
}

/// Predictions have no curve: a dot each result on a row each coefficient, on one logarithmic axis of ratios to the first.
std::string ratio_rows(const ResultComparison& c) {
  constexpr std::size_t most = 24;
  constexpr double width = 960, left = 240, right = 920, step = 20, top = 8;
  const std::size_t rows = std::min(most, c.figures.size());
  const auto ratio = [](const ComparedFigure& f, std::size_t k) { return f.values[k] / f.values[0]; };
  std::vector<double> all{0.5, 2};
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < c.names.size(); ++k) all.push_back(ratio(c.figures[i], k));
  const Axis axis = axis_over("", all, true);
  const auto at = [&](double v) { return left + std::log(v / axis.low) / std::log(axis.high / axis.low) * (right - left); };
  const double bottom = top + step * static_cast<double>(rows);
  std::string out;
  for (const double v : {0.01, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0})
    if (v >= axis.low && v <= axis.high)
      out += line_between(at(v), top, at(v), bottom, v == 1 ? color::gray : color::grid) + text_at(at(v), bottom + 16, tick_text(v), Anchor::middle);
  for (std::size_t i = 0; i < rows; ++i) {
    const double y = top + step * (static_cast<double>(i) + 0.5);
    out += text_at(left - 8, y + 4, c.figures[i].name, Anchor::end);
    for (std::size_t k = 0; k < c.names.size(); ++k)
      if (const double r = ratio(c.figures[i], k); std::isfinite(r) && r > 0)
        out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", at(r), y, color::series(k));
  }
  out += text_at(0.5 * (left + right), bottom + 33, "ratio to the first", Anchor::middle);
  return figure(svg_text(width, bottom + 40, "ratios of the figures to those of the first result", out),
                fmt::format("The {} figures that differ most.", rows), true);
}

std::string compared_figure(const ResultComparison& c) {
  std::vector<std::string> panels;
  for (const ComparedCurve& curve : c.curves)
    if (std::ranges::find(panels, curve.panel) == panels.end()) panels.push_back(curve.panel);
  if (panels.empty()) return c.figures.empty() ? "" : compared_key(c) + ratio_rows(c);
  if (panels.size() == 1) return compared_key(c) + panel_plot(c, panels.front(), true);
  std::vector<std::string> plots;
  for (const std::string& panel : panels) plots.push_back(panel_plot(c, panel, false));
  return compared_key(c) + beside(plots);
}

std::string compared_table(const ResultComparison& c, std::size_t from, std::size_t to) {
  Table t{.head = {"figure", ""}, .rows = {}, .left = {1}};
  for (const std::string& name : c.names) t.head.push_back(escaped(shortened(name, 30)));
  for (std::size_t k = 1; k < c.names.size(); ++k) t.head.push_back((c.in_sigmas() ? "sigmas, " : "change, ") + escaped(shortened(c.names[k], 30)));
  for (std::size_t i = from; i < to; ++i) {
    const ComparedFigure& f = c.figures[i];
    std::vector<std::string> row{escaped(f.name), escaped(readable_unit(f.unit))};
    for (std::size_t k = 0; k < c.names.size(); ++k) row.push_back(escaped(figure_text(f, k)));
    for (std::size_t k = 1; k < c.names.size(); ++k) row.push_back(escaped(change_text(f, k)));
    t.rows.push_back(std::move(row));
  }
  return t.rows.empty() ? "" : table(t);
}

}  // namespace
}  // namespace report

std::string result_comparison_page(const ResultComparison& c, const Conclusion& conclusion, const std::vector<std::string>& warnings) {
  using namespace report;
  constexpr std::size_t open = 12;
  const std::size_t shown = std::min(open, c.figures.size());
  Page page;
  page.kind = "Comparison";
  page.title = fmt::format("{} results: {}", c.names.size(), c.kind);
  page.subtitle = "Each against the first.";
  page.verdict.word = "compared";
  page.verdict.meaning = c.headline;
  for (std::size_t k = 0; k < c.names.size(); ++k)
    if (!c.notes[k].empty()) page.verdict.because.push_back(c.names[k] + ": " + c.notes[k]);
  const std::string rest = compared_table(c, shown, c.figures.size());
  take_conclusion(page.verdict, conclusion);
  page.body = (warnings.empty() ? "" : section("warnings", "Warnings", "", list(warnings))) +
              section("figure", "All results", "", compared_figure(c)) +
              section("figures", "Figures", c.in_sigmas() ? "The most significant difference first." : "The largest change first.",
                      compared_table(c, 0, shown) + (rest.empty() ? "" : folded(fmt::format("{} more figures", c.figures.size() - shown), rest)));
  return page_text(page);
}

}  // namespace imulab
