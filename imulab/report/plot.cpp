#include "imulab/report/plot.hpp"

#include "imulab/report/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
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

namespace {

std::vector<double> decade_ticks(const Axis& axis, int count) {
  const int step = std::max(1, static_cast<int>(std::ceil(std::log10(axis.high / axis.low) / (count + 1))));
  std::vector<double> out;
  const auto add = [&](double v) {
    if (v >= axis.low * (1 - 1e-9) && v <= axis.high * (1 + 1e-9)) out.push_back(v);
  };
  const int first = static_cast<int>(std::floor(std::log10(axis.low) + 1e-9)), last = static_cast<int>(std::floor(std::log10(axis.high) + 1e-9));
  for (int k = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)); k <= last; k += step) add(std::pow(10, k));
  if (out.size() > 2) return out;
  out.clear();
  for (int k = first; k <= last; ++k)
    for (const double digit : {1, 2, 5}) add(digit * std::pow(10, k));
  return out;
}

std::vector<double> even_ticks(const Axis& axis, int count) {
  std::vector<double> out;
  const double wanted = (axis.high - axis.low) / count, unit = std::pow(10, std::floor(std::log10(wanted)));
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

}  // namespace

std::vector<double> ticks(const Axis& axis, int count) {
  if (axis.logarithmic) return decade_ticks(axis, std::max(1, count));
  constexpr int most = 12;
  std::vector<double> out;
  for (int n = std::max(1, count); n <= std::max(count, most); ++n) {
    out = even_ticks(axis, n);
    if (std::count_if(out.begin(), out.end(), [](double v) { return v != 0; }) >= 2) break;
  }
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
  std::string out = "<div class=\"keys\">";
  for (const auto& [name, fill] : entries) out += fmt::format("<span class=\"key\"><i style=\"background:{}\"></i>{}</span>", fill, escaped(name));
  return out + "</div>";
}

namespace {

constexpr double character = 7;  // the width of one, about

/// Characters, not bytes.
double length_of(const std::string& text) {
  return static_cast<double>(std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80; }));
}

}  // namespace

std::string standalone(std::string svg) {
  const std::size_t end = svg.find('>');
  svg.insert(end, " font-family=\"system-ui,Segoe UI,Roboto,DejaVu Sans,Arial,sans-serif\" font-size=\"13\"");
  return svg.insert(svg.find('>') + 1, "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
}

Plot::Plot(Axis x, Axis y, std::string description, PlotSize size)
    : x_(std::move(x)), y_(std::move(y)), description_(std::move(description)), size_(size), small_(size.width < 300) {
  double longest = 0;
  const std::vector<double> values = ticks(y_, small_ ? 3 : 5);
  for (const double v : values) longest = std::max(longest, character * length_of(tick_text(v, are_raised(values))));
  left_ = small_ ? std::max(44.0, longest + 10) : std::max(64.0, longest + 32);
  right_ = size.width - size.margin, top_ = small_ ? 24 : 8, bottom_ = size.height - (small_ ? 36 : 42);
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
  if (!x.empty()) series_.emplace(color);
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
  if (!x.empty()) series_.emplace(color);
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
  if (!x.empty()) series_.emplace(color);
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
  if (!x.empty()) series_.emplace(color);
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

void Plot::segment(double x1, double y1, double x2, double y2, std::string_view color, bool dashed) {
  marks_ += line_between(at_x(x1), at_y(y1), at_x(x2), at_y(y2), color, 1.2, dashed);
}

void Plot::note(double x, double y, std::string_view text, Anchor anchor, double dx, double dy) {
  marks_ += text_at(at_x(x) + dx, at_y(y) + dy, text, anchor);
}

namespace {

/// Text on curves: bold, with a rim of the page's color.
std::string name_at(double x, double y, std::string_view text, std::string_view color, Anchor anchor) {
  return text_at(x, y + 4, text, anchor,
                 fmt::format("class=\"on\" fill=\"{}\" font-weight=\"650\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"", color));
}

}  // namespace

void Plot::name(double x, double y, std::string_view text, std::string_view color, Anchor anchor) {
  names_ += name_at(at_x(x), at_y(y), text, color, anchor);
}

void Plot::name_at_end(double y, std::string_view text, std::string_view color) {
  if (const double at = at_y(y); std::isfinite(at)) end_names_.push_back({at, std::string(text), std::string(color)});
}

std::string Plot::end_names() const {
  constexpr double apart = 17;
  std::vector<EndName> all = end_names_;
  std::stable_sort(all.begin(), all.end(), [](const EndName& a, const EndName& b) { return a.y < b.y; });
  for (std::size_t k = 1; k < all.size(); ++k) all[k].y = std::max(all[k].y, all[k - 1].y + apart);
  double lowest = bottom_ - 2;
  for (std::size_t k = all.size(); k-- > 0; lowest = all[k].y - apart) all[k].y = std::min(all[k].y, lowest);
  std::string out;
  for (const EndName& name : all) out += name_at(right_ + 8, name.y, name.text, name.color, Anchor::start);
  return out;
}

/// As many as fit beside each other.
std::vector<double> Plot::x_ticks() const {
  for (int count = small_ ? 4 : size_.width > 600 ? 10 : 6;; --count) {
    std::vector<double> out = ticks(x_, count);
    double end = -1e9;
    bool fits = true;
    for (const double v : out) {
      const double half = 0.5 * character * length_of(tick_text(v, are_raised(out)));
      fits = fits && at_x(v) - half > end;
      end = at_x(v) + half + 4;
    }
    if (fits || count <= 1) return out;
  }
}

std::string Plot::axes() const {
  std::string out = "<g class=\"yticks\">";
  const std::vector<double> beside = ticks(y_, small_ ? 3 : 5), below = x_ticks();
  for (const double v : beside) {
    const double y = at_y(v);
    out += line_between(left_, y, right_, y, color::grid);
    out += text_at(left_ - 6, y + 4, tick_text(v, are_raised(beside)), Anchor::end);
  }
  out += "</g><g class=\"xticks\">";
  for (const double v : below) {
    const std::string text = tick_text(v, are_raised(below));
    const double x = at_x(v), half = 0.5 * character * length_of(text);
    out += line_between(x, bottom_, x, bottom_ + 4, color::gray);
    out += text_at(std::min(x, size_.width - half), bottom_ + 18, text, Anchor::middle);
  }
  out += "</g>" + line_between(left_, bottom_, right_, bottom_, color::gray);
  if (!x_.label.empty()) out += text_at(0.5 * (left_ + right_), size_.height - 4, x_.label, Anchor::middle, "class=\"x\"");
  if (small_) return out + text_at(2, 13, y_.label, Anchor::start, "class=\"y\"");
  const double middle = 0.5 * (top_ + bottom_);
  return out + text_at(13, middle, y_.label, Anchor::middle, fmt::format("class=\"y\" transform=\"rotate(-90 13 {:.1f})\"", middle));
}

std::string Plot::svg() const {
  std::string out = svg_text(size_.width, size_.height, description_, axes() + marks_ + names_ + end_names());
  return out.insert(4, fmt::format(" class=\"plot\" data-series=\"{}\"", series_.size()));
}

}  // namespace imulab::report
