// Messages about wrong recordings.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/recording_text.hpp"
#include <string>

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(RecordingFile, NamesFileLineColumnAndWhatWasExpected) {
  const auto row = [](const std::string& line) { return header + "0.01,1,2,3,4,5,6\n" + line + "\n0.03,1,2,3,4,5,6\n"; };
  RecordingSource numbered = plain_source();
  numbered.time.column = 1;
  numbered.gyro.columns = {2, 3, 4};
  numbered.accel.columns = {5, 6, 7};
  RecordingSource rated = plain_source();
  rated.rate_hz = 100;
  RecordingSource ninth = numbered;
  ninth.accel.columns[2] = 9;
  RecordingSource twice = plain_source();
  twice.gyro.columns[0] = "t";
  const struct {
    std::string text, message;
    RecordingSource source = plain_source();
  } cases[] = {
      {row("0.02,1,abc,3,4,5,6"), ":3: gy: \"abc\" is not a number"},
      {row("0.02,1,2,3,4,5,6.1.2"), ":3: az: \"6.1.2\" is not a number"},
      {row("0.02,1,2,3,4,5,0x10"), ":3: az: \"0x10\" is not a number"},
      {row("0.02,1,,3,4,5,6"), ":3: gy: is empty; expected a number"},
      {row("0.02,1,2,3,4,5,"), ":3: az: is empty"},
      {row(",1,2,3,4,5,6"), ":3: t: is empty"},
      {row("0.02,1,nan,3,4,5,6"), ":3: gy: nan is not a reading; expected a finite number"},
      {row("0.02,1,2,3,-inf,5,6"), ":3: ax: -inf is not a reading"},
      {row("0.02,1,2,3,1e999,5,6"), ":3: ax: 1e999 is too large or too small; expected a number that a double can hold"},
      {row("noon,1,2,3,4,5,6"), ":3: t: \"noon\" is not a time"},
      {row("nan,1,2,3,4,5,6"), ":3: t: \"nan\" is not a time"},
      {row("5e9,1,2,3,4,5,6"), ":3: t: 5e9 is too far from the clock's zero; expected less than 146 years"},
      {row("1e11,1,2,3,4,5,6"), ":3: t: 1e11 is too far from the clock's zero"},
      {row("0.02,1,2,3,4,5"), ":3: 6 fields; expected 7 as in the header"},
      {row("0.02,1,2,3,4,5,6,7"), ":3: 8 fields; expected 7 as in the header"},
      {row("0.02"), ":3: 1 fields; expected 7"},
      {row("0.005,1,2,3,4,5,6"), ":3: t: time runs backwards: 0.005 s after 0.01 s"},
      {row("0.01,1,2,3,4,5,7"), ":3: t: 0.01 s is on two rows with different readings"},
      {"# c\n0.01 1 2 3 4 5 6\n0.02 1 2 3 4 5\n", ":3: 6 fields; expected 7 as in line 2", numbered},
      {"0.01 1 2 3 4 5 6\n0.02 1 2 x 4 5 6\n", ":2: column 4: \"x\" is not a number", numbered},
      {"", ": is empty; expected rows of numbers"},
      {"# nothing\n\n", ": has no rows"},
      {header, ": has a header but no rows"},
      {header + "# nothing\n", ": has a header but no rows"},
      {two_rows, ":1: has no header; expected one because columns are named"},
      {"t,gx,gy,gz,ax,ay,a_z\n" + two_rows, ": column az is not there; expected one of t, gx, gy, gz, ax, ay, a_z"},
      {"t,gx,gy,gz,ax,ay,ax\n" + two_rows, ": column ax is there more than once"},
      {header + two_rows, ": column 9 is not there; expected 1 to 7", ninth},
      {header + two_rows, ": the time column is also named as a reading", twice},
      {header + "0.01,1,2,3,4,5,6\n", ": has one row; expected at least two"},
      {rows_at({"0", "0.02", "0.04"}),
       ": rate_hz = 100 is declared, but the stamps give 50 Hz (median difference 0.02 s); expected agreement within 2 %", rated},
      {rows_at({"0", "0.01021", "0.02042"}), ": rate_hz = 100 is declared, but the stamps give 97.9432 Hz", rated},
      {std::string("MATLAB 5.0\0\1\2", 13), ": unknown format; expected "},
  };
  for (const auto& c : cases) {
    try {
      parse_recording(c.text, c.source);
      ADD_FAILURE() << "accepted:\n" << c.text;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("r.csv" + c.message)) << c.text;
    }
  }
  EXPECT_THAT([] { read_recording({}, plain_source()); }, testing::ThrowsMessage<Error>(HasSubstr("r.csv: cannot be opened: No such file")));
}

