// imulab navigate --aided: a flight whose truth, as a file of positions and velocities, is its own receiver.
#include "imulab/aid.hpp"
#include "imulab/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/flight_session.hpp"
#include "tests/run_command.hpp"
#include <fstream>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;

void write_aided(const TemporaryFolder& folder) {
  FlightSession f = flight_session(1);
  Aid receiver{.file = "truth.csv"};
  receiver.position_sigma = 1, receiver.velocity_sigma = 0.1;
  f.session.aids.push_back(receiver);
  write(folder, "session", f);
}

TEST(NavigateAidedCommand, SmoothsComparesAndWrites) {
  const TemporaryFolder folder;
  write_aided(folder);
  const CommandResult result = run_imulab(folder, "navigate none session --aided --outages 30,8 -o nav.csv --report page.html --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const Json json = Json::parse(result.output);
  EXPECT_EQ(json["verdict"], "good") << result.errors;
  ASSERT_EQ(json["outages"].size(), 2u);  // in the first, at rest, an exact truth repeats itself and is left out
  for (const Json& outage : json["outages"]) EXPECT_LT(outage["horizontal_error_m"].get<double>(), 0.5);  // 8 s with a receiver of millimeters around
  EXPECT_EQ(json["aids"][0]["kind"], "gnss");
  EXPECT_LT(json["aids"][0]["sigma_factor"].get<double>(), 0.2);  // the receiver is exact, and the stated 1 m is not
  EXPECT_THAT(read_text(folder / "nav.csv"), StartsWith("t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg,sigma_e_m,"));
  EXPECT_EQ(read_solution(folder / "nav.csv").size(), 5001u);  // 100 s at 50 Hz, and the start
  const std::string page = read_text(folder / "page.html");
  for (const char* name : {"result.json", "second.json"}) std::ofstream(folder / name) << result.output;
  ASSERT_EQ(run_imulab(folder, "report result.json -o again.html").exit_code, 0);
  EXPECT_THAT(run_imulab(folder, "compare result.json second.json").output, HasSubstr("withheld, predicted: median"));
  const std::string again = read_text(folder / "again.html");
  for (const char* part : {"Withheld times", "good", "Position, one sigma", "innovation over sigma", "gnss", "plain grid"}) {
    EXPECT_THAT(page, HasSubstr(part));
    EXPECT_THAT(again, HasSubstr(part));
  }
  // Titled by the session, and not by its path; withheld times are no gaps; constants in the units of the terminal.
  EXPECT_THAT(page, AllOf(HasSubstr("<h1>session</h1>"), HasSubstr("</i>aids withheld</span>"), Not(HasSubstr("</i>gap</span>"))));
  EXPECT_THAT(page, AllOf(HasSubstr("<th>accel.offset.x</th>"), HasSubstr("<td>mg</td>"), HasSubstr("<td>deg/h</td>"), Not(HasSubstr("(SI)"))));
  Json lasting = json;
  lasting["noise"]["gnss.velocity"]["lasting"] = 7.5;
  folder.write("lasting.json", lasting.dump());
  EXPECT_EQ(run_imulab(folder, "report lasting.json -o lasting.html").exit_code, 0);
  EXPECT_THAT(read_text(folder / "lasting.html"), HasSubstr("7.5"));
}

// A reason of the verdict is in the verdict, other warnings below it: nothing twice.
TEST(NavigateAidedCommand, ThePageSaysEachWarningOnce) {
  const TemporaryFolder folder;
  write_aided(folder);
  ASSERT_EQ(run_shell(folder, "sed -i 's/^kind = \"gnss\"/&\\nlever_arm_m = [30, 0, 0]\\nlever_arm_sigma_m = 0.1/' session/session.toml").exit_code,
            0);
  const CommandResult result = run_imulab(folder, "navigate none session --aided --report page.html --json");
  const Json json = Json::parse(result.output);
  ASSERT_EQ(json["verdict"], "doubtful") << result.output.substr(0, 300);
  const std::string page = read_text(folder / "page.html");
  const auto times = [&](const std::string& text) {
    std::size_t count = 0;
    for (std::size_t at = page.find(text); at != std::string::npos; at = page.find(text, at + 1)) ++count;
    return count;
  };
  std::size_t said = 0;
  for (const Json& warning : json["warnings"]) {
    std::string text = warning;
    if (text.find_first_of("\"'<>&") != std::string::npos) continue;  // is written otherwise in a page
    if (text.starts_with("recording.csv: ")) text.erase(0, 15);
    EXPECT_EQ(times(text), 1u) << text;
    ++said;
  }
  EXPECT_GE(said, 1u);
}

TEST(NavigateAidedCommand, OptionsThatDoNotGoTogetherAreRefused) {
  const TemporaryFolder folder;
  write_aided(folder);
  const auto refused = [&](const std::string& options, const std::string& why) {
    const CommandResult result = run_imulab(folder, "navigate none session " + options);
    EXPECT_EQ(result.exit_code, 2) << options;
    EXPECT_THAT(result.errors, HasSubstr(why)) << options;
  };
  refused("--filter", "belongs to --aided");
  refused("-o track.KML", "track.KML: belongs to --aided");
  refused("--aided -o track.foo", "--output: track.foo: expected a .csv file, or with --aided .geojson, .kml, .pos, .mcap");
  refused("--aided --vertical fixed", "does not go with --aided");
  refused("--aided --require 'horizontal <= 1 m'", "--require: does not go with --aided; expected --outages, or limits for what is predicted");
  refused("--aided --outages 10", "is no EVERY,LENGTH");
  refused("--aided --outages 10,20", "is no EVERY,LENGTH");
  refused("--aided -o track.pos", "-o: track.pos: has dates, in GPS time, and the recording's clock has none; expected time = { scale = \"gps\" }");
}

/// The flight by a clock of this scale that counts from `zero`, beside a receiver with the column `column` of that time plus `later`.
std::string first_date(const std::string& scale, double zero, const std::string& column, double later) {
  const TemporaryFolder folder;
  write_aided(folder);
  const CommandResult made = run_shell(folder, fmt::format(R"(cd session &&
awk -F, -v OFS=, -v by={0} 'NR > 1 {{$1 = sprintf("%.4f", $1 + by)}} 1' recording.csv > dated.csv && mv dated.csv recording.csv &&
awk -F, -v OFS=, -v by={1} 'NR == 1 {{sub("^t,", "{2},")}} NR > 1 {{$1 = sprintf("%.4f", $1 + by)}} 1' truth.csv > truth_dated.csv &&
sed -i -e 's/"truth.csv"/"truth_dated.csv"/' -e 's/^time = {{ column = "t"/&, scale = "{3}"/' -e '/^\[initial\]/,/^heading/d' session.toml)",
                                                           zero, zero + later, column, scale));
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  const CommandResult result = run_imulab(folder, "navigate none session --aided -o nav.pos");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const std::string text = read_text(folder / "nav.pos"), begin = "\n20";
  const std::size_t row = text.find(begin);
  return row == std::string::npos ? text.substr(0, 200) : text.substr(row + 1, 19);
}

// 2024-01-01 is day 16066 since 1980-01-06 and 19723 since 1970; GPS is 18 s ahead of UTC.
TEST(NavigateAidedCommand, APosFileHasTheDatesOfGpsTime) {  // ctest: once
  EXPECT_EQ(first_date("gps", 16066 * 86400., "gps_s", 0), "2024/01/01 00:00:00");
  EXPECT_EQ(first_date("utc", 19723 * 86400., "utc_s", 0), "2024/01/01 00:00:18");
  EXPECT_EQ(first_date("utc", 19723 * 86400., "gps_s", -3657 * 86400. + 18), "2024/01/01 00:00:18");
}

}  // namespace
}  // namespace imulab
