// Pictures over temperature on a calibration's page.
#include "imulab/compensate.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"
#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A calibration of the bias and the linear thermal term of one accelerometer from -10 to 40 degC about 10 degC, SI readings or counts.
Calibration thermal_calibration(bool counts) {
  Calibration c;
  TriadModel& m = c.model.accel;
  m.raw_unit = counts ? "count" : "m/s^2", c.model.gyro.raw_unit = "rad/s";
  m.temperature = ThermalReading{.reference = 10, .range = {-10, 40}};
  m.offset = {-0.3, 0.1, 0.2};
  if (counts) m.matrix *= 0.5;
  m.thermal(0, 1) = 2e-3;
  c.estimated = select_each({"accel.offset.x", "accel.thermal.x1"});
  c.covariance.resize(2, 2);
  c.covariance << 9e-4, 3e-6, 3e-6, 4e-8;
  return c;
}

/// Curve, and half of its band, of the first figure with this name: at the ends and at the 20th of 60 steps. In parts of the picture.
std::vector<std::pair<double, double>> curve_in(const std::string& page, const std::string& section, const std::string& name) {
  const std::size_t from = page.find("<section id=\"" + section), end = page.find("<figcaption>" + name + "</figcaption>", from);
  const std::string figure = page.substr(page.rfind("<figure>", end), end - page.rfind("<figure>", end));
  const auto ys = [&](const char* element) {
    std::smatch m;
    EXPECT_TRUE(std::regex_search(figure, m, std::regex(std::string(element) + " points=\"([^\"]*)"))) << name;
    std::istringstream in(m[1]);
    std::vector<double> y;
    for (double a = 0, b = 0; in >> a && in.ignore() && in >> b;) y.push_back(b);
    return y;
  };
  const std::vector<double> line = ys("polyline"), band = ys("polygon");
  std::vector<std::pair<double, double>> out;
  for (const std::size_t k : {0, 24, 60}) out.emplace_back(line.at(k), 0.5 * (band.at(k) - band.at(band.size() - 1 - k)));
  return out;
}

TEST(CalibrationCurves, TheBandOfABiasOverTemperatureHasAllItsTerms) {
  for (const bool counts : {false, true}) {
    CalibrationReport report;
    report.result.calibration = thermal_calibration(counts);
    const std::string page = calibration_page(report);
    const auto at = curve_in(page, "thermal", "accelerometer x");
    const double scale = counts ? 2 : 1, c1 = 2e-3;  // counts at zero: 2 a count's 0.5 m/s^2
    const auto sigma = [&](double tau) { return std::sqrt(9e-4 * scale * scale - 2 * scale * tau * 3e-6 + 4e-8 * tau * tau); };
    const double unit = (at[0].first - at[2].first) / (50 * c1);  // pixels
    for (const auto& [k, tau] : {std::pair{0, -20.0}, {1, 0.0}, {2, 30.0}}) {
      EXPECT_NEAR(at[0].first - at[k].first, unit * c1 * (tau + 20), 0.2) << "pixels, as written to a tenth";
      EXPECT_NEAR(at[k].second, unit * 2 * sigma(tau), 0.2) << counts << ' ' << tau;
    }
    EXPECT_THAT(page, Not(HasSubstr("Dots:"))) << "no recording";
  }
}

TEST(CalibrationCurves, RestsOfASweepAreDotsAndBeforeAndAfter) {
  SimulatedSession s;
  s.session = warm_up_procedure({.minutes = 4}, 1);
  s.truth = draw_truth(s.session, 1);
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, 1);
  CalibrationReport report{.session = s.session};
  report.result.calibration = thermal_calibration(false);
  Calibration& c = report.result.calibration;
  report.recordings = {evidence_of(c, s.session, s.recording, 1)};
  EXPECT_GT(report.recordings[0].sweep.size(), 10u);
  const std::string page = calibration_page(report);
  for (const char* part : {"Dots:", "terms over temperature</span>", "with the values of the reference temperature alone"})
    EXPECT_THAT(page, HasSubstr(part));
  c.estimated = select_each({"accel.thermal.x1"}), c.covariance = Eigen::MatrixXd::Identity(1, 1);
  EXPECT_THAT(calibration_page(report), HasSubstr("accelerometer x, change")) << "the bias is not determined";
  c.model.accel.matrix.setZero();
  EXPECT_THAT(calibration_page(report), Not(HasSubstr("<figcaption>accelerometer x"))) << "no reading at zero input";
}

TEST(CalibrationCurves, RestsAreThoseOfTheCalibrationInEachRecording) {
  const SimulatedSession s = simulate_session(short_hand_held(), 1);
  Calibration c = thermal_calibration(false);
  c.model = {};
  for (const std::size_t k : {3, 5}) {
    const double begin = s.recording.time_s(s.rests[k].begin), end = s.recording.time_s(s.rests[k].end - 1);
    c.quality.rests.push_back({.begin_s = begin, .end_s = end, .recording = k == 3 ? s.recording.name : "other.csv"});
  }
  EXPECT_EQ(evidence_of(c, s.session, s.recording, 2).rests.size(), 1u);
}

}  // namespace
}  // namespace imulab