TEST(RecordingFile, NamesFilesThatDoNotBelongTogether) {
  RecordingSource source = plain_source();
  source.accel.file = "a.csv";
  const std::string gyro = "t,gx,gy,gz\n0,1,2,3\n1,4,5,6\n2,7,8,9\n";
  const struct {
    std::string accel, message;
  } cases[] = {
      {"t,ax,ay,az\n100,1,2,3\n101,4,5,6\n", "a.csv: no time in common with "},
      {"t,ax,ay,az\n0,1,2,3\n1,4,x,6\n", "a.csv:3: ay: \"x\" is not a number"},
  };
  for (const auto& c : cases) EXPECT_THAT([&] { parse_recording(gyro, source, c.accel); }, testing::ThrowsMessage<Error>(HasSubstr(c.message)));
}

RC_GTEST_PROP(RecordingFile, ReadsOrRefusesADamagedFile, ()) {
  std::string text = header + two_rows + "0.03,1,2,3,4,5,6\n";
  const auto damages = *rc::gen::inRange(1, 6);
  for (int i = 0; i < damages; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    text.replace(at, *rc::gen::inRange<std::size_t>(0, 3), 1, *rc::gen::element('\n', ',', '.', '-', 'e', '9', ' ', '\r', '#', '"', '\0', '\xff'));
  }
  try {
    const Recording r = parse_recording(text).recording;
    for (const auto& column : r.gyro) RC_ASSERT(column.size() == r.size());
    for (std::size_t i = 1; i < r.size(); ++i) RC_ASSERT(r.time_ns[i] > r.time_ns[i - 1]);
  } catch (const Error& e) {
    RC_ASSERT(std::string(e.what()).find("r.csv") != std::string::npos);
  }
}

TEST(RecordingFile, AWayFromOneStepToTheNextIsNoGapToWarnOf) {
  const TemporaryFolder folder;
  Session session;
  session.file = (folder / "session.toml").string();
  folder.write("r.csv", rows_at({"1.01", "1.02", "1.03", "5.01", "5.02", "5.03", "5.44", "5.45", "5.46", "9.01", "9.02", "9.03"}));
  const auto warnings = [&](const std::vector<std::array<double, 2>>& steps) {
    session.steps.clear();
    for (const auto& [start, end] : steps) {
      Step& step = session.steps.emplace_back();
      step.start = start, step.end = end;
    }
    const RecordingReading read = read_recording(session, plain_source());
    EXPECT_THAT(read.recording.gaps, testing::ElementsAre(3, 6, 9));
    return read.warnings;
  };
  EXPECT_THAT(warnings({}), testing::ElementsAre(HasSubstr("3 gaps in time")));
  EXPECT_THAT(warnings({{1.003, 1.036}, {4.995, 5.03}, {5.43, 5.46}, {9, 9.03}}), testing::IsEmpty());  // steps need not begin with a sample
  EXPECT_THAT(warnings({{1, 1.03}, {5, 5.46}, {9, 9.03}}),
              testing::ElementsAre(HasSubstr("1 gap in time (more than 1.5 of the nominal 0.01 s), the largest of "
                                             "0.41 s before 5.44 s (line 8)")));  // inside a step
  EXPECT_THAT(warnings({{1, 1.03}, {4, 5.03}, {5.43, 5.46}, {9, 9.03}}),
              testing::ElementsAre(HasSubstr("1 gap in time")));                                        // a step's begin is missing
  EXPECT_THAT(warnings({{5, 5.03}, {5.43, 5.46}}), testing::ElementsAre(HasSubstr("2 gaps in time")));  // before and after all steps
}

}  // namespace
}  // namespace imulab
