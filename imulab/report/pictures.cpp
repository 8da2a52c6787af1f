#include "imulab/report/pictures.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::report {

namespace {

std::string box(double x, double y, double width, double height, std::string_view fill, std::string_view title = "") {
  const std::string shape = fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"", x, y, width, height, fill);
  return title.empty() ? shape + "/>" : fmt::format("{}><title>{}</title></rect>", shape, escaped(title));
}

/// A square of a correlation: blue at 1, orange at -1, and the less of it the weaker.
std::string shaded(double x, double y, double size, double r, std::string_view title = "") {
  std::string out = box(x, y, size, size, r > 0 ? color::blue : color::vermilion, title);
  const double strength = std::min(1.0, std::abs(r));
  return strength < 1 ? out.insert(5, fmt::format(" fill-opacity=\"{:.2f}\"", strength)) : out;
}

/// One half of the sphere about `center_x`: z above 0, or below.
std::string hemisphere(const std::vector<SphereMark>& marks, bool upper, double center_x, double center_y, double radius) {
  const double sign = upper ? 1 : -1;
  // Equal-area: from the pole at the center to the equator at the rim; seen from outside, so x points right above and left below.
  const auto place = [&](const Vector3d& v) {
    const Vector3d u = v.normalized();
    const double r = std::sqrt(std::max(0.0, 1 - sign * u.z())), across = std::hypot(u.x(), u.y());
    const double scale = across > 0 ? radius * r / across : 0;
    return std::array{center_x + sign * scale * u.x(), center_y - scale * u.y()};
  };
  std::string out = fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"#f5f7f9\" stroke=\"#9aa1aa\"/>", center_x, center_y, radius);
  for (const double angle : {30.0, 60.0})
    out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{:.1f}\" fill=\"none\" stroke=\"{}\"/>", center_x, center_y,
                       radius * std::sqrt(1 - std::cos(angle * 0.017453292519943)), color::grid);
  out += line_between(center_x - radius, center_y, center_x + radius, center_y, color::grid) +
         line_between(center_x, center_y - radius, center_x, center_y + radius, color::grid);
  std::string dots;
  for (const SphereMark& m : marks) {
    if ((m.direction.z() >= 0) != upper) continue;
    const auto [x, y] = place(m.direction);
    if (m.gap)
      out += line_between(x - 6, y - 6, x + 6, y + 6, color::vermilion, 2.4) + line_between(x - 6, y + 6, x + 6, y - 6, color::vermilion, 2.4);
    else
      dots += fmt::format("M{:.1f} {:.1f}h0", x, y);
  }
  out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\"/>", dots, color::blue,
                     marks.size() > 200 ? 3.5 : 7);
  const double label = radius + 12;
  out += text_at(center_x + label, center_y + 4, upper ? "+x" : "−x", Anchor::middle) +
         text_at(center_x - label, center_y + 4, upper ? "−x" : "+x", Anchor::middle);
  out += text_at(center_x, center_y - radius - 5, "+y", Anchor::middle) + text_at(center_x, center_y + radius + 14, "−y", Anchor::middle);
  return out + text_at(center_x, center_y + radius + 32, upper ? "+z up (center)" : "−z up (center)", Anchor::middle);
}

}  // namespace

std::string interval_rows(const std::vector<Interval>& rows, std::string_view unit, std::string_view description, std::optional<double> limit) {
  if (rows.empty()) return {};
  std::vector<double> ends{0, limit.value_or(0)};
  for (const Interval& r : rows) {
    ends.push_back(r.value - r.half_width);
    ends.push_back(r.value + r.half_width);
  }
  const Axis axis = axis_over("", ends);
  constexpr double width = 460, right = 320, step = 22, top = 6;
  std::size_t longest = 0;
  for (const Interval& r : rows) longest = std::max(longest, r.name.size());
  const double left = std::max(44.0, 7.2 * static_cast<double>(longest) + 12);
  const double bottom = top + step * static_cast<double>(rows.size());
  const auto at = [&](double v) { return left + (v - axis.low) / (axis.high - axis.low) * (right - left); };
  std::string out;
  const std::vector<double> values = ticks(axis, 3);
  for (const double v : values) {
    out += line_between(at(v), top, at(v), bottom, v == 0 ? color::gray : color::grid, v == 0 ? 1.4 : 1);
    out += text_at(at(v), bottom + 16, tick_text(v, are_raised(values)), Anchor::middle);
  }
  if (limit) out += line_between(at(*limit), top, at(*limit), bottom, color::vermilion, 1.4, true);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Interval& r = rows[k];
    const double y = top + step * (static_cast<double>(k) + 0.5);
    const std::string_view ink = r.marked ? color::vermilion : color::blue;
    out += text_at(left - 8, y + 4, r.name, Anchor::end) + text_at(right + 14, y + 4, r.text);
    if (!std::isfinite(r.value)) continue;
    if (std::isfinite(r.half_width) && r.half_width > 0) {
      const double a = at(r.value - r.half_width), b = at(r.value + r.half_width);
      out += line_between(a, y, b, y, ink, 2) + line_between(a, y - 5, a, y + 5, ink, 2) + line_between(b, y - 5, b, y + 5, ink, 2);
    }
    out += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.6\" fill=\"{}\"/>", at(r.value), y, ink);
  }
  out += text_at(0.5 * (left + right), bottom + 33, unit, Anchor::middle);
  return svg_text(width, bottom + 40, description, out);
}

