#include "imulab/results/result_comparison.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/results/result_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

/// The change of the k-th against the first, as significance counts it; NaN where it is not known.
double change_of(const ComparedFigure& f, std::size_t k) {
  const double difference = f.values[k] - f.values[0], u = std::hypot(f.uncertainties[0], f.uncertainties[k]);
  if (u > 0) return difference / u;
  const double size = std::max(std::abs(f.values[0]), std::abs(f.values[k]));
  if (size == 0) return 0;
  return f.values[0] * f.values[k] > 0 ? std::log(f.values[k] / f.values[0]) : difference / size;
}

}  // namespace

bool ComparedFigure::in_sigmas() const {
  return std::ranges::any_of(uncertainties, [](double u) { return !std::isnan(u); });
}

double ComparedFigure::significance() const {
  double most = -1;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (const double change = change_of(*this, k); !std::isnan(change)) most = std::max(most, std::abs(change));
  return most;
}

bool ResultComparison::in_sigmas() const { return std::ranges::any_of(figures, &ComparedFigure::in_sigmas); }

std::string headline_of(const ResultComparison& c) {
  if (c.figures.empty()) return fmt::format("{} results without a figure in common", c.names.size());
  const ComparedFigure& first = c.figures.front();
  std::string text = c.in_sigmas() ? "largest difference: " + first.name : first.name;
  for (std::size_t k = 0; k < c.names.size(); ++k)
    text += fmt::format("{}{} {} {}", k == 0 ? ": " : ", ", excerpt(c.names[k]), figure_text(first, k), first.unit);
  return text;
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

std::string result_comparison_json(const ResultComparison& c) { return result_text("result-comparison", written(c), JsonLayout::long_lists); }

ResultComparison result_comparison_of(const json_io::Field& root) {
  ResultComparison out;
  read_into(root, out);
  out.headline = headline_of(out);
  return out;
}

std::string letter_of(std::size_t k) { return k < 26 ? std::string(1, static_cast<char>('A' + k)) : fmt::format("#{}", k + 1); }

namespace {

/// Rows of the first `shown` figures with these results, then with the changes if these are all results and fit, too.
std::string figure_rows(const ResultComparison& c, std::size_t shown, std::size_t from, std::size_t to) {
  std::size_t name = 6, unit = 4;
  for (const ComparedFigure& f : c.figures) name = std::max(name, f.name.size()), unit = std::max(unit, f.unit.size());
  constexpr std::size_t figure = 10, change = 8, in_sigmas = 8, terminal = 80;  // widths, with the space before
  const std::size_t values = name + 1 + unit + figure * c.names.size();
  const bool changes = values + change * (c.names.size() - 1) + (c.in_sigmas() ? in_sigmas : 0) <= terminal;
  std::string out = fmt::format("\n{:<{}} {:<{}}", "figure", name, "unit", unit);
  for (std::size_t k = from; k < to; ++k) out += fmt::format(" {:>9}", letter_of(k));
  for (std::size_t k = 1; k < to && changes; ++k) out += fmt::format(" {:>7}", letter_of(k) + (c.in_sigmas() ? " - A" : " / A"));
  out += c.in_sigmas() && changes ? "  sigmas\n" : "\n";
  for (std::size_t i = 0; i < shown; ++i) {
    const ComparedFigure& f = c.figures[i];
    std::string row = fmt::format("{:<{}} {:<{}}", f.name, name, f.unit, unit);
    for (std::size_t k = from; k < to; ++k) row += fmt::format(" {:>9}", figure_text(f, k));
    for (std::size_t k = 1; k < to && changes; ++k) row += fmt::format(" {:>7}", change_text(f, k));
    out += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
  }
  return out;
}

}  // namespace

std::string result_comparison_table(const ResultComparison& c, bool details) {
  constexpr std::size_t most = 12, widest = 4;  // figures; results in the width of a terminal
  const std::size_t parts = (c.names.size() + widest - 1) / widest, together = (c.names.size() + parts - 1) / parts;
  std::string out = text::wrapped("", c.headline) + "\n";
  for (std::size_t k = 0; k < c.names.size(); ++k)
    out += text::wrapped(letter_of(k) + "  ", excerpt(c.names[k]) + (c.notes[k].empty() ? "" : "  (" + one_line(c.notes[k]) + ")"));
  const std::size_t shown = details ? c.figures.size() : std::min(most, c.figures.size());
  for (std::size_t from = 0; from < c.names.size(); from += together) out += figure_rows(c, shown, from, std::min(from + together, c.names.size()));
  if (shown < c.figures.size()) out += fmt::format("{} more figures that differ less; --verbose lists them\n", c.figures.size() - shown);
  return out;
}

}  // namespace imulab
