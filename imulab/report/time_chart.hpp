// Curves over time: to zoom on a screen (dygraphs), still in print and without scripts.
#pragma once

#include <string>
#include <vector>

namespace imulab::report {

enum class Mark { rest, dropped, gap };
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
