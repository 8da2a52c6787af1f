#include "imulab/formats/recording/reader.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/recording_text.hpp"
#include <bit>
#include <string>

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(RecordingFile, ReadsAnyLayoutAlike) {
  const auto replaced = [](std::string text, char from, const std::string& to) {
    std::string result;
    for (const char c : text) result += c == from ? to : std::string(1, c);
    return result;
  };
  const std::string csv = header + two_rows;
  const struct {
    const char* layout;
    std::string text;
  } cases[] = {
      {"comma", csv},
      {"semicolon", replaced(csv, ',', ";")},
      {"tab", replaced(csv, ',', "\t")},
      {"blanks", replaced(csv, ',', "  ")},
      {"leading and trailing blanks", "   " + replaced(replaced(csv, ',', " "), '\n', " \n  ")},
      {"blanks around commas", replaced(csv, ',', " , ")},
      {"CRLF", replaced(csv, '\n', "\r\n")},
      {"no final newline", csv.substr(0, csv.size() - 1)},
      {"byte order mark", "\xEF\xBB\xBF" + csv},
      {"comments and empty lines", "# one\n\n" + header + "# two\n0.01,1,2,3,4,5,6\n \n  # three\n0.02,7,8,9,10,11,12\n#four"},
      {"header in a comment", "# made by a logger\n#" + csv},
      {"quoted header", "\"t\",\"gx\",\"gy\",\"gz\",\"ax\",\"ay\",\"az\"\n" + two_rows},
      {"other columns, other order", "name,az,ay,ax,gz,gy,gx,t\nfirst,6,5,4,3,2,1,.01\n,12,11,10,9,8,7,2e-2\n"},
      {"signs and exponents", header + "+0.01,+1,2.0,3e0,4.,0.5e1,60e-1\n0.02,7,8,9,10,11,12\n"},
  };
  for (const auto& c : cases) {
    const auto [r, warnings] = parse_recording(c.text);
    EXPECT_THAT(r.time_ns, ElementsAre(10'000'000, 20'000'000)) << c.layout;
    EXPECT_THAT(r.gyro, ElementsAre(ElementsAre(1, 7), ElementsAre(2, 8), ElementsAre(3, 9))) << c.layout;
    EXPECT_THAT(r.accel, ElementsAre(ElementsAre(4, 10), ElementsAre(5, 11), ElementsAre(6, 12))) << c.layout;
    EXPECT_THAT(warnings, IsEmpty()) << c.layout;
    EXPECT_DOUBLE_EQ(r.interval_s, 0.01) << c.layout;
  }
}

TEST(RecordingFile, FindsColumnsByNumberWithAndWithoutHeader) {
  RecordingSource source = plain_source();
  source.time.column = 1;
  source.gyro.columns = {2, 3, 4};
  source.accel.columns = {5, 6, 7};
  EXPECT_EQ(parse_recording(two_rows, source).recording.gyro, parse_recording(header + two_rows, source).recording.gyro);
  EXPECT_EQ(parse_recording(two_rows, source).recording.size(), 2U);
}

TEST(RecordingFile, ConvertsToSi) {
  RecordingSource source = plain_source();
  source.rate_hz = 100;
  const struct {
    std::string gyro_unit, accel_unit;
    Output output;
    double gyro, accel;  // what 1 becomes
  } cases[] = {
      {"count", "count", Output::rate, 1, 1},
      {"rad/s", "m/s^2", Output::rate, 1, 1},
      {"deg/s", "g", Output::rate, unit::deg, unit::g},
      {"deg/h", "g", Output::rate, unit::deg / 3600, 9.80665},
      {"count", "count", Output::increment, 100, 100},
      {"rad", "m/s", Output::increment, 100, 100},
      {"deg", "m/s", Output::increment, 100 * unit::deg, 100},
  };
  for (const auto& c : cases) {
    source.gyro.unit = c.gyro_unit, source.accel.unit = c.accel_unit;
    source.gyro.output = source.accel.output = c.output;
    const Recording r = parse_recording(header + "0.01,1,1,1,1,1,1\n0.0201,1,1,1,1,1,1\n", source).recording;
    for (std::size_t i = 0; i < 2; ++i) {  // also where the stamp jitters: the nominal interval divides
      EXPECT_DOUBLE_EQ(r.gyro[2][i], c.gyro) << c.gyro_unit;
      EXPECT_DOUBLE_EQ(r.accel[0][i], c.accel) << c.accel_unit;
    }
    EXPECT_EQ(r.gyro_unit, c.gyro_unit == "count" ? "count" : "rad/s");
    EXPECT_EQ(r.accel_unit, c.accel_unit == "count" ? "count" : "m/s^2");
    EXPECT_EQ(r.gyro_increment, c.output == Output::increment);
  }
}

