// Text as people write it: one recording in every dialect reads the same; what two conventions could mean is an error that says what to declare.
#include "imulab/error.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/formats/recording/text/encoding.hpp"
#include "imulab/formats/recording/text/number_form.hpp"
#include "imulab/formats/recording/text/stream.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/recording_text.hpp"
#include <array>
#include <functional>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string swapped(std::string text, char from, const std::string& to) {
  std::string result;
  for (const char c : text) result += c == from ? to : std::string(1, c);
  return result;
}

/// Six rows at 100 Hz with numbers of two decimals, divided by commas; stamps by a function of the row.
std::string rows_of(const std::function<std::string(int)>& stamp, int count = 6) {
  std::string text;
  for (int i = 0; i < count; ++i) text += fmt::format("{},{}.25,-2.5,3.5,4.5,5.5,9.{}1\n", stamp(i), i, i % 10);
  return text;
}
std::string seconds(int i) { return fmt::format("0.{:02}", i + 1); }

std::string utf16(const std::string& text, bool low_first) {
  std::string result = low_first ? "\xFF\xFE" : "\xFE\xFF";
  for (const char c : text) result += low_first ? std::string{c, '\0'} : std::string{'\0', c};
  return result;
}

std::string quoted(const std::string& text) {
  std::string result;
  bool begin = true;
  for (const char c : text) {
    if (begin || c == ',' || c == '\n') result += begin ? "\"" : c == ',' ? "\",\"" : "\"\n";
    if (c != ',' && c != '\n') result += c;
    begin = c == '\n';
  }
  return result;
}

std::string json_of(const std::string& before, const std::string& after) {
  std::string text = before;
  for (int i = 0; i < 6; ++i)
    text +=
        fmt::format(R"({}{{"t": {}, "gx": {}.25, "gy": -2.5, "gz": 3.5, "ax": 4.5, "ay": 5.5, "az": 9.{}1}})", i > 0 ? ",\n" : "", seconds(i), i, i);
  return text + after;
}

TEST(Dialect, OneRecordingReadsTheSameInAll) {
  const std::string plain = header + rows_of(seconds),
                    in_date = header + rows_of([](int i) { return "2025/07/08 19:34:18." + fmt::format("{:02}", i + 1); });
  const std::string commas = swapped(swapped(plain, ',', ";"), '.', ",");
  std::string labels;
  for (int i = 0; i < 6; ++i) labels += fmt::format("t = {}, gx = {}.25, gy = -2.5, gz: 3.5, ax=4.5, ay = 5.5 m/s^2, az = 9.{}1\n", seconds(i), i, i);
  const struct {
    const char* dialect;
    std::string text;
    double zero = 0;
  } cases[] = {
      {"plain", plain},
      {"UTF-16, low byte first", utf16(swapped(plain, '\n', "\r\n"), true)},
      {"UTF-16, high byte first", utf16(plain, false)},
      {"carriage returns", swapped(plain, '\n', "\r")},
      {"decimal commas, semicolons", commas},
      {"decimal commas, tabs", swapped(commas, ';', "\t")},
      {"decimal commas, blanks", swapped(commas, ';', "  ")},
      {"every field in quotes", quoted(plain)},
      {"decimal commas in quotes", swapped(swapped(quoted(swapped(plain, '.', "~")), '~', ","), '~', ",")},
      {"a row of units", "t,gx,gy,gz,ax,ay,az\ns,rad/s,rad/s,rad/s,m/s^2,m/s^2,m/s^2\n" + rows_of(seconds)},
      {"labels, names, units", "Label,A,A,A,A,A,A\n" + header + "s,rad/s,rad/s,rad/s,m/s^2,m/s^2,m/s^2\n" + rows_of(seconds)},
      {"more blank fields than numbers", swapped(swapped(plain, '\n', ",,,,,,,,,\n"), '~', "")},
      {"points between thousands", swapped(header, ',', ";") + "1.000,01;0,25;-2,5;3,5;4,5;5,5;9,01\n1.000,02;1,25;-2,5;3,5;4,5;5,5;9,11\n", 1000},
      {"commas between thousands, in quotes", header + "\"1,000.01\",0.25,-2.5,3.5,4.5,5.5,9.01\n\"1,000.02\",1.25,-2.5,3.5,4.5,5.5,9.11\n", 1000},
      {"blanks between thousands", swapped(header, ',', ";") + "1 000.01;0.25;-2.5;3.5;4.5;5.5;9.01\n1 000.02;1.25;-2.5;3.5;4.5;5.5;9.11\n", 1000},
      {"dates", in_date, 1752003258},
      {"dates with a zone", swapped(swapped(in_date, '/', "-"), ' ', "T").replace(0, 0, ""), 1752003258},
      {"dates of the day first, and a time in another column",
       swapped(header, 't', "t,clock") + rows_of([](int i) { return "08.07.2025,19:34:18." + fmt::format("{:02}", i + 1); }), 1752003258},
      {"JSON lines", swapped(json_of("", "\n"), '~', "")},
      {"JSON array", json_of("[", "]")},
      {"JSON array in an object", json_of(R"({"device": "x", "rate": 100, "data": [)", "]}")},
      {"labeled numbers", labels},
  };
  for (const auto& c : cases) {
    RecordingSource source = plain_source();
    source.time.zero = static_cast<std::int64_t>(c.zero) * 1'000'000'000;
    SCOPED_TRACE(c.dialect);
    try {
      const auto [r, warnings] = parse_recording(c.text, source);
      ASSERT_GE(r.size(), 2U);
      for (std::size_t i = 0; i < r.size(); ++i) {
        EXPECT_EQ(r.time_ns[i], static_cast<std::int64_t>(i + 1) * 10'000'000);  // exact to the nanosecond
        EXPECT_EQ(r.gyro[0][i], static_cast<double>(i) + 0.25);
        EXPECT_EQ(r.gyro[1][i], -2.5);
        EXPECT_DOUBLE_EQ(r.accel[2][i], 9.01 + 0.1 * static_cast<double>(i));
      }
      EXPECT_THAT(warnings, IsEmpty());
    } catch (const Error& e) {
      ADD_FAILURE() << e.what();
    }
  }
}

