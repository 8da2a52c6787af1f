#include "imulab/results/result_comparison.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json_fields.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/results/over_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>
#include <utility>

namespace imulab {
namespace {

constexpr double unknown_figure = std::numeric_limits<double>::quiet_NaN();

/// Collects figures by name, so that results that lack some still stand beside the others.
class FigureRows {
 public:
  FigureRows(ResultComparison& out, std::size_t results) : out_(out), results_(results) {}
  void add(std::size_t result, const std::string& name, const std::string& unit, double value, double u = unknown_figure,
           double bound = unknown_figure) {
    const auto [at, is_new] = rows_.try_emplace(name, out_.figures.size());
    if (is_new) {
      const std::vector<double> none(results_, unknown_figure);
      out_.figures.push_back({name, unit, none, none, none});
    }
    ComparedFigure& row = out_.figures[at->second];
    row.values[result] = value, row.uncertainties[result] = u, row.bounds[result] = bound;
  }

 private:
  ResultComparison& out_;
  std::size_t results_;
  std::map<std::string, std::size_t> rows_;
};

constexpr std::array axis_words{"east", "north", "up"};

std::vector<double> since_first(std::vector<double> time) {
  const double first = time.empty() ? 0 : time.front();
  for (double& t : time) t -= first;
  return time;
}

void add_result(ResultComparison& out, FigureRows& rows, std::size_t k, const BudgetSummary& s) {
  const ErrorBudget& b = s.budget;
  const auto last = static_cast<Eigen::Index>(b.time.size()) - 1;
  std::vector<double> horizontal;
  for (std::size_t i = 0; i < b.time.size(); ++i) horizontal.push_back(horizontal_rms(b, i));
  rows.add(k, large_angles(b) ? "horizontal RMS, linear and rough" : "horizontal RMS", "m", horizontal.back());
  if (s.monte_carlo) rows.add(k, "horizontal RMS, Monte Carlo", "m", horizontal_rms(*s.monte_carlo));
  for (Eigen::Index q = 2; q < budget_quantities; ++q) {
    static constexpr std::array what{"position", "velocity", "attitude"}, units{"m", "m/s", "arcsec"};
    const auto part = static_cast<std::size_t>(q / 3);
    const double size = result_io::quantity_size(q), square = b.mean(q, last) * b.mean(q, last) + b.covariance.back()(q, q);
    rows.add(k, fmt::format("{} {} RMS", what[part], axis_words[static_cast<std::size_t>(q % 3)]), units[part], std::sqrt(square) / size);
  }
  if (s.monte_carlo) {
    rows.add(k, "drift CEP, Monte Carlo", "nmi/h", s.monte_carlo->drift_cep / unit::nmi_per_h);
    rows.add(k, "drift 95 %, Monte Carlo", "nmi/h", s.monte_carlo->drift_95 / unit::nmi_per_h);
  }
  for (const Contribution& c : b.groups) rows.add(k, "by " + c.name, "m", horizontal_rms(c, c.fixed.cols() - 1));
  out.curves.push_back({k, "horizontal error, RMS [m]", since_first(b.time), horizontal});
  out.x_label = "time [s]";
}

void add_result(ResultComparison& out, FigureRows& rows, std::size_t k, const NavigationSummary& sessions) {
  if (sessions.size() != 1 || !sessions.front().errors)
    throw Error(fmt::format("{}: expected one session with errors against a truth", excerpt(out.names[k])));
  const NavigationErrors& errors = *sessions.front().errors;
  const NavigationError& end = errors.history.back();
  rows.add(k, "horizontal position error", "m", end.horizontal());
  rows.add(k, "horizontal rate", "nmi/h", errors.rate / unit::nmi_per_h);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const char* axis = axis_words[static_cast<std::size_t>(i)];
    rows.add(k, fmt::format("position error {}", axis), "m", end.position[i]);
    rows.add(k, fmt::format("velocity error {}", axis), "m/s", end.velocity[i]);
    rows.add(k, fmt::format("attitude error {}", axis), "arcsec", end.attitude[i] / unit::arcsec);
  }
  ComparedCurve curve{k, "horizontal position error [m]", {}, {}};
  for (const NavigationError& e : errors.history) curve.x.push_back(e.time), curve.y.push_back(e.horizontal());
  curve.x = since_first(curve.x);
  out.curves.push_back(std::move(curve));
  out.x_label = "time [s]";
}

void add_result(ResultComparison& out, FigureRows& rows, std::size_t k, const NoiseAnalysis& analysis) {
  constexpr std::size_t rate = 1;  // a deviation has the unit of B
  for (const NoiseAxis& axis : analysis.axes) {
    const NoiseUnit& unit = noise_terms()[rate].unit(axis.unit);
    ComparedCurve curve{k, fmt::format("{} [{}]", axis.name.starts_with("gyro") ? "gyros" : "accelerometers", unit.name), {}, {}};
    for (const DeviationPoint& p : axis.deviation) curve.x.push_back(p.tau), curve.y.push_back(p.deviation / unit.size);
    out.curves.push_back(std::move(curve));
    for (const NoiseTermText& term : noise_terms()) {
      if (!axis.fit) continue;
      const NoiseCoefficient& c = (*axis.fit).*term.member;
      const NoiseUnit& of = term.unit(axis.unit);
      rows.add(k, fmt::format("{}.{}", axis.name, term.name), of.name, c.determined ? c.value / of.size : unknown_figure,
               c.determined ? c.standard_uncertainty / of.size : unknown_figure, c.determined ? unknown_figure : c.upper / of.size);
    }
  }
  out.x_label = "averaging time [s]", out.logarithmic = out.in_sigmas = true;
}

void add_result(ResultComparison&, FigureRows& rows, std::size_t k, const PredictionSummary& prediction) {
  for (const PredictedCoefficient& c : prediction.coefficients) {
    const Coefficient& of = coefficient(c.index);
    const UserUnit unit = user_unit(of, 0);
    rows.add(k, "u of " + std::string(of.name), std::string(unit.name), c.sigma / unit.size);
  }
}

template <class Other>
void add_result(ResultComparison& out, FigureRows&, std::size_t k, const Other& other) {
  throw Error(fmt::format("{}: a {} cannot be compared; expected calibrations, or results of noise, budget, predict or navigate",
                          excerpt(out.names[k]), kind_name(SavedResult(other))));
}

/// The grade and the noise of a budget.
std::string note_of(const SavedResult& result) {
  const auto* budget = std::get_if<BudgetSummary>(&result);
  if (budget == nullptr) return "";
  std::string text = budget->grade.empty() ? "" : "grade " + budget->grade;
  if (!budget->noise.empty()) text += (text.empty() ? "noise of " : ", noise of ") + budget->noise;
  return text;
}

/// The change of the k-th against the first, as significance counts it; NaN where it is not known.
double change_of(const ComparedFigure& f, std::size_t k) {
  const double difference = f.values[k] - f.values[0], u = std::hypot(f.uncertainties[0], f.uncertainties[k]);
  if (u > 0) return difference / u;
  const double size = std::max(std::abs(f.values[0]), std::abs(f.values[k]));
  if (size == 0) return 0;
  return f.values[0] * f.values[k] > 0 ? std::log(f.values[k] / f.values[0]) : difference / size;
}

std::string headline_of(const ResultComparison& c) {
  if (c.figures.empty()) return fmt::format("{} results without a figure in common", c.names.size());
  const ComparedFigure& first = c.figures.front();
  std::string text = c.in_sigmas ? "largest difference: " + first.name : first.name;
  for (std::size_t k = 0; k < c.names.size(); ++k)
    text += fmt::format("{}{} {} {}", k == 0 ? ": " : ", ", excerpt(c.names[k]), figure_text(first, k), first.unit);
  return text;
}

}  // namespace