TEST(RecordingFile, KeepsThermalReadings) {
  RecordingSource source = plain_source();
  source.gyro_temperature.emplace().columns = {"tg"};
  source.gyro_temperature->unit = "K";
  source.accel_temperature.emplace().columns = {"tg", "t2", "t3"};
  source.accel_temperature->unit = "raw";
  const Recording r =
      parse_recording("t,gx,gy,gz,ax,ay,az,tg,t2,t3\n0,1,2,3,4,5,6,300.5,5001,5002\n1,1,2,3,4,5,6,301.5,5003,5004\n", source).recording;
  EXPECT_THAT(r.gyro_temperature, ElementsAre(ElementsAre(300.5, 301.5), ElementsAre(300.5, 301.5), ElementsAre(300.5, 301.5)));
  EXPECT_THAT(r.accel_temperature, ElementsAre(ElementsAre(300.5, 301.5), ElementsAre(5001, 5003), ElementsAre(5002, 5004)));
}

TEST(RecordingFile, KeepsEveryNanosecondOfUnixStamps) {
  RecordingSource source = plain_source();
  const struct {
    std::string unit, first, second;
  } cases[] = {
      {"ns", "1700000000123456789", "1700000000133456790"},
      {"us", "1700000000123456.789", "1700000000133456.790"},
      {"ms", "1700000000123.456789", "1.70000000013345679e12"},
      {"s", "1700000000.123456789", "1700000000.13345679"},
  };
  for (const auto& c : cases) {
    source.time.unit = c.unit;
    source.time.zero = 1'700'000'000'000'000'000;
    EXPECT_THAT(parse_recording(rows_at({c.first, c.second}), source).recording.time_ns, ElementsAre(123'456'789, 133'456'790)) << c.unit;
  }
}

TEST(RecordingFile, TakesTheDeclaredRateOrTheMedian) {
  RecordingSource source = plain_source();
  const std::string text = rows_at({"0", "0.009", "0.020", "0.030", "0.5"});
  EXPECT_DOUBLE_EQ(parse_recording(text).recording.interval_s, 0.0105);
  source.rate_hz = 95;
  EXPECT_DOUBLE_EQ(parse_recording(text, source).recording.interval_s, 1.0 / 95);
  source.rate_hz = 100;  // 1.9 % off
  EXPECT_DOUBLE_EQ(parse_recording(rows_at({"0", "0.01019", "0.02038"}), source).recording.interval_s, 0.01);
  const std::string coarse = rows_at({"0", "0.002", "0.005", "0.007", "0.010", "0.012"});  // 400 Hz in whole milliseconds: median 2, mean 2.4
  EXPECT_THAT(parse_recording(coarse).warnings, ElementsAre(HasSubstr("uneven (median 0.002 s, mean 0.0024 s)")));
  source.rate_hz = 1 / 0.0024;
  EXPECT_DOUBLE_EQ(parse_recording(coarse, source).recording.interval_s, 0.0024);
  EXPECT_THAT(parse_recording(coarse, source).warnings, IsEmpty());
}

TEST(RecordingFile, ListsGaps) {
  const auto [r, warnings] = parse_recording(rows_at({"0", "0.01", "0.02", "0.0351", "0.0451", "0.0551", "0.25", "0.26", "0.27"}));
  EXPECT_THAT(r.gaps, ElementsAre(3, 6));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("r.csv: 2 gaps in time (more than 1.5 of the nominal 0.01 s), the largest of 0.1949 s before 0.25 s "
                                              "(line 8)")));
  EXPECT_THAT(parse_recording(rows_at({"0", "0.01", "0.0249", "0.0349"})).recording.gaps, IsEmpty());                       // 1.49 intervals
  EXPECT_THAT(parse_recording(rows_at({"0", "0.01", "0.02", "0.037", "0.04", "0.05", "0.06"})).recording.gaps, IsEmpty());  // a late stamp
  EXPECT_THAT(parse_recording(rows_at({"0", "0.01", "0.02", "0.04", "0.05", "0.06"})).recording.gaps, ElementsAre(3));      // a lost row
}

