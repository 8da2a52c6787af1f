#include "imulab/results/live.hpp"

#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <regex>
#include <sstream>

namespace imulab {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::Not;

HandTurn turn(const Vector3d& axis, double deg, const Vector3d& up) { return {axis.normalized(), up.normalized(), deg * unit::deg}; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

LiveView full_view() {
  LiveView view;
  view.imu = "a unit whose name is longer than there is room for in a line";
  view.time_s = 12345.6, view.samples = 123456789, view.resting_s = 1.2;
  for (int k = 0; k < 60; ++k) view.up.push_back(Vector3d(std::cos(k), std::sin(k), std::cos(3 * k)).normalized());
  view.turned_deg = {12345, 6789, 0};
  for (const char* text : {"gyro.matrix.off_diagonal <= 60 arcsec", "accel.matrix.off_diagonal <= 60 arcsec", "gyro.matrix.diagonal <= 500 ppm",
                           "accel.offset <= 100 ug", "gyro.offset <= 1 deg/h", "gyro.g_sensitivity <= 1 deg/h/g", "gyro.matrix.xx <= 3 ppm"}) {
    const Requirement r = parse_requirements(text).front();
    view.requirements.push_back(
        {text, "gyro.matrix.xx", r.limit, view.requirements.size() % 2 ? r.limit / 2 : INFINITY, view.requirements.size() % 2 == 1});
  }
  view.problem = std::string(200, 'p');
  view.next = turn({1, -1, 1}, 270, {-1, -1, -1});
  return view;
}

TEST(LivePicture, FitsIntoEightyColumnsAndTwentyFourLines) {
  for (const bool color : {false, true})
    for (LiveView view : {full_view(), LiveView{}}) {
      for (const bool done : {false, true}) {
        view.done = done;
        const std::string text = std::regex_replace(live_picture(view, color), std::regex("\033\\[[0-9;]*m"), "");
        EXPECT_THAT(text, Not(HasSubstr("\033")));
        const std::vector<std::string> lines = lines_of(text);
        EXPECT_LE(lines.size(), 23u);
        for (const std::string& line : lines) EXPECT_LE(line.size(), 79u) << line;
      }
    }
  EXPECT_THAT(live_picture(full_view(), false), Not(HasSubstr("\033")));
  EXPECT_THAT(live_picture(full_view(), true), HasSubstr("\033["));
}

TEST(LivePicture, ANameDoesNotSteerTheTerminal) {
  LiveView view;
  view.imu = "x\x1b[31m", view.problem = "y\x1b[2J\nz";
  const std::string picture = live_picture(view, false);
  EXPECT_EQ(picture.find('\x1b'), std::string::npos);
  EXPECT_THAT(picture, testing::HasSubstr("x\\x1b[31m: calibration by hand"));
  EXPECT_THAT(picture, testing::HasSubstr("y\\x1b[2J\\x0az"));
}

TEST(LivePicture, ShowsWhatWasUpAndWhatIsNext) {
  LiveView view;
  view.resting_s = 5;
  view.up = {Vector3d::UnitZ(), Vector3d(0.6, 0, 0.8), Vector3d(0, -0.6, -0.8)};
  view.now = view.up.back();
  view.next = turn({1, 0, 0}, 90, {0, 0.6, -0.8});
  const std::vector<std::string> lines = lines_of(live_picture(view, false));
  // Columns 1 to 23 are the half around +z, 26 to 48 that around -z; rows 3 to 13 from +y to -y.
  EXPECT_EQ(lines[8].substr(1 + 11, 1), "o");
  EXPECT_EQ(lines[8].substr(1 + 11 + 5, 1), "o");  // 37 deg of 90 toward +x
  EXPECT_EQ(lines[10].substr(26 + 11, 1), "@");    // and toward -y
  EXPECT_EQ(lines[6].substr(26 + 11, 1), "X");
}

TEST(LivePicture, TurnsInWords) {
  EXPECT_EQ(turn_text(turn({0, -1, 0}, 90, {1, 0, 0})), "turn by 90 deg about -y until +x points up");
  EXPECT_EQ(turn_text(turn({1, 0, 1}, 180, {0, -1, 1})), "turn by 180 deg about +x+z until the edge -y+z points up");
  EXPECT_EQ(direction_text(Vector3d(0.5, -0.6, 0.62)), "the corner +x-y+z");
  EXPECT_EQ(turns_text({turn({0, 0, 1}, 90, {1, 0, 0}), turn({0, 0, 1}, 90, {0, 1, 0})}),
            "turn by 90 deg about +z until +x points up, hold still; turn by 90 deg about +z until +y points up, hold still");
}

}  // namespace
}  // namespace imulab