TEST(Dialect, WhatTwoConventionsCouldMeanIsAskedAndMixedOnesAreErrors) {
  const std::string names = "t;gx;gy;gz;ax;ay;az\n";
  const auto repeated = [](const std::string& row, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += fmt::format("{}{}\n", i + 1, row);
    return text;
  };
  const struct {
    std::string text, message;
  } cases[] = {
      {names + repeated(";1,234;2,345;3,456;4,567;5,678;6,789", 3), ":2: column 2: \"1,234\" is one and a fraction or a thousand"},
      {names + repeated(";1,5;2,5;3,5;4,5;5,5;6,5", 3) + "4;1.5;2,5;3,5;4,5;5,5;6,5\n",
       ":5: column 2: \"1.5\" has another decimal mark than \"1,5\" in line 2"},
      {names + repeated(";1,5;2,5;3,5;4,5;5,5;6,5", 300) + "301;1.5;2,5;3,5;4,5;5,5;6,5\n302;1,5;2,5;3,5;4,5;5,5;6,5\n",
       ":302: gx: \"1.5\" is not written as the other numbers"},
      {swapped(header, '~', "") + "03/04/2025 10:00:00,1,2,3,4,5,6\n03/04/2025 10:00:01,1,2,3,4,5,6\n",
       ":2: column 1: \"03/04/2025 10:00:00\" is a day and a month"},
      {header + repeated(",5,1,25,2,5,3,5,4,5,5,5,9,1", 6), ":2: has 14 fields, twice the 7 of the header: decimal commas between commas"},
      {"[" + std::string(300'000, '1') + "]", ": has a header but no rows"},
      {std::string(3'000'000, 'x'), ":1: is a line of 3000000 bytes"},
      {"[[1,2,3],[4,5,6],7]", ": element 3: is no JSON"},
  };
  for (const auto& c : cases) {
    try {
      parse_recording(c.text);
      ADD_FAILURE() << "accepted:\n" << c.text.substr(0, 200);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("r.csv" + c.message));
    }
  }
  RecordingSource declared = plain_source();
  declared.layout = "text decimal=,";
  EXPECT_EQ(parse_recording(cases[0].text, declared).recording.gyro[0][0], 1.234);
  declared.layout = "text decimal=.";
  EXPECT_EQ(parse_recording(cases[0].text, declared).recording.gyro[0][0], 1234);
  declared.layout = "text dates=dmy";
  EXPECT_EQ(parse_recording(cases[3].text, declared).recording.time_ns[0], 1'743'674'400'000'000'000);
  declared.layout = "text dates=mdy";
  EXPECT_EQ(parse_recording(cases[3].text, declared).recording.time_ns[0], 1'741'082'400'000'000'000);
  declared.layout = "text date=mdy";
  EXPECT_THAT([&] { parse_recording(cases[3].text, declared); },
              testing::ThrowsMessage<Error>(HasSubstr("date=mdy is not known; expected decimal=,")));
}

TEST(Dialect, RowsThatAreNoneAreLeftOutWhereTheyAreFewAndSaid) {
  const std::string good = rows_of([](int i) { return fmt::format("{}", 0.01 * (i + 1)); }, 300);
  const auto with = [&](int row, const std::string& line) {
    std::size_t at = 0;
    for (int i = 0; i < row; ++i) at = good.find('\n', at) + 1;
    return header + good.substr(0, at) + line + good.substr(at);
  };
  const struct {
    std::string text, warning;
  } cases[] = {
      {with(300, ",,,,,,\n,,,,,,\n"), "2 lines left out at the end, the first line 302: \",,,,,,\""},
      {with(300, "Mean,1,2,3,4,5,6\nmade by a spreadsheet\n"), "2 lines left out at the end, the first line 302: \"Mean,1,2,3,4,5,6\""},
      {with(300, std::string(5000, '\xFF')), "ends with 5000 bytes of erased memory"},
      {with(300, std::string(5000, '\0')), "ends with 5000 bytes of erased memory"},
      {with(100, header), "1 line left out, the first line 102: the header again"},
      {with(100, "1.005,nan,nan,nan,4,5,6\n"), "1 line left out (nothing is measured there), the first line 102: gx: nan is not a reading"},
  };
  for (const auto& c : cases) {
    const auto [r, warnings] = parse_recording(c.text);
    EXPECT_EQ(r.size(), 300U) << c.warning;
    EXPECT_THAT(warnings, Contains(HasSubstr(c.warning)));
    EXPECT_EQ(signals_of_text("x", c.text).rows(), 300U) << c.warning;
  }
  EXPECT_THAT([&] { parse_recording(with(100, "1.005,abc,2,3,4,5,6\n")); },
              testing::ThrowsMessage<Error>(HasSubstr("r.csv:102: gx: \"abc\" is not a number")));
  std::string many;
  for (int i = 0; i < 9; ++i) many += fmt::format("1.00{},nan,nan,nan,4,5,6\n", i + 1);
  EXPECT_THAT([&] { parse_recording(with(100, many)); },
              testing::ThrowsMessage<Error>(HasSubstr("r.csv:102: gx: nan is not a reading; expected a finite number; so in 9 rows")));
}

std::string interleaved() {
  std::string text = "time,sensor,x,y,z\n";
  for (int i = 0; i < 40; ++i) text += fmt::format("{:.2f},GYR,0.1,0.2,{}\n{:.3f},ACC,0.5,0.6,9.{}\n", 0.01 * i, i, 0.01 * i + 0.002, i);
  return text;
}

TEST(Dialect, InterleavedSensorsAreTables) {
  const TemporaryFolder folder;
  const std::vector<SignalTable> tables = read_tables(folder.write("r.csv", interleaved()));
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0].topic, "GYR");
  EXPECT_EQ(tables[1].topic, "ACC");
  EXPECT_EQ(tables[1].signals[2].name, "ACC.x");
  EXPECT_EQ(tables[1].rows(), 40U);
  RecordingSource source = plain_source();
  source.topic = "GYR", source.time.column = "time";
  source.gyro.columns = source.accel.columns = {"x", "y", "z"};
  source.accel.topic = "ACC";
  const Recording r = parse_recording(interleaved(), source).recording;
  EXPECT_EQ(r.gyro[2][6] - r.gyro[2][5], 1);
  RecordingSource unknown = source;
  unknown.topic = "MAG";
  EXPECT_THAT(([&] { parse_recording(interleaved(), unknown); }),
              testing::ThrowsMessage<Error>(HasSubstr("topic MAG is not there; expected one of ACC, GYR")));
}

