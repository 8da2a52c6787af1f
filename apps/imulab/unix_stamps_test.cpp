// A log whose clock counts from 1970: every page that draws over time shows what happened, and when it began.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/recorded_session.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t begin_ns = 1'700'000'000'000'000'000;                 // 2023-11-14T22:13:20Z
constexpr const char* from_first_sample = " from 2023-11-14T22:13:20.010Z";  // the first sample

/// The recording's stamps as nanoseconds since 1970.
SessionText since_1970(SessionText text) {
  text.declare("time = { column = \"t\", unit = \"s\" }", "time = { column = \"t\", unit = \"ns\" }");
  for (std::size_t line = 2; line <= text.lines.size(); ++line) {
    const double s = std::stod(SessionText::fields(text.lines[line - 1])[0]);
    text.set(line, 0, fmt::format("{}", begin_ns + std::llround(1e9 * s)));
  }
  return text;
}

/// The charts of a page, as its scripts read them.
std::vector<nlohmann::json> charts_of(const std::string& page) {
  constexpr std::string_view opening = "<script type=\"application/json\">";
  std::vector<nlohmann::json> out;
  for (std::size_t at = page.find(opening); at != std::string::npos; at = page.find(opening, at + 1)) {
    const std::size_t from = at + opening.size();
    out.push_back(nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from)));
  }
  return out;
}

/// `count` charts that begin at 0 and have two points an interval or one a sample, in their order.
void expect_times(const TemporaryFolder& folder, const std::string& file, std::size_t count, const std::string& label) {
  const std::string page = read_text(folder / file);
  const std::vector<nlohmann::json> charts = charts_of(page);
  EXPECT_EQ(charts.size(), count) << file;
  for (const nlohmann::json& chart : charts) {
    EXPECT_EQ(chart["xlabel"], label) << file;
    const auto x = chart["x"].get<std::vector<double>>();
    ASSERT_GT(x.size(), 10u) << file;
    EXPECT_GE(x.front(), 0) << file;
    EXPECT_LT(x.front(), 0.1) << file << ": within the first interval";
    std::vector<double> different = x;
    different.erase(std::unique(different.begin(), different.end()), different.end());
    EXPECT_GE(2 * different.size(), x.size()) << file;
    for (const auto& mark : chart["marks"]) EXPECT_TRUE(mark[0] >= -1 && mark[1] <= x.back() + 1 && mark[0] < mark[1]) << file << mark;
  }
  EXPECT_EQ(page.find("·10⁹"), std::string::npos) << file << ": a tick";
  EXPECT_EQ(page.find("e+9"), std::string::npos) << file << ": a number";
}

TEST(UnixStamps, CalibrationInspectionAndCompensation) {
  const TemporaryFolder folder;
  since_1970(hand_held_session()).write(folder);
  for (const char* command : {"calibrate session --method handheld -o c.json --report calibration.html",
                              "inspect session/recording.csv --set latitude_deg=45 --set height_m=0 --report inspection.html",
                              "compensate c.json session -o out.csv --report compensation.html", "report c.json -o saved.html"})
    ASSERT_EQ(run_imulab(folder, command).exit_code, 0) << command;
  ASSERT_EQ(run_imulab(folder, "compensate c.json session -o out.csv --json > c.result.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "report c.result.json -o from_json.html").exit_code, 0);
  for (const char* page : {"calibration.html", "inspection.html", "compensation.html", "saved.html", "from_json.html"})
    expect_times(folder, page, 2, std::string("time [s]") + from_first_sample);
}

TEST(UnixStamps, Navigation) {
  const TemporaryFolder folder;
  SessionText text = since_1970(hand_held_session());
  text.session += R"([initial]
time_s = 1700000031.5
latitude_deg = 45
longitude_deg = 8
height_m = 0
velocity_enu_mps = [0, 0, 0]
roll_deg = 0
pitch_deg = 0
heading_deg = 90
)";
  text.write(folder);
  folder.write("truth.csv",
               "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n1700000000,45,8,0,0,0,0,0,0,90\n"
               "1700000200,45,8,0,0,0,0,0,0,90\n");
  ASSERT_EQ(run_imulab(folder, "calibrate session --method handheld -o c.json").exit_code, 0);
  const std::string navigate = "navigate c.json session --vertical fixed --truth truth.csv ";
  const CommandResult result = run_imulab(folder, navigate + "--report navigation.html");
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("times from 2023-11-14T22:13:"));
  EXPECT_THAT(result.output, testing::Not(HasSubstr("17000000"))) << "times count from the rest";
  ASSERT_EQ(run_imulab(folder, navigate + "--json > n.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "report n.json -o from_json.html").exit_code, 0);
  for (const char* file : {"navigation.html", "from_json.html"}) {
    expect_times(folder, file, 1, "time [min] from 2023-11-14T22:13:51.500Z");
    const std::string page = read_text(folder / file);
    const auto says = [&](const std::string& part) { return page.find(part) != std::string::npos; };  // a failure would print the page
    EXPECT_TRUE(says("Navigated 112.5 s from 2023-11-14T22:13:51.500Z, vertical")) << file;
    EXPECT_TRUE(says("error after 112.5 s")) << file;
    EXPECT_TRUE(says("Horizontal axes: time [min] from 2023-11-14T22:13:51.500Z.")) << file;
    EXPECT_TRUE(says(">1.5</text>")) << file << ": a tick of the bands";
  }
}

TEST(UnixStamps, Noise) {
  const TemporaryFolder folder;
  folder.write(
      "still.toml",
      "format = \"imulab.session/1\"\n[imu]\nname = \"still\"\ngrade = \"mems\"\nnoise = \"full\"\n[site]\nlatitude_deg = 47.0\nheight_m = 0\n"
      "[rig]\nkind = \"none\"\n[[step]]\nkind = \"hold\"\nduration_s = 60\n");
  ASSERT_EQ(run_imulab(folder, "simulate still.toml -o still").exit_code, 0);
  SessionText text{read_text(folder / "still/session.toml"), {}};
  std::istringstream rows(read_text(folder / "still/recording.csv"));
  for (std::string line; std::getline(rows, line);) text.lines.push_back(line);
  text = since_1970(text);
  text.write(folder);
  ASSERT_EQ(run_imulab(folder, "noise session --report noise.html").exit_code, 0);
  expect_times(folder, "noise.html", 2, std::string("time [s]") + from_first_sample);
  EXPECT_NE(read_text(folder / "noise.html").find("at rest: 0 to 60 s of the log, 6000 samples"), std::string::npos);
}

TEST(UnixStamps, MessagesNameTheSample) {
  const TemporaryFolder folder;
  SessionText text = since_1970(hand_held_session());
  text.session += "[[step]]\nkind = \"spin\"\nstart_s = 1700000010.5\nend_s = 1700000040\nrate_dps = 100\nup = \"+z\"\noutward = \"+x\"\n";
  text.write(folder);
  EXPECT_THAT(on_one_line(run_imulab(folder, "calibrate session --method handheld").errors),
              HasSubstr("a step of kind \"spin\" at 1700000010.5 s; expected rests"));
}

}  // namespace
}  // namespace imulab
