#include "imulab/report/plot.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

namespace imulab::report {

std::string_view color::series(std::size_t k) {
  constexpr std::array<std::string_view, 14> all{blue,      vermilion, green,     orange,    purple,    sky,       gray,
                                                 "#5d3a9b", "#b8a800", "#40514e", "#8c4a2f", "#f0b7a4", "#00d5c8", "#c3d4a5"};
  return all[k % all.size()];
}

Axis axis_over(std::string label, const std::vector<double>& values, bool logarithmic) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double v : values) {
    if (!std::isfinite(v) || (logarithmic && v <= 0)) continue;
    low = std::min(low, v), high = std::max(high, v);
  }
  if (!(low <= high)) low = logarithmic ? 0.1 : 0, high = 1;
  constexpr double least = 1e-200, greatest = 1e200;
  if (logarithmic) {
    low = std::clamp(low, least, greatest), high = std::clamp(high, least, greatest);
    return {std::move(label), std::pow(10, std::floor(std::log10(low) - 0.05)), std::pow(10, std::ceil(std::log10(high) + 0.05)), true};
  }
  const double room = high > low ? 0.05 * (high - low) : (high != 0 ? std::abs(high) : 1.0);
  return {std::move(label), low - room, high + room, false};
}

std::vector<double> ticks(const Axis& axis, int count) {
  std::vector<double> out;
  if (axis.logarithmic) {
    const double decades = std::log10(axis.high / axis.low);
    const int step = std::max(1, static_cast<int>(std::ceil(decades / (count + 1))));
    for (int k = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)); k <= std::log10(axis.high) + 1e-9; k += step)
      out.push_back(std::pow(10, k));
    return out;
  }
  const double wanted = (axis.high - axis.low) / std::max(1, count), unit = std::pow(10, std::floor(std::log10(wanted)));
  double step = 10 * unit;
  for (const double candidate : {1.0, 2.0, 2.5, 5.0})
    if (candidate * unit >= wanted * 0.999) {
      step = candidate * unit;
      break;
    }
  for (double k = std::ceil(axis.low / step - 1e-9); k * step <= axis.high + 1e-9 * step && out.size() < 50; ++k)
    out.push_back(k == 0 ? 0 : k * step);
  return out;
}

std::string text_at(double x, double y, std::string_view text, Anchor anchor, std::string_view attributes) {
  constexpr std::array names{"start", "middle", "end"};
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}{}>{}</text>", x, y, names[static_cast<std::size_t>(anchor)],
                     attributes.empty() ? "" : " ", attributes, escaped(text));
}

std::string line_between(double x1, double y1, double x2, double y2, std::string_view stroke, double width, bool dashed) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"{}/>", x1, y1, x2, y2, stroke,
                     width, dashed ? " stroke-dasharray=\"5 4\"" : "");
}

std::string svg_text(double width, double height, std::string_view description, const std::string& content) {
  return fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">{}</svg>", width, height,
                     escaped(description), content);
}

std::string key(const std::vector<std::pair<std::string, std::string_view>>& entries) {
  std::string out = "<div>";
  for (const auto& [name, fill] : entries) out += fmt::format("<span class=\"key\"><i style=\"background:{}\"></i>{}</span>", fill, escaped(name));
  return out + "</div>";
}

Plot::Plot(Axis x, Axis y, std::string description, PlotSize size)
    : x_(std::move(x)), y_(std::move(y)), description_(std::move(description)), size_(size), small_(size.width < 300) {
  left_ = small_ ? 56 : 64, right_ = size.width - 10, top_ = 8, bottom_ = size.height - (small_ ? 22 : 42);
}

double Plot::at_x(double v) const {
  const double part = x_.logarithmic ? std::log(v / x_.low) / std::log(x_.high / x_.low) : (v - x_.low) / (x_.high - x_.low);
  return left_ + part * (right_ - left_);
}

double Plot::at_y(double v) const {
  const double part = y_.logarithmic ? std::log(v / y_.low) / std::log(y_.high / y_.low) : (v - y_.low) / (y_.high - y_.low);
  return std::clamp(bottom_ - part * (bottom_ - top_), top_, bottom_);
}

void Plot::line(const std::vector<double>& x, const std::vector<double>& y, std::string_view color, double width) {
  std::string points;
  const auto end = [&] {
    if (!points.empty())
      marks_ +=
          fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"/>", points, color, width);
    points.clear();
  };
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double px = at_x(x[i]), py = at_y(y[i]);
    if (!std::isfinite(px) || !std::isfinite(py))
      end();
    else
      points += fmt::format("{:.1f},{:.1f} ", px, py);
  }
  end();
}