TEST(RecordingFile, StampsThatAllScatterAreNoGaps) {
  // Late by 0 .. 6 ms of 10: dozens of differences are beyond 1.5 intervals. The clock is off by 7 % of an interval in sixteen rows. One row is lost.
  RecordingSource source = plain_source();
  source.rate_hz = 100;
  std::vector<std::string> times;
  const RandomStream draws(5, "late stamps");
  for (int i = 0; i < 2000; ++i)
    if (i != 1200) times.push_back(fmt::format("{:.6f}", 0.010045 * i + 0.006 * draws.uniform(static_cast<std::uint64_t>(i))));
  EXPECT_THAT(parse_recording(rows_at(times), source).recording.gaps, ElementsAre(1200));
}

TEST(RecordingFile, ListsSaturatedSamples) {
  RecordingSource source = plain_source();
  source.gyro.unit = "deg/s";
  source.gyro.limits = {-100, 100};  // in the file's unit
  source.accel.limits = {-8, 8};
  const auto [r, warnings] =
      parse_recording(header + "0.01,1,2,3,4,5,6\n# x\n0.02,1,2,100,4,5,6\n0.03,-99.9,2,3,4,5,7.9\n0.04,1,-101,3,4,5,9\n", source);
  EXPECT_THAT(r.saturated, ElementsAre(1, 3));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("r.csv: 2 samples at a limit, the first at 0.02 s (line 4)")));
}

TEST(RecordingFile, DropsRepeatedRows) {
  const auto [r, warnings] =
      parse_recording(header + "0.01,1,2,3,4,5,6\n0.01,1,2,3,4,5,6\n0.02,1,2,3,4,5,6\n0.020,1.0,2,3,4,5,6\n0.03,1,2,3,4,5,6\n");
  EXPECT_EQ(r.size(), 3U);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("r.csv: 2 rows equal to the row before dropped")));
}

TEST(RecordingFile, MatchesATriadOfItsOwnFileByTime) {
  RecordingSource source = plain_source();
  source.accel.file = "a.csv";
  std::string gyro = "t,gx,gy,gz\n", accel = "t,ax,ay,az\n";
  for (int i = 0; i < 10; ++i) gyro += fmt::format("{},{},0,0\n", 0.01 * i, i);
  for (int i = -2; i < 8; ++i)
    if (i != 4) accel += fmt::format("{},0,0,{}\n", 0.01 * i + 0.0005, i);  // two too early, one missing, two too few
  const auto [r, warnings] = parse_recording(gyro, source, accel);
  EXPECT_THAT(r.gyro[0], ElementsAre(0, 1, 2, 3, 5, 6, 7));
  EXPECT_THAT(r.accel[2], ElementsAre(0, 1, 2, 3, 5, 6, 7));
  EXPECT_EQ(r.time_ns[4], 50'000'000) << "the gyro's stamps";
  EXPECT_THAT(r.gaps, ElementsAre(4));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("r.csv: 3 of 10 rows dropped"), HasSubstr("a.csv: 2 of 9 rows dropped"), HasSubstr("(line 7)")));
}

TEST(RecordingFile, MatchesWhenTheGyroHasItsOwnFile) {
  RecordingSource source = plain_source();
  source.gyro.file = "a.csv";
  const Recording r = parse_recording("t,ax,ay,az\n0,1,2,3\n1,4,5,6\n2,7,8,9\n", source, "t,gx,gy,gz\n1.1,1,2,3\n2.1,4,5,6\n").recording;
  EXPECT_THAT(r.accel[0], ElementsAre(4, 7));
  EXPECT_THAT(r.time_ns, ElementsAre(1'100'000'000, 2'100'000'000));
}

TEST(RecordingFile, WritesATableThatPeopleKnow) {
  const TemporaryFolder folder;
  Recording r;
  r.interval_s = 0.01;
  r.time_ns = {-5'000'000, 1'700'000'000'123'456'789};
  r.gyro = {std::vector{0.1, 1e-9}, std::vector{1.0, -2.0}, std::vector{32768.0, 0.0}};
  r.accel = {std::vector{700.0, 100.0}, std::vector{1.0, 2.0}, std::vector{3.0, 4.0}};
  r.accel_increment = true;
  r.gyro_temperature = {std::vector{25.5, 26.0}, std::vector{25.5, 26.0}, std::vector{25.5, 26.0}};
  r.accel_temperature = {std::vector{1.0, 2.0}, std::vector{3.0, 4.0}, std::vector{5.0, 6.0}};
  write_recording(folder / "r.csv", r);
  EXPECT_EQ(MappedFile(folder / "r.csv").text(),
            "t,gx,gy,gz,ax,ay,az,tg,tax,tay,taz\n"
            "-0.005,0.1,1,32768,7,0.01,0.03,25.5,1,3,5\n"
            "1700000000.123456789,1e-09,-2,0,1,0.02,0.04,26,2,4,6\n");
}

