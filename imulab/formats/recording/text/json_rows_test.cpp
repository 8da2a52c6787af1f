// Rows of a pattern are read by comparison, others value by value: the same lines.
#include "imulab/formats/recording/text/json_rows.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace imulab::recording_io {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  JsonRows rows("log", text, true);
  std::string out, line;
  rows.add(text, true, out);
  std::vector<std::string> lines;
  for (const char c : out)
    if (c == '\n')
      lines.push_back(std::exchange(line, {}));
    else
      line += c;
  return lines;
}

/// What one row gives at its first place, behind the row that names the columns, and at its second, which may be read by comparison.
void expect_the_same_twice(const std::string& row, const std::string& expected) {
  const std::string names = R"({"t": 0, "a": [1, 2], "s": "x"})";
  const std::string text = names + "\n" + row + "\n" + row + "\n" + names + "\n" + row + "\n";
  EXPECT_THAT(lines_of(text), testing::ElementsAre("0,1,2,x", expected, expected, "0,1,2,x", expected)) << row;
}

TEST(JsonRows, OfAPatternAreTheSameLines) {
  for (const auto& [row, expected] : std::vector<std::pair<std::string, std::string>>{
           {R"({"t": 1.5, "a": [-2e-3, 4], "s": "y"})", "1.5,-2e-3,4,y"},
           {R"({"t":1,"a":[2,3],"s":"y"})", "1,2,3,y"},
           {R"({ "t" : 1 , "a" : [ 2 , 3 ] , "s" : "y" } )", "1,2,3,y"},
           {R"({"s": "y", "a": [2, 3], "t": 1})", "1,2,3,y"},
           {R"({"t": 1, "a": [2, 3]})", "1,2,3,"},
           {R"({"a": [2, 3]})", ",2,3,"},
           {R"({"s": "y"})", ",,,y"},
           {R"({"a": [2]})", ",2,,"},
           {R"({"t": null, "a": [true, false], "s": ""})", ",1,0,"},
           {R"({"t": NaN, "a": [2, 3], "s": "y"})", "NaN,2,3,y"},
           {R"({"t": 1, "a": [2, 3], "s": "y, z"})", R"(1,2,3,"y, z")"},
           {R"({"t": 1, "a": [2, 3], "s": "2026-03-31T12:00:00.000000001Z"})", "1,2,3,2026-03-31T12:00:00.000000001Z"},
           {R"({"t": 1, "t": 5, "a": [2, 3], "s": "y"})", "5,2,3,y"},
           {R"({"t": 1, "a": [2, 3], "s": ")" + std::string(100, 'y') + "\"}", "1,2,3," + std::string(100, 'y')}})
    expect_the_same_twice(row, expected);
}

TEST(JsonRows, OfSensorsInTurnAreTheSameLines) {
  std::string text;
  std::vector<std::string> expected;
  for (int k = 0; k < 50; ++k) {
    const std::string n = std::to_string(k);
    text += "{\"gyro\": [" + n + ", 1, 2]}\n{\"accel\": [3, 4, -" + n + ".5]}\n{\"note\": " + n + ", \"gyro\": [0, 0, 1]}\n";
    expected.insert(expected.end(), {n + ",1,2,,,,", ",,,3,4,-" + n + ".5,", "0,0,1,,,," + n});
  }
  EXPECT_THAT(lines_of(text), testing::ElementsAreArray(expected));
}

TEST(JsonRows, ThatAreCutAtAnyPlaceAreTheSameLines) {
  std::string text;
  for (int k = 0; k < 6; ++k) text += "[" + std::to_string(k) + ", 2.5, \"a\"]\n";
  const std::vector<std::string> whole = lines_of(text);
  for (std::size_t cut = 1; cut < text.size(); ++cut) {
    JsonRows rows("log", text, true);
    std::string out;
    rows.add(text.substr(0, cut), false, out);
    rows.add(text.substr(cut), true, out);
    EXPECT_EQ(out, "0,2.5,a\n1,2.5,a\n2,2.5,a\n3,2.5,a\n4,2.5,a\n5,2.5,a\n") << cut;
  }
  EXPECT_EQ(whole.size(), 6u);
}

}  // namespace
}  // namespace imulab::recording_io
