#include "imulab/report/noise_moving.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/noise_figures.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/results/noise_moving.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace imulab::report {
namespace {

/// Bars of a cause from 1 to its factor on a logarithmic axis, with the 95 % interval as a line.
class FactorBars {
 public:
  explicit FactorBars(const std::vector<MovingRow>& rows) : rows_(rows) {
    for (const MovingRow& row : rows)
      for (const MovingCell* cell : {&row.gyro, &row.accel})
        if (cell->value > 0) axis_.high = std::max(axis_.high, cell->value), axis_.low = std::min(axis_.low, cell->value);
  }

  std::string svg() const {
    std::string out;
    double y = top;
    for (const double tick : ticks(axis_)) {
      out += line_between(at(tick), top, at(tick), top + row_height * static_cast<double>(rows_.size()), color::grid);
      out += text_at(at(tick), top + row_height * static_cast<double>(rows_.size()) + 16, tick_text(tick), Anchor::middle);
    }
    for (const MovingRow& row : rows_) {
      out += text_at(left - 12, y + 24, fmt::format("{} ({})", row.cause, row.parameter), Anchor::end);
      out += bar(row.gyro, y + 6, color::blue) + bar(row.accel, y + 24, color::vermilion);
      y += row_height;
    }
    out += line_between(at(1), top, at(1), y, color::ink);
    return svg_text(width, y + 26, "Factor of each cause, gyros above accelerometers, on a logarithmic axis.", out);
  }

 private:
  static constexpr double width = 760, left = 190, right = 640, top = 8, row_height = 44, bar_height = 14;

  double at(double factor) const {
    const double share = std::log(std::clamp(factor, axis_.low, axis_.high) / axis_.low) / std::log(axis_.high / axis_.low);
    return left + share * (right - left);
  }

  std::string bar(const MovingCell& cell, double y, std::string_view fill) const {
    if (cell.axis.empty()) return "";
    if (cell.value <= 0) return text_at(at(1) + 6, y + 11, cell.interval);
    const double from = std::min(at(1), at(cell.value)), to = std::max(at(1), at(cell.value));
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\" fill=\"{}\"/>", from, y, std::max(1.0, to - from), bar_height,
                       fill) +
           line_between(at(cell.low), y + bar_height / 2, at(cell.high), y + bar_height / 2, color::ink) +
           text_at(std::max(to, at(cell.high)) + 6, y + 11, fmt::format("{} ({})", cell.factor, cell.axis));
  }

  const std::vector<MovingRow>& rows_;
  Axis axis_{"factor", 0.9, 2, true};
};

}  // namespace

std::string moving_section(const NoiseAnalysis& analysis) {
  if (!analysis.moving) return "";
  const std::vector<MovingRow> rows = moving_rows(analysis);
  Table use{.head = {"a filter here should use", "gyro", "accelerometer"}, .rows = {}, .left = {1, 2}};
  for (const auto& [name, gyro, accel] : moving_totals(analysis))
    use.rows.push_back({escaped(name), escaped(noise_unit_text(gyro)), escaped(noise_unit_text(accel))});
  return section("moving", "Where the factor comes from",
                 "Factor of N, K or the bias instability at rest by cause, of each triad's worst axis, with 95 % intervals.",
                 key({{"gyro", color::blue}, {"accelerometer", color::vermilion}}) + figure(FactorBars(rows).svg(), "", true) + table(use) +
                     list(moving_details(analysis)) + list(analysis.moving->files));
}

}  // namespace imulab::report
