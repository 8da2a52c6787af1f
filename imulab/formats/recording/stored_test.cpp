// Reading in pieces gives what reading at once gives, bit for bit; with the same messages.
#include "imulab/formats/recording/stored.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/recording/resampling.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <functional>

namespace imulab {
namespace {

using testing::HasSubstr;

constexpr const char* csv_columns =
    "time = { column = \"t\", unit = \"s\" }\n"
    "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"deg/s\", axes = [\"+y\", \"-x\", \"+z\"], limits = [-100.0, 100.0] }\n"
    "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"g\" }\n"
    "gyro_temperature = { columns = [\"T\"], unit = \"degC\" }\n";

Session session_of(const TemporaryFolder& folder, const std::string& file, const std::string& declared) {
  folder.write(
      "session.toml",
      "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[site]\nlatitude_deg = 47.0\n[rig]\nkind = \"none\"\n[[recording]]\nfile = \"" + file +
          "\"\n" + declared);
  return read_session(folder / "session.toml");
}

void expect_equal(const RecordingView& a, const RecordingView& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.interval_s, b.interval_s);
  EXPECT_EQ(a.gyro_unit, b.gyro_unit);
  EXPECT_EQ(a.accel_unit, b.accel_unit);
  ASSERT_TRUE(std::ranges::equal(a.time_ns, b.time_ns)) << a.size() << " and " << b.size() << " samples";
  EXPECT_TRUE(std::ranges::equal(a.saturated, b.saturated)) << a.saturated.size() << " and " << b.saturated.size();
  EXPECT_TRUE(std::ranges::equal(a.gaps, b.gaps)) << a.gaps.size() << " and " << b.gaps.size();
  std::vector<double> from_a, from_b;
  for (std::size_t c = 0; c < all_columns; ++c) {
    ASSERT_EQ(a.has(c), b.has(c)) << c;
    if (!a.has(c)) continue;
    EXPECT_TRUE(std::ranges::equal(a.samples(c, {0, a.size()}, from_a), b.samples(c, {0, b.size()}, from_b))) << "column " << c;
    const Range middle{a.size() / 3, a.size() / 2};
    EXPECT_TRUE(std::ranges::equal(a.samples(c, middle, from_a), b.samples(c, middle, from_b))) << "column " << c;
  }
}

/// Reads both ways, and fills lost samples; what was read at once.
RecordingReading expect_same(const Session& session) {
  RecordingReading whole = read_recording(session, session.recordings[0]);
  std::string why;
  std::optional<StoredReading> stored = read_stored(session, session.recordings[0], 0, why);
  if (!stored) {
    ADD_FAILURE() << why;
    return whole;
  }
  EXPECT_EQ(stored->warnings, whole.warnings);
  expect_equal(stored->recording.view(), whole.recording);
  const FilledRecording filled = with_short_gaps_filled(whole.recording);
  EXPECT_EQ(stored->recording.fill_short_gaps(), filled.filled);
  expect_equal(stored->recording.view(), filled.recording);
  return whole;
}

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// More than two pieces of text, with all that makes rows depend on each other.
std::string long_text(const std::string& in_the_middle = "") {
  constexpr int rows = 400000;
  std::string text = "# a log\nt,gx,gy,gz,ax,ay,az,T\n";
  for (int i = 1; i <= rows; ++i) {
    if (i % 1000 == 0 || (i > 150000 && i < 150020)) continue;  // single lost samples, and a gap
    const auto wave = [i](int k) { return std::fmod(0.61803398875 * i * (k + 1) * (k + 7), 1.0) - 0.5; };
    const double gy = i % 77777 == 0 ? 100.0 : wave(1);          // at a limit
    const double az = i % 50000 < 5 ? 2.0 : 1 + 0.01 * wave(5);  // clips where no limit is declared
    const std::string row = fmt::format("{:.3f},{:.7f},{:.7f},{:.7f},{:.9f},{:.9f},{:.9f},{:.2f}\n", 0.001 * i, wave(0), gy, wave(2), wave(3),
                                        wave(4), az, 25 + 1e-5 * i);
    text += row;
    if (i % 100003 == 0) text += "# a comment\n" + row;  // again
    if (i == 300001) text += in_the_middle;
  }
  return text + "400.001,0.1,0.2";  // switched off
}

TEST(StoredRecording, HasTheColumnsOfOneReadAtOnce) {
  const TemporaryFolder folder;
  folder.write("log.csv", long_text());
  const RecordingReading whole = expect_same(session_of(folder, "log.csv", std::string("rate_hz = 1000.0\n") + csv_columns));
  // The text has what it was made to have.
  EXPECT_GT(whole.recording.gaps.size(), 390u);
  EXPECT_GT(whole.recording.saturated.size(), 30u);
  EXPECT_EQ(whole.warnings.size(), 4u) << "cut, repeated, gaps, saturated";
}

TEST(StoredRecording, CountsTicksThatWrap) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 1; i <= 300000; ++i)
    text += fmt::format("{} {:.6f} 0.25 -0.5 {:.6f} 0.5 9.8 and some more text\n", i * 1000 % 65536, 1e-3 * (i % 17), 1e-3 * (i % 13));
  folder.write("log.txt", text);
  expect_same(session_of(folder, "log.txt",
                         "time = { column = 1, unit = \"tick\", ticks_per_s = 1e6, wrap_bits = 16 }\n"
                         "gyro = { columns = [2, 3, 4], output = \"rate\", unit = \"rad/s\" }\n"
                         "accel = { columns = [5, 6, 7], output = \"rate\", unit = \"m/s^2\" }\n"));
}