void Plot::band(const std::vector<double>& x, const std::vector<double>& low, const std::vector<double>& high, std::string_view color) {
  std::string there, back;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double px = at_x(x[i]), a = at_y(low[i]), b = at_y(high[i]);
    if (!std::isfinite(px) || !std::isfinite(a) || !std::isfinite(b)) continue;
    there += fmt::format("{:.1f},{:.1f} ", px, a);
    back = fmt::format("{:.1f},{:.1f} ", px, b) + back;
  }
  if (!there.empty()) marks_ += fmt::format("<polygon points=\"{}{}\" fill=\"{}\" fill-opacity=\"0.18\"/>", there, back, color);
}

/// One path of points: a few bytes each, where a circle is a hundred.
void Plot::dots(const std::vector<double>& x, const std::vector<double>& y, std::string_view color, bool hollow) {
  const double width = x.size() > 150 ? 3.4 : x.size() > 60 ? 5 : 7;
  std::string path;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double px = at_x(x[i]), py = at_y(y[i]);
    if (std::isfinite(px) && std::isfinite(py)) path += fmt::format("M{:.1f} {:.1f}h0", px, py);
  }
  if (path.empty()) return;
  const auto drawn = [&](std::string_view stroke, double size) {
    return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\"/>", path, stroke, size);
  };
  marks_ += drawn(color, width);
  if (hollow) marks_ += drawn("#fff", width - 2.4);
}

void Plot::bars(const std::vector<double>& x, const std::vector<double>& y, double width, std::string_view color) {
  const double base = at_y(y_.logarithmic ? y_.low : std::clamp(0.0, y_.low, y_.high));
  std::string path;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double tip = at_y(y[i]), left = at_x(x[i] - 0.5 * width), wide = std::max(0.8, at_x(x[i] + 0.5 * width) - left);
    if (std::isfinite(tip) && std::isfinite(left))
      path += fmt::format("M{:.1f} {:.1f}h{:.1f}V{:.1f}h{:.1f}z", left, base, wide, std::min(tip, base - 0.6), -wide);
  }
  if (!path.empty()) marks_ += fmt::format("<path d=\"{}\" fill=\"{}\"/>", path, color);
}

void Plot::shade(const std::vector<std::pair<double, double>>& spans, std::string_view color, double opacity) {
  std::string path;
  for (const auto& [low, high] : spans) {
    const double a = std::clamp(at_x(low), left_, right_), wide = std::max(0.8, std::clamp(at_x(high), left_, right_) - a);
    path += fmt::format("M{:.1f} {:.1f}h{:.1f}V{:.1f}h{:.1f}z", a, top_, wide, bottom_, -wide);
  }
  if (!path.empty()) marks_ += fmt::format("<path d=\"{}\" fill=\"{}\" fill-opacity=\"{}\"/>", path, color, opacity);
}

void Plot::rule(double y, std::string_view color) {
  if (y < y_.low || y > y_.high) return;
  marks_ += line_between(left_, at_y(y), right_, at_y(y), color, 1, true);
}

std::string Plot::axes() const {
  std::string out;
  for (const double v : ticks(y_, small_ ? 3 : 5)) {
    const double y = at_y(v);
    out += line_between(left_, y, right_, y, color::grid);
    out += text_at(left_ - 6, y + 4, tick_text(v), Anchor::end);
  }
  for (const double v : ticks(x_, small_ ? 4 : size_.width > 600 ? 10 : 6)) {
    const double x = at_x(v);
    out += line_between(x, bottom_, x, bottom_ + 4, color::gray);
    out += text_at(x, bottom_ + 18, tick_text(v), x > right_ - 14 ? Anchor::end : Anchor::middle);
  }
  out += line_between(left_, bottom_, right_, bottom_, color::gray);
  if (small_) return out;
  out += text_at(0.5 * (left_ + right_), size_.height - 5, x_.label, Anchor::middle);
  const double middle = 0.5 * (top_ + bottom_);
  return out + text_at(13, middle, y_.label, Anchor::middle, fmt::format("transform=\"rotate(-90 13 {:.1f})\"", middle));
}

std::string Plot::svg() const { return svg_text(size_.width, size_.height, description_, axes() + marks_); }

namespace {

/// As JSON inside a script element: "<" would end it.
std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '<' || c == '>' || c == '&' || static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + "\"";
}

template <class Values, class Text>
std::string json_list(const Values& values, const Text& text) {
  std::string out = "[";
  for (const auto& v : values) out += (out.size() > 1 ? "," : "") + text(v);
  return out + "]";
}

