#include "imulab/report/drives_page.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace imulab {
namespace report {
namespace {

constexpr std::array drive_colors{color::vermilion, color::blue, color::green};

std::vector<double> medians(const DrivenCalibration& c, std::size_t times) {
  std::vector<double> out;
  for (std::size_t i = 0; i < times; ++i) {
    std::vector<double> at;
    for (const std::vector<double>& drive : c.errors) at.push_back(drive[i]);
    out.push_back(median(at) / 1000);
  }
  return out;
}

std::string drives_table(const DrivesReport& r) {
  Table t{.head = {"calibration", "largest error, median [m]", "least", "most", ""}, .rows = {}, .left = {4}};
  for (const DrivenCalibration& c : r.calibrations)
    t.rows.push_back(
        {escaped(c.name), number_text(median(c.largest), 2), number_text(c.largest.front(), 2), number_text(c.largest.back(), 2), escaped(c.claim)});
  return table(t);
}

}  // namespace
}  // namespace report

std::string drives_picture(const DrivesReport& r) {
  using namespace report;
  double most = 0, end = 0;
  for (const DrivenCalibration& c : r.calibrations)
    for (const std::vector<double>& drive : c.errors) most = std::max(most, *std::max_element(drive.begin(), drive.end()) / 1000);
  std::vector<double> minutes;
  for (const double t : r.time) minutes.push_back(t / 60);
  if (!minutes.empty()) end = minutes.back();
  Plot plot({"minutes of driving", 0, end}, {"horizontal error [km]", 0, 1.05 * most}, "Horizontal position error of each drive over time",
            {960, 380, 180});
  for (std::size_t k = 0; k < r.calibrations.size(); ++k)
    for (const std::vector<double>& drive : r.calibrations[k].errors) {
      std::vector<double> km(drive);
      for (double& error : km) error /= 1000;
      plot.line(minutes, km, drive_colors.at(k), 0.5);
    }
  for (std::size_t k = 0; k < r.calibrations.size(); ++k) {
    const std::vector<double> middle = medians(r.calibrations[k], minutes.size());
    plot.line(minutes, middle, drive_colors.at(k), 4);
    if (!middle.empty()) plot.name_at_end(middle.back(), r.calibrations[k].name, drive_colors.at(k));
  }
  return plot.svg();
}

std::string drives_page(const DrivesReport& r) {
  using namespace report;
  Page page;
  page.kind = "Demonstration";
  page.title = r.title;
  page.verdict = {.tone = Tone::neutral, .word = "", .meaning = r.story, .because = {}, .actions = r.next};
  for (const DrivenCalibration& c : r.calibrations) page.figures.push_back({number_text(median(c.largest), 2) + " m", c.name});
  page.verdict.word =
      fmt::format("{} m instead of {} m", number_text(median(r.calibrations[1].largest), 2), number_text(median(r.calibrations[0].largest), 2));
  const std::string caption =
      "Each thin line is a drive, each thick one the median of the drives with one calibration. The figures above are medians of each drive's "
      "largest error.";
  page.body = section("drives", "The drives", "", figure(drives_picture(r), caption, true) + drives_table(r));
  return page_text(page);
}

}  // namespace imulab
