#include "imulab/report/extrinsics_page.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace report {
namespace {

/// x to the lower left, y to the right, z up.
Eigen::Vector2d on_paper(const Vector3d& v) { return {v.y() - 0.5 * v.x(), -v.z() + 0.4 * v.x()}; }

/// Both triads of axes, the second at the end of the lever arm, in the axes of the first.
std::string axes_picture(const Mounting& m) {
  constexpr double width = 460, height = 320, size = 70, room = 100;
  const double longest = std::max(m.lever_arm.norm(), 1e-6);
  const Eigen::Vector2d arm = on_paper(m.lever_arm / longest) * room;
  const Eigen::Vector2d first = Eigen::Vector2d(width, height) / 2 - arm / 2, second = first + arm;
  std::string out = line_between(first.x(), first.y(), second.x(), second.y(), color::gray, 1, true);
  const auto triad = [&](const Eigen::Vector2d& at, const Matrix3d& axes, const std::string& name, double thickness) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector2d end = at + size * on_paper(axes.col(i));
      out += line_between(at.x(), at.y(), end.x(), end.y(), color::series(static_cast<std::size_t>(i)), thickness);
      out += text_at(end.x() + 3, end.y() - 3, std::string(1, "xyz"[i]));
    }
    out += text_at(at.x() + 6, at.y() + 16, name);
  };
  triad(first, Matrix3d::Identity(), escaped(shortened(m.from, 24)), 1.5);
  triad(second, m.rotation.transpose(), escaped(shortened(m.to, 24)), 3);
  return svg_text(width, height, fmt::format("axes of {} and {}", m.from, m.to), out);
}

std::string with_sigma(double value, double sigma, std::string_view unit_name) {
  return escaped(fmt::format("{} ± {} {}", rounded_to(value, sigma), uncertainty_text(sigma), unit_name));
}

std::string numbers_of(const Mounting& m) {
  Table t;
  t.head = {"", "x", "y", "z"};
  const auto row = [&](const char* name, const Vector3d& value, Mounting::Row first, double unit_size, std::string_view unit_name) {
    std::vector<std::string> cells{name};
    for (int i = 0; i < 3; ++i) cells.push_back(with_sigma(value[i] / unit_size, m.uncertainties(first)[i] / unit_size, unit_name));
    t.rows.push_back(std::move(cells));
  };
  row("rotation vector", rotation_log(m.rotation), Mounting::rotation_row, unit::deg, "deg");
  row("lever arm", m.lever_arm, Mounting::lever_arm_row, 1e-3, "mm");
  for (int i = 0; i < 3; ++i)
    t.rows.push_back({fmt::format("rotation matrix, row {}", "xyz"[i]), fmt::format("{:.6f}", m.rotation(i, 0)),
                      fmt::format("{:.6f}", m.rotation(i, 1)), fmt::format("{:.6f}", m.rotation(i, 2))});
  t.rows.push_back({"clock offset", with_sigma(m.clock_offset * 1e3, m.uncertainty(Mounting::clock_offset_row) * 1e3, "ms"), "", ""});
  t.rows.push_back({"clock drift", with_sigma(m.clock_drift * 1e6, m.uncertainty(Mounting::clock_drift_row) * 1e6, "ppm"), "", ""});
  t.rows.push_back({"accelerometers' delay", with_sigma(m.accel_delay * 1e3, m.uncertainty(Mounting::accel_delay_row) * 1e3, "ms"), "", ""});
  return table(t);
}

std::string rates_chart(const BodyRates& rates, const Mounting& m, bool residuals) {
  TimeChart chart{.title = residuals ? "What the fit leaves of the rates" : fmt::format("Rates of both in the axes of {}", m.to), .y_label = "deg/s"};
  chart.x = rates.time;
  const auto add = [&](const Columns3& columns, const std::string& name) {
    for (std::size_t i = 0; i < 3; ++i) {
      chart.names.push_back(fmt::format("{}{}", "xyz"[i], name));
      auto& list = chart.y.emplace_back(columns[i]);
      for (double& v : list) v /= unit::deg;
    }
  };
  if (residuals) {
    add(rates.residual, "");
  } else {
    add(rates.first, " " + m.from), add(rates.second, " " + m.to);
  }
  return time_chart(chart);
}

}  // namespace
}  // namespace report

std::string extrinsics_page(const Extrinsics& extrinsics, const Conclusion& conclusion) {
  using namespace report;
  Page page;
  page.kind = "Extrinsics";
  page.title = fmt::format("{} IMUs on one body", extrinsics.imus.size());
  page.subtitle = fmt::format("relative to {}; {:.0f} s of {:.0f} s in common", extrinsics.imus.front(), extrinsics.used, extrinsics.duration);
  page.verdict.because = extrinsics.findings.reasons();
  take_conclusion(page.verdict, conclusion);
  page.verdict.actions = extrinsics.findings.of(Severity::warning);
  for (std::size_t k = 0; k < extrinsics.from_first.size(); ++k) {
    const Mounting& m = extrinsics.from_first[k];
    std::string content = numbers_of(m) + beside({figure(axes_picture(m), "The axes of both; thick: " + m.to)});
    if (k < extrinsics.rates.size()) content += rates_chart(extrinsics.rates[k], m, false) + rates_chart(extrinsics.rates[k], m, true);
    page.body += section(fmt::format("imu-{}", k + 1), fmt::format("{} relative to {}", m.to, m.from),
                         "With standard uncertainties. The rotation takes vectors from the axes of the first to those of the second.", content);
  }
  page.body += section("notes", "Notes", "", list(extrinsics.findings.notes()));
  return page_text(page);
}

}  // namespace imulab
