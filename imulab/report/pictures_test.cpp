#include "imulab/report/pictures.hpp"

#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <regex>

namespace imulab::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(Pictures, AWhiskerIsAsLongAsItsInterval) {
  const std::string svg = interval_rows({{"x", 10, 5}, {"y", 10, 0}}, "ppm", "test");
  std::smatch m;
  ASSERT_TRUE(std::regex_search(svg, m, std::regex("x1=\"([0-9.]+)\" y1=\"17.0\" x2=\"([0-9.]+)\" y2=\"17.0\"")));
  const double length = std::stod(m[2]) - std::stod(m[1]);
  EXPECT_NEAR(length, (320 - 44) * 10 / (15 * 1.1), 0.2);  // 0 to 15 and a twentieth on both sides
  EXPECT_EQ(count(svg, "<circle"), 2u);
}

TEST(Pictures, NothingIsDrawnOfWhatIsNotFinite) {
  for (const std::string& svg : {interval_rows({{"x", NAN, NAN}, {"y", 1, INFINITY}}, "", ""), share_bars({{"x", "", "", {{0, NAN, "a"}}}}, ""),
                                 correlation_map({"a", "b"}, Eigen::MatrixXd::Constant(2, 2, NAN), "")})
    EXPECT_THAT(svg, Not(testing::AnyOf(HasSubstr("nan"), HasSubstr("inf"))));
}

TEST(Pictures, SharesFillTheirBarAndNegativeOnesLieBeforeIt) {
  const std::string svg = share_bars({{"row", "1 ppm", "a 75 %", {{0, 0.75, "a"}, {1, 0.5, "b"}, {2, -0.25, "c"}}}}, "test");
  EXPECT_THAT(svg, HasSubstr("<title>a: 75.0 %</title>"));
  EXPECT_THAT(svg, HasSubstr("<title>c: -25.0 %</title>"));
  EXPECT_THAT(svg, HasSubstr("x=\"162.0\" y=\"7.0\" width=\"55.3\"")) << "a sixth of the width, left of zero";
}

TEST(Pictures, StrongCorrelationsHaveStrongColors) {
  Eigen::Matrix3d r;
  r << 1, 1, -1, 1, 1, 0.01, -1, 0.01, 1;
  const std::string svg = correlation_map({"a", "b", "c"}, r, "test");
  EXPECT_THAT(svg, HasSubstr("fill=\"#0072b2\"><title>b and a: 1.00</title>"));
  EXPECT_THAT(svg, HasSubstr("fill=\"#d55e00\"><title>c and a: -1.00</title>"));
  EXPECT_THAT(svg, Not(HasSubstr("c and b"))) << "too weak to be shown";
}

TEST(Pictures, DirectionsAreOnTheirHalfOfTheSphere) {
  const auto place = [](const Vector3d& up) {
    const std::string svg = sphere({{up}}, "test");
    std::smatch m;
    EXPECT_TRUE(std::regex_search(svg, m, std::regex("M([0-9.]+) ([0-9.]+)h0")));
    return Vector3d(std::stod(m[1]), std::stod(m[2]), 0);
  };
  EXPECT_NEAR(place({0, 0, 9.8}).x(), 115, 0.1);   // the center of the left half
  EXPECT_NEAR(place({0, 0, -9.8}).x(), 345, 0.1);  // and of the right one
  EXPECT_GT(place({5, 0, 8}).x(), 115);            // +x to the right, seen from above
  EXPECT_LT(place({5, 0, -8}).x(), 345);           // and to the left, seen from below
  EXPECT_LT(place({0, 5, 8}).y(), 112);            // +y upward
}

TEST(TimeChart, ItsDataCannotEndTheScript) {
  const std::string html =
      time_chart({.title = "</script>", .y_label = "</script>", .x = {0, 1}, .names = {"</script><b>"}, .y = {{1, NAN}}, .group = "a\"\n"});
  EXPECT_EQ(count(html, "</script>"), 1u);
  EXPECT_THAT(html, HasSubstr("\\u003c/script\\u003e\\u003cb\\u003e"));
  EXPECT_THAT(html, HasSubstr("[1,null]"));
  EXPECT_THAT(html, HasSubstr("a\\u0022\\u000a"));
}

TEST(TimeChart, TheStillPictureOfManyPointsIsSmall) {
  TimeChart chart{.title = "t", .y_label = "y", .x = {}, .names = {"a"}, .y = {{}}};
  for (int i = 0; i < 100'000; ++i) {
    chart.x.push_back(i);
    chart.y[0].push_back(i == 54'321 ? 1000 : 0);
  }
  const std::string html = time_chart(chart), still = html.substr(0, html.find("<script"));
  EXPECT_LT(still.size(), 30'000u);
  EXPECT_THAT(still, HasSubstr("1000")) << "the spike is on the axis";
}

TEST(TimeChart, CountsFromItsStartAndSaysWhenThatWas) {
  const auto chart = [](double first) {
    return time_chart({.title = "t",
                       .y_label = "y",
                       .start = first,
                       .x = {first + 0.25, first + 0.5, first + 60},
                       .names = {"a"},
                       .y = {{1, 2, 3}},
                       .marks = {{first + 10, first + 20, Mark::rest}}});
  };
  for (const auto& [first, label] : {std::pair{1700000000.01, "time [s] from 2023-11-14T22:13:20.010Z"},
                                     {946684800.0, "time [s] from 2000-01-01T00:00:00Z"},
                                     {946684799.0, "time [s] from the start, at 946684799 s"},  // counts from something else
                                     {5012.5, "time [s] from the start, at 5012.5 s"},
                                     {-3.0, "time [s] from the start, at -3 s"},
                                     {0.0, "time [s]"}}) {
    const std::string html = chart(first);
    EXPECT_THAT(html, HasSubstr("\"x\":[0.25,0.5,60]"));
    EXPECT_THAT(html, HasSubstr("[10,20,\"rest\"]"));
    EXPECT_THAT(html, HasSubstr("\"xlabel\":\"" + std::string(label) + "\""));
    EXPECT_THAT(html, HasSubstr(">" + std::string(label) + "</text>"));
    EXPECT_THAT(html, HasSubstr(">30</text>")) << "a tick of the picture without scripts";
  }
}

TEST(TimeChart, MayHaveMinutes) {
  const std::string html =
      time_chart({.title = "t", .y_label = "y", .start = 1.7e9, .x = {1.7e9, 1.7e9 + 90}, .names = {"a"}, .y = {{1, 2}}, .minutes = true});
  EXPECT_THAT(html, HasSubstr("\"x\":[0,1.5]"));
  EXPECT_THAT(html, HasSubstr("\"xlabel\":\"time [min] from 2023-11-14T22:13:20Z\""));
}

TEST(Convergence, IsDrawnFromTheRecordingsFirstStamp) {
  const auto section_of = [](double first) {
    CalibrationResult result;
    result.calibration.sources = {{.file = "r.csv", .first_s = first}};
    ConvergenceCurve curve{.name = "gyro.offset.x", .residual = {}, .sigma = {}};
    for (int i = 1; i <= 100; ++i) {
      result.curve_time.push_back(first + 6 * i);
      curve.residual.push_back(1e-6 / i), curve.sigma.push_back(1e-6 / i);
    }
    result.curves = {curve};
    return convergence_section(result);
  };
  EXPECT_EQ(section_of(1.7e9), section_of(0)) << "whatever the clock counts from";
  EXPECT_THAT(section_of(1.7e9), HasSubstr(">7.5</text>")) << "ten minutes";
}

}  // namespace
}  // namespace imulab::report
