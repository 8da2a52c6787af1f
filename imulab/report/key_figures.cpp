#include "imulab/report/key_figures.hpp"

#include "imulab/report/html.hpp"
#include "imulab/results/reached.hpp"

#include <utility>

namespace imulab::report {

std::vector<KeyFigure> key_figures(const std::function<double(CoefficientIndex)>& sigma) {
  std::vector<KeyFigure> out;
  for (const auto& [selector, name] : {std::pair{"accel.matrix.diagonal", "accelerometer scale"},
                                       {"accel.matrix.off_diagonal", "accelerometer misalignment"},
                                       {"accel.offset", "accelerometer offset"},
                                       {"gyro.matrix.diagonal", "gyro scale"},
                                       {"gyro.matrix.off_diagonal", "gyro misalignment"},
                                       {"gyro.offset", "gyro offset"}})
    if (const std::string worst = worst_text(selector, sigma); !worst.empty()) out.push_back({"± " + readable_unit(worst), name});
  return out;
}

std::string worst_axis_note(const std::vector<KeyFigure>& figures) {
  return figures.empty() ? "" : "<p class=\"note\">Standard uncertainty of the worst axis of each kind.</p>\n";
}

}  // namespace imulab::report
