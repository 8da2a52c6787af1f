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

struct TimeChart {
  std::string title, x_label = "time [s]", y_label;
  std::vector<double> x;
  std::vector<std::string> names;        ///< of the series
  std::vector<std::vector<double>> y;    ///< each as long as x; what is not finite is a hole
  std::vector<std::string> colors = {};  ///< absent: those of series
  std::vector<MarkedTime> marks = {};
  std::string group = "time";  ///< charts of one group zoom together
  bool logarithmic = false;
};

/// HTML.
std::string time_chart(const TimeChart& chart);

}  // namespace imulab::report