TEST(Dialect, UnitsUnderTheHeaderAreThoseOfTheSignals) {
  const SignalTable table = signals_of_text("x", "Time,Accel,,,Gyro,,\nt,x,y,z,x,y,z\ns,m/s²,m/s²,m/s²,\xB0/s,\xB0/s,\xB0/s\n" + rows_of(seconds));
  ASSERT_EQ(table.signals.size(), 7U);
  EXPECT_EQ(table.signals[1].name, "Accel x");
  EXPECT_EQ(table.signals[6].name, "Gyro z");
  EXPECT_EQ(table.signals[1].unit, "m/s^2");
  EXPECT_EQ(table.signals[4].unit, "deg/s");
}

/// A stream arrives in pieces that end anywhere.
TEST(Dialect, StreamsReadTheSame) {
  const std::string plain = header + rows_of(seconds), commas = swapped(swapped(plain, ',', ";"), '.', ",");
  for (const std::string& text :
       {plain, commas, utf16(plain, true), quoted(plain), swapped(plain, '\n', "\r"), json_of("", "\n"), json_of("[", "]")}) {
    std::array<int, 2> ends{};
    ASSERT_EQ(::pipe(ends.data()), 0);
    ASSERT_EQ(::write(ends[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
    ::close(ends[1]);
    RecordingStream stream(ends[0], "pipe", plain_source());
    std::vector<double> read;
    while (const auto block = stream.next()) read.insert(read.end(), block->gyro[0].begin(), block->gyro[0].end());
    ::close(ends[0]);
    EXPECT_THAT(read, ElementsAre(0.25, 1.25, 2.25, 3.25, 4.25, 5.25)) << text.substr(0, 60);
  }
}

TEST(NumberForm, SaysWhatANumberShows) {
  using recording_io::number_form;
  EXPECT_TRUE(number_form("0,5").decimal_comma);
  EXPECT_TRUE(number_form("-1,25E-02").decimal_comma);
  EXPECT_TRUE(number_form("0,123").decimal_comma);  // no thousands begin with 0
  EXPECT_TRUE(number_form("1,234").comma_unknown);
  EXPECT_TRUE(number_form("1,234,567").comma_groups);
  EXPECT_TRUE(number_form("1.234,5").point_groups);
  EXPECT_TRUE(number_form("1'234.5").decimal_point);
  EXPECT_EQ(number_form("1\xC2\xA0"
                        "234,5")
                .groups,
            ' ');
  for (const char* text : {"", "-", "1,", "1,2,3", "1,23,456", "abc", "1e", "1.2.3", "0x10", "1 23"}) EXPECT_FALSE(number_form(text).number) << text;
}

using recording_io::Decoder;
using recording_io::Encoding;

/// Two bytes a unit, as UTF-16 with the low byte first or last.
std::string bytes_of(const std::u16string& text, Encoding encoding) {
  std::string out;
  for (const char16_t unit : text) {
    const char low = static_cast<char>(unit & 0xFFU), high = static_cast<char>(unit >> 8U);
    out += encoding == Encoding::utf16_low_first ? std::string{low, high} : std::string{high, low};
  }
  return out;
}

/// Decodes bytes that come in two parts.
std::string decoded(const std::string& bytes, Encoding encoding, std::size_t first) {
  Decoder decoder({encoding, 0});
  std::string out;
  decoder.add(std::string_view(bytes).substr(0, first), false, out);
  decoder.add(std::string_view(bytes).substr(first), true, out);
  return out;
}

TEST(Utf16, CharactersOfEachLengthAreThoseOfUtf8WhereverTheirBytesAreCut) {
  // The first and the last character of each length in UTF-8, and one with different bits in each of its bytes; the compiler encodes both sides.
  const std::vector<std::pair<std::u16string, std::string>> texts{{u"\u007F\u0080\u00B0", "\u007F\u0080\u00B0"},
                                                                  {u"\u07FF\u0800\u2074", "\u07FF\u0800\u2074"},
                                                                  {u"\uFFFD\U00010000\U0001F6F0", "\uFFFD\U00010000\U0001F6F0"},
                                                                  {u"t\U0010FFFFs", "t\U0010FFFFs"}};
  for (const auto& [text, expected] : texts)
    for (const Encoding encoding : {Encoding::utf16_low_first, Encoding::utf16_high_first}) {
      const std::string bytes = bytes_of(text, encoding);
      for (std::size_t first = 0; first <= bytes.size(); ++first) EXPECT_EQ(decoded(bytes, encoding, first), expected) << first;
    }
}

TEST(Utf16, HalfOfAPairIsAnUnknownCharacter) {
  const std::vector<std::pair<std::u16string, std::string>> texts{
      {{u'a', 0xD83D, u'b'}, "a\uFFFDb"}, {{u'a', 0xDE80, u'b'}, "a\uFFFDb"}, {{0xD83D, 0xD83D, 0xDE80}, "\uFFFD\U0001F680"}};
  for (const auto& [text, expected] : texts) EXPECT_EQ(decoded(bytes_of(text, Encoding::utf16_low_first), Encoding::utf16_low_first, 1), expected);
}

}  // namespace
}  // namespace imulab
