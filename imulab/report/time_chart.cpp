// Curves over time: their data for dygraphs, and the picture for print and for pages without scripts.
#include "imulab/formats/text/printable.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::report {

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
  return with_escapes(out) + "\"";
}

template <class Values, class Text>
std::string json_list(const Values& values, const Text& text) {
  std::string out = "[";
  for (const auto& v : values) out += (out.size() > 1 ? "," : "") + text(v);
  return out + "]";
}

std::string json_number(double v) { return std::isfinite(v) ? fmt::format("{:.5g}", v) : "null"; }
std::string json_time(double v) { return fmt::format("{:.9g}", v); }

struct DrawnMark {
  Mark mark;
  std::string_view id, name, shade;  // `id`: in page.js
};
constexpr std::array drawn_marks{DrawnMark{Mark::rest, "rest", "rest", color::sky},
                                 DrawnMark{Mark::dropped, "dropped", "dropped as an outlier", color::vermilion},
                                 DrawnMark{Mark::gap, "gap", "gap", color::ink}, DrawnMark{Mark::withheld, "withheld", "aids withheld", color::ink}};

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
  for (const DrawnMark& drawn : drawn_marks) {
    std::vector<std::pair<double, double>> spans;
    for (const MarkedTime& m : chart.marks)
      if (m.mark == drawn.mark) spans.emplace_back(m.begin, m.end);
    plot.shade(spans, drawn.shade, drawn.mark == Mark::rest ? 0.16 : 0.3);
  }
  std::vector<std::pair<std::string, std::string_view>> names;
  for (std::size_t k = 0; k < chart.y.size(); ++k) {
    const auto [x, y] = thinned(chart.x, chart.y[k], parts);
    plot.line(x, y, colors[k], 1);
    names.emplace_back(chart.names[k], colors[k]);
  }
  return plot.svg() + (names.size() > 1 ? key(names) : "");
}

/// What is shaded.
std::string mark_key(const TimeChart& chart) {
  std::string out;
  for (const DrawnMark& drawn : drawn_marks)
    if (std::ranges::find(chart.marks, drawn.mark, &MarkedTime::mark) != chart.marks.end())
      out += fmt::format("<span class=\"key\"><i class=\"shade\" style=\"background:{}\"></i>{}</span>", drawn.shade, drawn.name);
  return out.empty() ? out : "<div class=\"keys\">" + out + "</div>";
}

}  // namespace

std::string time_chart(const TimeChart& given) {
  const TimeChart chart = from_its_start(given);
  const std::string x_label = time_label(given.start, given.minutes ? "min" : "s");
  const std::vector<std::string> colors = colors_of(chart);
  std::string data = fmt::format(
      "{{\"x\":{},\"y\":{},\"labels\":{},\"colors\":{},\"xlabel\":{},\"ylabel\":{},\"log\":{},\"group\":{},\"marks\":{}}}",
      json_list(chart.x, json_time), json_list(chart.y, [](const std::vector<double>& series) { return json_list(series, json_number); }),
      json_list(chart.names, json_string), json_list(colors, json_string), json_string(x_label), json_string(chart.y_label), chart.logarithmic,
      json_string(chart.group), json_list(chart.marks, [](const MarkedTime& m) {
        return fmt::format("[{},{},\"{}\"]", json_time(m.begin), json_time(m.end), std::ranges::find(drawn_marks, m.mark, &DrawnMark::mark)->id);
      }));
  return fmt::format(
      "<div class=\"chart\"><div class=\"title\">{}</div><div class=\"legend\"></div><div class=\"live\"></div><div class=\"still\">{}</div>{}"
      "<script type=\"application/json\">{}</script></div>\n",
      escaped(chart.title), still(chart, x_label, colors), mark_key(chart), data);
}

}  // namespace imulab::report