TEST(StoredRecording, SaysWhatIsWrongWithTheSameWords) {
  const TemporaryFolder folder;
  for (const char* wrong : {"300.002,1,2,3,x,5,6,7\n", "300.002,1,2,3\n", "299.0,1,2,3,4,5,6,25\n", "300.001,1,2,3,4,5,6,25\n",
                            "300.0011,1,2,3,4e9,5,6,25\n", "300.0011,1,2,3,4,5,6,-300\n"}) {
    folder.write("log.csv", long_text(wrong));
    const Session session = session_of(folder, "log.csv", std::string("rate_hz = 1000.0\n") + csv_columns);
    std::string why;
    const std::string message = message_of([&] { read_recording(session, session.recordings[0]); });
    EXPECT_NE(message, "no error") << wrong;
    EXPECT_EQ(message_of([&] { read_stored(session, session.recordings[0], 0, why); }), message);
  }
}

TEST(StoredRecording, ReadsArraysOfNumPy) {
  const std::string rate = "output = \"rate\", unit = ";
  for (const char* name : {"rows.npy", "rows_fortran.npy", "lying.npy"}) {
    const TemporaryFolder folder;
    std::filesystem::copy_file(recording_file(name), folder / name);
    expect_same(session_of(folder, name,
                           "time = { column = 1, unit = \"s\" }\ngyro = { columns = [2, 3, 4], " + rate +
                               "\"rad/s\" }\naccel = { columns = [5, 6, 7], " + rate + "\"m/s^2\" }\n"));
  }
  const std::string arrays = "time = { column = \"stamp\", unit = \"ns\" }\ngyro = { columns = [\"gyro.3\", \"gyro.2\", \"gyro.1\"], " + rate +
                             "\"rad/s\" }\naccel = { columns = [\"counts.2\", \"accel.1\", \"accel.3\"], " + rate + "\"m/s^2\" }\n";
  const TemporaryFolder folder;
  for (const char* name : {"arrays.npz", "arrays_deflated.npz", "two_lengths.npz"}) std::filesystem::copy_file(recording_file(name), folder / name);
  expect_same(session_of(folder, "arrays.npz", arrays));
  const Session by_column = session_of(folder, "arrays_deflated.npz", arrays);
  std::string why;
  EXPECT_FALSE(read_stored(by_column, by_column.recordings[0], 0, why));
  EXPECT_THAT(why, HasSubstr("compressed arrays whose columns stand one after the other"));
  expect_same(
      session_of(folder, "two_lengths.npz",
                 "topic = \"gyro\"\ntime = { column = \"gyro_t\", unit = \"ns\" }\ngyro = { columns = [\"gyro.1\", \"gyro.2\", \"gyro.3\"], " + rate +
                     "\"rad/s\" }\naccel = { columns = [\"gyro.3\", \"gyro.2\", \"gyro.1\"], " + rate + "\"m/s^2\" }\n"));
}

TEST(StoredRecording, LeavesToMemoryWhatIsShortOrHasToBeReadAsAWhole) {
  const TemporaryFolder folder;
  folder.write("log.csv", "t,gx,gy,gz,ax,ay,az\n0.01,1,2,3,4,5,6\n0.02,1,2,3,4,5,6\n");
  const std::string increments =
      "time = { column = \"t\", unit = \"s\" }\ngyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"increment\", unit = \"rad\" }\n"
      "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"increment\", unit = \"m/s\" }\n";
  const Session session = session_of(folder, "log.csv", increments);
  std::string why;
  EXPECT_FALSE(read_stored(session, session.recordings[0], 1'000'000, why));
  EXPECT_EQ(why, "");
  EXPECT_FALSE(read_stored(session, session.recordings[0], 0, why));
  EXPECT_THAT(why, HasSubstr("increments without rate_hz are read as a whole"));
  expect_same(session_of(folder, "log.csv", "rate_hz = 100.0\n" + increments));
}

}  // namespace
}  // namespace imulab
