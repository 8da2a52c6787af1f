#include "imulab/results/compare_results.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/aid_loss.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/results/over_time.hpp"
#include "imulab/units.hpp"

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

/// The linear horizontal RMS over time [m]; where that is rough, the Monte Carlo's median if there is one: a saved budget has no other.
std::vector<double> stated_horizontal(const BudgetSummary& s) {
  const ErrorBudget& b = s.budget;
  const bool sampled = large_angles(b) && s.monte_carlo && s.monte_carlo->median.cols() == static_cast<Eigen::Index>(b.time.size());
  std::vector<double> out;
  for (std::size_t i = 0; i < b.time.size(); ++i)
    out.push_back(sampled ? s.monte_carlo->median(budget_quantities, static_cast<Eigen::Index>(i)) : horizontal_rms(b, i));
  return out;
}

void add_result(ResultComparison& out, FigureRows& rows, std::size_t k, const BudgetSummary& s) {
  const ErrorBudget& b = s.budget;
  const auto last = static_cast<Eigen::Index>(b.time.size()) - 1;
  const std::vector<double> horizontal = stated_horizontal(s);
  rows.add(k, "horizontal RMS", "m", large_angles(b) && s.monte_carlo ? horizontal_rms(*s.monte_carlo) : horizontal.back());
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
  if (!b.loss) {
    out.curves.push_back({k, "horizontal error, RMS (rough: median) [m]", since_first(b.time), horizontal});
    out.x_label = "time [s]";
    return;
  }
  ComparedCurve& curve = out.curves.emplace_back(ComparedCurve{k, "horizontal error, RMS [m]", {}, {}});
  for (std::size_t i = 0; i < b.time.size(); ++i)
    if (b.time[i] >= b.loss->begin) curve.x.push_back(b.time[i] - b.loss->begin), curve.y.push_back(horizontal[i]);
  out.x_label = "time since the loss of " + lost_aids(*b.loss) + " [s]";
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

void add_result(ResultComparison&, FigureRows& rows, std::size_t k, const AidedSummary& s) {
  const AidedNavigation& n = s.navigation;
  rows.add(k, "largest position sigma", "m", s.largest_sigma);
  if (n.outages.empty()) return;
  for (const auto& [what, part] : {std::pair("predicted", &OutageResult::predicted), std::pair("smoothed", &OutageResult::smoothed)}) {
    const OutageSummary withheld = outage_summary(n.outages, part);
    rows.add(k, fmt::format("withheld, {}: median", what), "m", withheld.median);
    rows.add(k, fmt::format("withheld, {}: error/sigma", what), "1", withheld.ratio);
  }
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
               c.determined && std::isfinite(c.standard_uncertainty) ? c.standard_uncertainty / of.size : unknown_figure,
               c.determined ? unknown_figure : c.upper / of.size);
    }
  }
  out.x_label = "averaging time [s]", out.logarithmic = true;
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

std::string rough_note(const BudgetSummary& budget) {
  if (!large_angles(budget.budget)) return "";
  return budget.monte_carlo ? ", linear figures rough: RMS and median of the Monte Carlo" : ", linear figures rough";
}

/// The grade and the noise of a budget.
std::string note_of(const SavedResult& result) {
  const auto* budget = std::get_if<BudgetSummary>(&result);
  if (budget == nullptr) return "";
  std::string text = budget->grade.empty() ? "" : "grade " + budget->grade;
  if (!budget->noise.empty()) text += (text.empty() ? "noise of " : ", noise of ") + budget->noise;
  return text + rough_note(*budget);
}

}  // namespace

std::string kind_name(const SavedResult& result) {
  static constexpr std::array<const char*, 12> names{
      "calibration",          "comparison", "prediction",   "plan",           "navigation",
      "navigation with aids", "budget",     "compensation", "noise analysis", "noise analysis of several logs",
      "comparison of results", "set of extrinsics"};
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
  const bool leads = out.kind == "budget" || out.kind == "navigation";  // its first figure is what the mission is about
  std::stable_sort(out.figures.begin() + (leads && !out.figures.empty() ? 1 : 0), out.figures.end(),
                   [](const ComparedFigure& a, const ComparedFigure& b) { return a.significance() > b.significance(); });
  out.headline = headline_of(out);
  return out;
}

ResultComparison compare_grades(std::vector<BudgetSummary> budgets) {
  std::vector<NamedResult> results;
  for (BudgetSummary& budget : budgets) {
    std::string name = budget.grade, note = "noise of " + budget.noise + rough_note(budget);
    results.push_back({std::move(name), std::move(budget), std::move(note)});
  }
  return compare_results(results);
}

}  // namespace imulab