std::string kind_name(const SavedResult& result) {
  static constexpr std::array<const char*, 9> names{
      "calibration", "comparison", "prediction", "plan", "navigation", "budget", "compensation", "noise analysis", "noise analysis of several logs"};
  return names.at(result.index());
}

ResultComparison compare_results(const std::vector<NamedResult>& results) {
  if (results.size() < 2) throw Error("one result alone cannot be compared; expected two or more of one kind");
  ResultComparison out{
      .kind = kind_name(results.front().result), .headline = {}, .names = {}, .notes = {}, .figures = {}, .curves = {}, .x_label = {}};
  for (const NamedResult& r : results) {
    if (r.result.index() != results.front().result.index())
      throw Error(fmt::format("{}: is a {}, and {} a {}; expected results of one kind", excerpt(r.name), kind_name(r.result),
                              excerpt(results.front().name), out.kind));
    out.names.push_back(r.name), out.notes.push_back(r.note.empty() ? note_of(r.result) : r.note);
  }
  FigureRows rows(out, results.size());
  for (std::size_t k = 0; k < results.size(); ++k) std::visit([&](const auto& result) { add_result(out, rows, k, result); }, results[k].result);
  for (ComparedFigure& f : out.figures)
    for (std::size_t k = 1; k < results.size(); ++k)
      if (const double change = change_of(f, k); !std::isnan(change)) f.significance = std::max(f.significance, std::abs(change));
  const bool leads = out.kind == "budget" || out.kind == "navigation";  // its first figure is what the mission is about
  std::stable_sort(out.figures.begin() + (leads && !out.figures.empty() ? 1 : 0), out.figures.end(),
                   [](const ComparedFigure& a, const ComparedFigure& b) { return a.significance > b.significance; });
  out.headline = headline_of(out);
  return out;
}

