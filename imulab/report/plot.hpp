// Charts: static ones as SVG (axes, lines, bands, dots, bars), and curves over time, to zoom on a screen (dygraphs), still in print and without
// scripts.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::report {

/// Colors that people tell apart whatever their color vision (Okabe and Ito 2008), for axes x, y, z and more.
namespace color {
inline constexpr std::string_view blue = "#0072b2", vermilion = "#d55e00", green = "#009e73", orange = "#e69f00", sky = "#56b4e9", purple = "#cc79a7",
                                  gray = "#9aa1aa", ink = "#1d2733", grid = "#e3e6ea";
/// The color of the k-th series; colors repeat.
std::string_view series(std::size_t k);
}  // namespace color

struct Axis {
  std::string label;
  double low = 0, high = 1;
  bool logarithmic = false;
};
/// An axis with room around all finite values; a logarithmic one around the positive ones.
Axis axis_over(std::string label, const std::vector<double>& values, bool logarithmic = false);

/// Round values of an axis, a few or about `count`; at least two of them are not zero.
std::vector<double> ticks(const Axis& axis, int count = 5);

struct PlotSize {
  double width = 460, height = 250;
  double margin = 10;  ///< to the right of the axes: room for names on the curves
};
inline constexpr PlotSize wide_plot{960, 250};
inline constexpr PlotSize small_plot{240, 160};

enum class Anchor { start, middle, end };

/// One chart. Points that are not finite, or not on the axes, are left out.
class Plot {
 public:
  /// `description` is read out where the picture is not seen.
  Plot(Axis x, Axis y, std::string description, PlotSize size = {});

  void line(const std::vector<double>& x, const std::vector<double>& y, std::string_view color, double width = 1.5);
  void band(const std::vector<double>& x, const std::vector<double>& low, const std::vector<double>& high, std::string_view color);
  void dots(const std::vector<double>& x, const std::vector<double>& y, std::string_view color, bool hollow = false);
  void bars(const std::vector<double>& x, const std::vector<double>& y, double width, std::string_view color);
  void shade(const std::vector<std::pair<double, double>>& spans, std::string_view color, double opacity);  ///< between two x each
  void rule(double y, std::string_view color);                                                              ///< a dashed line across
  /// The name of a curve, on it; in front of all that is drawn.
  void name(double x, double y, std::string_view text, std::string_view color, Anchor anchor = Anchor::start);
  /// The name of a curve beside its end at `y`, in the margin; names that would collide move apart.
  void name_at_end(double y, std::string_view text, std::string_view color);
  void segment(double x1, double y1, double x2, double y2, std::string_view color, bool dashed = false);
  /// A label beside a point, moved by dx and dy in the picture's own units.
  void note(double x, double y, std::string_view text, Anchor anchor, double dx = 0, double dy = 0);
  std::string svg() const;

 private:
  struct EndName {
    double y;
    std::string text, color;
  };
  std::string end_names() const;

  double at_x(double value) const;
  double at_y(double value) const;
  std::string axes() const;
  std::vector<double> x_ticks() const;

  Axis x_, y_;
  std::string description_, marks_, names_;
  std::vector<EndName> end_names_;
  std::set<std::string> series_;  // their colors
  PlotSize size_;
  double left_, right_, top_, bottom_;
  bool small_;
};

/// A picture as a file of its own: with a background and a font.
std::string standalone(std::string svg);

/// Colored squares with names, above or below a picture.
std::string key(const std::vector<std::pair<std::string, std::string_view>>& entries);

/// An SVG of this size in its own units, scaled to the room it has.
std::string svg_text(double width, double height, std::string_view description, const std::string& content);
std::string line_between(double x1, double y1, double x2, double y2, std::string_view stroke, double width = 1, bool dashed = false);
std::string text_at(double x, double y, std::string_view text, Anchor anchor = Anchor::start, std::string_view attributes = "");

enum class Mark { rest, dropped, gap, withheld };
struct MarkedTime {
  double begin = 0, end = 0;
  Mark mark = Mark::rest;
};

/// Counts time from its start on; the label of the axis says when that was.
struct TimeChart {
  std::string title, y_label;
  double start = 0;                      ///< stamp of the recording's first sample [s]
  std::vector<double> x;                 ///< s of the same clock, as are the marks
  std::vector<std::string> names;        ///< of the series
  std::vector<std::vector<double>> y;    ///< each as long as x; what is not finite is a hole
  std::vector<std::string> colors = {};  ///< absent: those of series
  std::vector<MarkedTime> marks = {};
  std::string group = "time";  ///< charts of one group zoom together
  bool logarithmic = false;
  bool minutes = false;  ///< the axis has them, in place of seconds
};

/// HTML.
std::string time_chart(const TimeChart& chart);

}  // namespace imulab::report