std::string share_bars(const std::vector<ShareRow>& rows, std::string_view description) {
  double least = 0, most = 1;
  for (const ShareRow& row : rows) {
    double negative = 0, positive = 0;
    for (const SharePart& part : row.parts) (part.share < 0 ? negative : positive) += part.share;
    least = std::min(least, negative), most = std::max(most, positive);
  }
  constexpr double width = 840, left = 162, right = 500, step = 21, top = 4;
  const double bottom = top + step * static_cast<double>(rows.size());
  const auto at = [&](double v) { return left + (v - least) / (most - least) * (right - left); };
  std::string out;
  for (const double v : ticks({"", least, most}, 4)) {
    out += line_between(at(v), top, at(v), bottom, v == 0 ? color::gray : color::grid, 1);
    out += text_at(at(v), bottom + 16, tick_text(100 * v) + " %", Anchor::middle);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double y = top + step * static_cast<double>(k);
    out += text_at(left - 8, y + 14.5, rows[k].name, Anchor::end) + text_at(right + 10, y + 14.5, rows[k].value) +
           text_at(right + 150, y + 14.5, rows[k].largest);
    double negative = 0, positive = 0;
    for (const SharePart& part : rows[k].parts) {
      if (!std::isfinite(part.share) || std::abs(part.share) < 5e-4) continue;
      double& end = part.share < 0 ? negative : positive;
      const double wide = at(std::abs(part.share)) - at(0);  // a gap divides sources of one color
      out += box(at(std::min(end, end + part.share)), y + 3, wide > 3 ? wide - 1 : wide, step - 6, color::series(part.color),
                 fmt::format("{}: {:.1f} %", part.name, 100 * part.share));
      end += part.share;
    }
  }
  return svg_text(width, bottom + 24, description, out);
}

std::string correlation_map(const std::vector<std::string>& names, const Eigen::MatrixXd& correlation, std::string_view description) {
  const double n = static_cast<double>(names.size()), left = 164, top = 6, cell = std::clamp(760.0 / std::max(n, 1.0), 11.0, 30.0);
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double y = top + cell * static_cast<double>(i);
    out += text_at(left - 6, y + 0.5 * cell + 4, names[i], Anchor::end, "style=\"font-size:" + fmt::format("{:.1f}", std::min(12.5, cell)) + "px\"");
    for (std::size_t j = 0; j < names.size(); ++j) {
      const double r = correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (j > i || !(std::abs(r) >= 0.03)) continue;
      const double x = left + cell * static_cast<double>(j), size = cell - 0.6;
      out += i == j ? box(x, y, size, size, color::gray) : shaded(x, y, size, r, fmt::format("{} and {}: {:.2f}", names[i], names[j], r));
    }
  }
  const double side = cell * n, scale = left + side * 0.58;
  for (int k = -10; k <= 10; ++k) out += shaded(scale + 9.0 * (k + 10), top + 8, 9, 0.1 * k);
  for (const int k : {-1, 0, 1}) out += text_at(scale + 94 + 90.0 * k, top + 33, number_text(k), Anchor::middle);
  return svg_text(std::max(left + side + 30, scale + 210), std::max(top + side + 6, 48.0), description, out);
}

std::string sphere(const std::vector<SphereMark>& marks, std::string_view description) {
  constexpr double radius = 88, y = 112;
  return svg_text(460, 250, description, hemisphere(marks, true, 115, y, radius) + hemisphere(marks, false, 345, y, radius));
}

std::string axes_sketch() {
  constexpr double x0 = 100, y0 = 92;
  const auto arrow = [&](double dx, double dy, const char* name) {
    const double length = std::hypot(dx, dy), ux = dx / length, uy = dy / length, x = x0 + dx, y = y0 + dy;
    return line_between(x0, y0, x, y, color::ink, 1.6) + line_between(x, y, x - 8 * ux + 4 * uy, y - 8 * uy - 4 * ux, color::ink, 1.6) +
           line_between(x, y, x - 8 * ux - 4 * uy, y - 8 * uy + 4 * ux, color::ink, 1.6) +
           text_at(x + 10 * ux, y + 10 * uy + 4, name, Anchor::middle);
  };
  // About z from x, which comes out of the page, to y: counterclockwise as seen from above.
  const std::string arc = fmt::format("<path d=\"M70 116Q100 134 132 102\" fill=\"none\" stroke=\"{0}\" stroke-width=\"1.6\"/>", color::blue) +
                          line_between(132, 102, 130, 111, color::blue, 1.6) + line_between(132, 102, 123, 104, color::blue, 1.6);
  return svg_text(220, 150, "the axes: x toward the viewer, y to the right, z up; a positive rate about z turns x toward y",
                  arrow(-42, 34, "x") + arrow(70, 0, "y") + arrow(0, -70, "z") + arc);
}

}  // namespace imulab::report