RC_GTEST_PROP(RecordingFile, ReadsBackExactlyWhatItWrites, ()) {
  const TemporaryFolder folder;
  RecordingSource source = plain_source();
  source.rate_hz = *rc::gen::element(10.0, 99.7, 1000.0, 1.0 / 0.003);
  const bool increment = *rc::gen::arbitrary<bool>();
  Recording r;
  r.name = "r.csv";
  r.interval_s = 1 / *source.rate_hz;
  r.gyro_increment = increment;
  source.gyro.output = increment ? Output::increment : Output::rate;
  const auto count = *rc::gen::inRange<std::size_t>(2, 20);
  const auto begin = *rc::gen::inRange<std::int64_t>(-2'000'000'000'000'000'000, 2'000'000'000'000'000'000);
  for (std::size_t i = 0; i < count; ++i) {
    r.time_ns.push_back(begin + static_cast<std::int64_t>(1e9 * r.interval_s * static_cast<double>(i)));
    for (auto& column : r.gyro)  // increments are whole counts
      column.push_back(increment ? *rc::gen::inRange(-40'000, 40'000) / r.interval_s
                                 : std::fmod(static_cast<double>(*rc::gen::arbitrary<float>()) * 1.1, 1e4));
    for (auto& column : r.accel) {
      const double any = std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>());
      column.push_back(std::isfinite(any) ? std::fmod(any, 1e5) : 0);  // what a sensor can give
    }
  }
  write_recording(folder / "r.csv", r);
  Session session;
  session.file = (folder / "session.toml").string();
  const Recording back = read_recording(session, source).recording;
  RC_ASSERT(back.time_ns == r.time_ns);
  RC_ASSERT(back.gyro == r.gyro);
  RC_ASSERT(back.accel == r.accel);
  RC_ASSERT(back.interval_s == r.interval_s);
}

TEST(RecordingFile, AReadingMayBeASumOfColumns) {
  RecordingSource source = plain_source();
  source.accel.columns = {"ux + gx + vx", "uy", 3};
  const auto [r, warnings] = parse_recording("t,gx,gy,gz,ux,uy,vx\n1,1,2,3,10,20,100\n2,4,5,6,30,40,300\n3,7,8,9,50,60,500\n", source);
  EXPECT_THAT(r.accel[0], ElementsAre(111, 334, 557));
  EXPECT_THAT(r.accel[1], ElementsAre(20, 40, 60));
  EXPECT_THAT(r.accel[2], ElementsAre(2, 5, 8));
  EXPECT_THAT(r.gyro[0], ElementsAre(1, 4, 7));
  for (const auto& [wrong, message] : {std::pair{"ux + none", "column none is not there"},
                                       {"ux + ", "column \"\" is not there"},
                                       {"ux+vx", "a sum is written A + B, with blanks, and is one of readings"}}) {
    source.accel.columns[0] = wrong;
    EXPECT_THAT([&] { parse_recording("t,gx,gy,gz,ux,uy,vx\n1,1,2,3,10,20,100\n", source); }, testing::ThrowsMessage<Error>(HasSubstr(message)));
  }
}

TEST(RecordingFile, TriadsOfDifferentRatesAreJoinedByTime) {
  RecordingSource source = plain_source();
  source.accel.file = "a.csv";
  std::string accel = "t,ax,ay,az\n";
  for (int i = 1; i <= 8; ++i) accel += fmt::format("{},{},{},{}\n", 0.5 * i, i, 2 * i, -i);
  const auto [r, warnings] = parse_recording("t,gx,gy,gz\n1,1,2,3\n2,4,5,6\n3,7,8,9\n4,1,1,1\n5,2,2,2\n", source, accel);
  EXPECT_THAT(r.time_ns, ElementsAre(1'000'000'000, 2'000'000'000, 3'000'000'000, 4'000'000'000)) << "the accelerometers end at 4 s";
  EXPECT_THAT(r.accel[0], ElementsAre(1.5, 3.5, 5.5, 7.5));
  EXPECT_THAT(r.accel[2], ElementsAre(-1.5, -3.5, -5.5, -7.5));
  EXPECT_THAT(warnings, testing::Contains(HasSubstr("accelerometers every 0.5 s, gyros every 1 s")));
}