std::string figure_text(const ComparedFigure& f, std::size_t k) {
  if (!std::isnan(f.values[k]))
    return std::isnan(f.uncertainties[k]) ? text::number(f.values[k]) : text::to_digits_of(f.uncertainties[k], f.values[k]);
  return std::isfinite(f.bounds[k]) ? "< " + text::number(f.bounds[k], 2) : "-";
}

std::string change_text(const ComparedFigure& f, std::size_t k) {
  const double change = change_of(f, k);
  if (std::isnan(change)) return "";
  if (std::hypot(f.uncertainties[0], f.uncertainties[k]) > 0) return fmt::format("{:+.1f}", change);
  return f.values[0] * f.values[k] > 0 ? "x " + text::number(f.values[k] / f.values[0], 2) : "";
}

std::string result_comparison_json(const ResultComparison& c) {
  JsonFields figures;
  for (const ComparedFigure& f : c.figures) {
    JsonWriter row;
    row("unit", f.unit), row("values", f.values), row("standard_uncertainties", f.uncertainties), row("bounds", f.bounds);
    row(c.in_sigmas ? "sigmas" : "relative_change", f.significance < 0 ? std::optional<double>() : std::optional(f.significance));
    figures.fields.emplace_back(f.name, std::move(row.out));
  }
  return json_text(JsonFields{{{"kind", c.kind}, {"results", c.names}, {"notes", c.notes}, {"figures", figures}}}, JsonLayout::long_lists);
}

std::string result_comparison_table(const ResultComparison& c, bool details) {
  constexpr std::size_t most = 12;
  const auto letter = [](std::size_t k) { return k < 26 ? std::string(1, static_cast<char>('A' + k)) : fmt::format("#{}", k + 1); };
  std::string out = text::wrapped("", c.headline) + "\n";
  for (std::size_t k = 0; k < c.names.size(); ++k)
    out += text::wrapped(letter(k) + "  ", excerpt(c.names[k]) + (c.notes[k].empty() ? "" : "  (" + excerpt(c.notes[k]) + ")"));
  std::size_t name = 6, unit = 4;
  for (const ComparedFigure& f : c.figures) name = std::max(name, f.name.size()), unit = std::max(unit, f.unit.size());
  const bool changes = c.names.size() <= 3;  // of more, a line would not fit a terminal
  out += fmt::format("\n{:<{}} {:<{}}", "figure", name, "unit", unit);
  for (std::size_t k = 0; k < c.names.size(); ++k) out += fmt::format(" {:>9}", letter(k));
  for (std::size_t k = 1; k < c.names.size() && changes; ++k) out += fmt::format(" {:>7}", letter(k) + (c.in_sigmas ? " - A" : " / A"));
  out += c.in_sigmas && changes ? "  sigmas\n" : "\n";
  const std::size_t shown = details ? c.figures.size() : std::min(most, c.figures.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const ComparedFigure& f = c.figures[i];
    std::string row = fmt::format("{:<{}} {:<{}}", f.name, name, f.unit, unit);
    for (std::size_t k = 0; k < c.names.size(); ++k) row += fmt::format(" {:>9}", figure_text(f, k));
    for (std::size_t k = 1; k < c.names.size() && changes; ++k) row += fmt::format(" {:>7}", change_text(f, k));
    out += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
  }
  if (shown < c.figures.size()) out += fmt::format("{} more figures that differ less; --verbose lists them\n", c.figures.size() - shown);
  return out;
}

}  // namespace imulab