std::string json_number(double v) { return std::isfinite(v) ? fmt::format("{:.5g}", v) : "null"; }
std::string json_time(double v) { return fmt::format("{:.9g}", v); }

const char* name_of(Mark mark) { return mark == Mark::rest ? "rest" : mark == Mark::dropped ? "dropped" : "gap"; }

std::vector<std::string> colors_of(const TimeChart& chart) {
  std::vector<std::string> colors = chart.colors;
  for (std::size_t k = colors.size(); k < chart.y.size(); ++k) colors.emplace_back(color::series(k));
  return colors;
}

/// Least and greatest of each of `parts` parts.
std::pair<std::vector<double>, std::vector<double>> thinned(const std::vector<double>& x, const std::vector<double>& y, std::size_t parts) {
  if (x.size() <= 2 * parts) return {x, y};
  std::pair<std::vector<double>, std::vector<double>> out;
  const std::size_t step = (x.size() + parts - 1) / parts;
  for (std::size_t begin = 0; begin < x.size(); begin += step) {
    const std::size_t end = std::min(x.size(), begin + step);
    const auto first = y.begin() + static_cast<std::ptrdiff_t>(begin), last = y.begin() + static_cast<std::ptrdiff_t>(end);
    const auto [low, high] = std::minmax_element(first, last);
    out.first.insert(out.first.end(), {x[begin], x[end - 1]});
    out.second.insert(out.second.end(), {*std::min(low, high), *std::max(low, high)});
  }
  return out;
}

/// The chart with times from its start, in the unit of its axis.
TimeChart from_its_start(TimeChart chart) {
  const double unit = chart.minutes ? 60 : 1;
  const auto move = [&](double& time) { time = (time - chart.start) / unit; };
  std::for_each(chart.x.begin(), chart.x.end(), move);
  for (MarkedTime& mark : chart.marks) move(mark.begin), move(mark.end);
  return chart;
}

std::string still(const TimeChart& chart, const std::string& x_label, const std::vector<std::string>& colors) {
  constexpr std::size_t parts = 450;
  std::vector<double> all;
  for (const auto& series : chart.y) all.insert(all.end(), series.begin(), series.end());
  const double first = chart.x.empty() ? 0 : std::min(0.0, chart.x.front()),
               last = chart.x.empty() || chart.x.back() <= first ? first + 1 : chart.x.back();
  Plot plot({x_label, first, last}, axis_over(chart.y_label, all, chart.logarithmic), chart.title, wide_plot);
  for (const auto& [mark, shade] : {std::pair{Mark::rest, color::sky}, {Mark::dropped, color::vermilion}, {Mark::gap, color::ink}}) {
    std::vector<std::pair<double, double>> spans;
    for (const MarkedTime& m : chart.marks)
      if (m.mark == mark) spans.emplace_back(m.begin, m.end);
    plot.shade(spans, shade, mark == Mark::rest ? 0.16 : 0.3);
  }
  std::vector<std::pair<std::string, std::string_view>> names;
  for (std::size_t k = 0; k < chart.y.size(); ++k) {
    const auto [x, y] = thinned(chart.x, chart.y[k], parts);
    plot.line(x, y, colors[k], 1);
    names.emplace_back(chart.names[k], colors[k]);
  }
  return plot.svg() + (names.size() > 1 ? key(names) : "");
}

}  // namespace

std::string time_chart(const TimeChart& given) {
  const TimeChart chart = from_its_start(given);
  const std::string x_label = time_label(given.start, given.minutes ? "min" : "s");
  const std::vector<std::string> colors = colors_of(chart);
  std::string data =
      fmt::format("{{\"x\":{},\"y\":{},\"labels\":{},\"colors\":{},\"xlabel\":{},\"ylabel\":{},\"log\":{},\"group\":{},\"marks\":{}}}",
                  json_list(chart.x, json_time), json_list(chart.y, [](const std::vector<double>& series) { return json_list(series, json_number); }),
                  json_list(chart.names, json_string), json_list(colors, json_string), json_string(x_label), json_string(chart.y_label),
                  chart.logarithmic, json_string(chart.group), json_list(chart.marks, [](const MarkedTime& m) {
                    return fmt::format("[{},{},\"{}\"]", json_time(m.begin), json_time(m.end), name_of(m.mark));
                  }));
  return fmt::format(
      "<div class=\"chart\"><div class=\"title\">{}</div><div class=\"legend\"></div><div class=\"live\"></div><div class=\"still\">{}</div>"
      "<script type=\"application/json\">{}</script></div>\n",
      escaped(chart.title), still(chart, x_label, colors), data);
}

}  // namespace imulab::report