TEST(RecordingFile, ClocksOfManyKinds) {
  const std::string six = ",1,2,3,4,5,6\n", named = ",gx,gy,gz,ax,ay,az\n";
  RecordingSource source = plain_source();
  source.time.unit = "us";
  source.time.wrap_bits = 16;
  EXPECT_THAT(parse_recording("t" + named + "65000" + six + "464,2,2,3,4,5,6\n1464" + six, source).recording.time_ns,
              ElementsAre(65'000'000, 66'000'000, 67'000'000))
      << "65536 us are 0 again";
  source = plain_source();
  source.time.column = "sec";
  source.time.fraction_column = "nsec";
  source.time.zero = 1'700'000'000'000'000'000;
  EXPECT_THAT(parse_recording("sec,nsec" + named + "1700000000,999999999" + six + "1700000001,9999999,2,2,3,4,5,6\n", source).recording.time_ns,
              ElementsAre(999'999'999, 1'009'999'999));
  source = plain_source();
  source.time.unit = "tick";
  source.time.ticks_per_s = 32768;
  EXPECT_THAT(parse_recording("t" + named + "32768" + six + "65536,2,2,3,4,5,6\n", source).recording.time_ns,
              ElementsAre(1'000'000'000, 2'000'000'000));
  source = plain_source();
  source.time = {.column = std::nullopt, .unit = "sample"};
  source.rate_hz = 50;
  EXPECT_THAT(parse_recording("gx,gy,gz,ax,ay,az\n1,2,3,4,5,6\n2,2,3,4,5,6\n", source).recording.time_ns, ElementsAre(20'000'000, 40'000'000));
}

TEST(RecordingFile, CountsOfAUnitAndAxes) {
  RecordingSource source = plain_source();
  source.accel.unit = "g";
  source.accel.counts_per_unit = 4096;
  source.gyro.axes = std::array{BodyAxis{1, 1}, BodyAxis{0, -1}, BodyAxis{2, 1}};
  const Recording r = parse_recording(header + "0.01,1,2,3,4096,0,-2048\n0.02,7,8,9,0,4096,0\n", source).recording;
  EXPECT_THAT(r.accel[0], ElementsAre(testing::DoubleEq(unit::g), 0));
  EXPECT_THAT(r.accel[2], ElementsAre(testing::DoubleEq(-unit::g / 2), 0));
  EXPECT_THAT(r.gyro, ElementsAre(ElementsAre(-2, -8), ElementsAre(1, 7), ElementsAre(3, 9)));
}

TEST(RecordingFile, TextBeforeTheTableIsPassedOver) {
  const auto [r, warnings] = parse_recording("Logger 5\nrange 16 g, 2000 deg/s\n" + header + two_rows + "0.03,1,2,3,4,5,6\n0.04,1,2,3,4,5,7\n");
  EXPECT_EQ(r.size(), 4u);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("2 lines of other text before the table passed over")));
}

TEST(RecordingFile, ALongTextIsReadInPartsAsInOne) {
  // 12 MB: parts for several threads. Comments and a repeated row in between; a wrong row near the end is named by its line.
  std::string text = header;
  const int rows = 300'000;
  for (int i = 0; i < rows; ++i) {
    text += fmt::format("{}.{:03},{},2.5,3.5,-4.25,5.125,{}\n", i / 1000, i % 1000, i, 2 * i);
    if (i % 50'000 == 7) text += "# a comment\n" + fmt::format("{}.{:03},{},2.5,3.5,-4.25,5.125,{}\n", i / 1000, i % 1000, i, 2 * i);
  }
  const auto [r, warnings] = parse_recording(text);
  ASSERT_EQ(r.size(), static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < r.size(); ++i) {
    ASSERT_EQ(r.time_ns[i], static_cast<std::int64_t>(i) * 1'000'000);
    ASSERT_EQ(r.gyro[0][i], static_cast<double>(i));
    ASSERT_EQ(r.accel[2][i], 2 * static_cast<double>(i));
  }
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("6 rows equal to the row before dropped")));
  EXPECT_THAT([&] { parse_recording(text + "400,1,2,x,4,5,6\n401,1,2,3,4,5,6\n"); },
              testing::ThrowsMessage<Error>(HasSubstr(":300014: gz: \"x\" is not a number")));
  EXPECT_THAT([&] { parse_recording(text + "5,1,2,3,4,5,6\n"); }, testing::ThrowsMessage<Error>(HasSubstr(":300014: t: time runs backwards")));
  RecordingSource source = plain_source();
  source.accel.limits = {-1e9, 599'998};
  EXPECT_THAT(parse_recording(text, source).warnings, testing::Contains(HasSubstr("(line 300013)")));
}

}  // namespace
}  // namespace imulab
