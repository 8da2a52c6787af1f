// Bags written: what is replaced, and that nothing else changes.
#include "imulab/formats/recording/written/compensated_file.hpp"

#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/recording/reader.hpp"

#include <gmock/gmock.h>

#include "tests/bag_fixture.hpp"
#include "tests/run_command.hpp"
#include <map>
#include <memory>
#include <utility>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

using Messages = std::vector<std::pair<std::int64_t, std::string>>;  // when it was logged, its bytes

std::map<std::string, Messages> all_messages(const fs::path& path) {
  std::map<std::string, Messages> all;
  const auto open = bag::open_bag(path);
  for (const bag::Topic& topic : open->topics())
    open->each_message(topic, [&](std::int64_t log_time, std::string_view message) { all[topic.name].emplace_back(log_time, message); });
  EXPECT_THAT(open->warnings(), testing::IsEmpty());
  return all;
}

RecordingSource imu_source(const std::string& file) {
  RecordingSource source;
  source.file = file;
  source.time.column = "header.stamp";
  source.time.unit = "ns";
  source.gyro.columns = {"angular_velocity.x", "angular_velocity.y", "angular_velocity.z"};
  source.gyro.unit = "rad/s";
  source.accel.columns = {"linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"};
  source.accel.unit = "m/s^2";
  return source;
}

class BagCopies : public testing::TestWithParam<std::string> {
 protected:
  BagCopies() {
    fs::copy_file(bag::fixture(GetParam()), input_);
    session_.file = folder_ / "session.toml";
    session_.recordings = {imu_source(input_.filename().string())};
    compensated_.recording = read_recording(session_, session_.recordings[0]).recording;
  }
  void write() const { write_compensated_bag(output_, session_, session_.recordings[0], compensated_); }

  TemporaryFolder folder_;
  fs::path input_ = folder_ / ("in" + fs::path(GetParam()).extension().string()), output_ = folder_ / ("out" + input_.extension().string());
  Session session_;
  CompensatedRecording compensated_;
};
INSTANTIATE_TEST_SUITE_P(Fixtures, BagCopies, testing::ValuesIn(bag::fixture_names()), [](const auto& file) {
  std::string name = file.param;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
});

TEST_P(BagCopies, HaveTheReadingsReplacedAndNothingElse) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < bag::fixture_samples; ++i) {
      compensated_.recording.gyro[axis][i] = 100 + static_cast<double>(3 * i + axis);
      compensated_.recording.accel[axis][i] = -static_cast<double>(3 * i + axis);
    }
  write();
  const recording_io::TableRows table = bag::read_columns(output_, "/imu0", bag::imu_columns());
  EXPECT_THAT(table.warnings, testing::IsEmpty());
  for (std::size_t i = 0; i < bag::fixture_samples; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(table.columns[3 + axis].numbers[i], 100 + static_cast<double>(3 * i + axis));
      EXPECT_EQ(table.columns[6 + axis].numbers[i], -static_cast<double>(3 * i + axis));
    }

  auto before = all_messages(input_), after = all_messages(output_);
  EXPECT_EQ(after["/cam0"], before["/cam0"]);
  EXPECT_EQ(after["/temp"], before["/temp"]);
  ASSERT_EQ(after["/imu0"].size(), before["/imu0"].size());
  for (std::size_t i = 0; i < after["/imu0"].size(); ++i) {  // 37 numbers at the end: 3 from the 13th, 3 from the 25th are other ones
    auto& [old_time, old] = before["/imu0"][i];
    auto& [time, message] = after["/imu0"][i];
    EXPECT_EQ(time, old_time);
    ASSERT_EQ(message.size(), old.size());
    for (const std::size_t first : {13u, 25u}) old.replace(old.size() - (37 - first) * 8, 24, message, message.size() - (37 - first) * 8, 24);
    EXPECT_EQ(message, old) << i;
  }
}

/// Readings that are repeated give the same file, where a compression does not depend on its program.
TEST_P(BagCopies, OfTheSameReadingsAreTheSame) {
  write();
  const bool packed = GetParam().find("lz4") != std::string::npos || GetParam().find("zstd") != std::string::npos ||
                      GetParam().find("big_endian") != std::string::npos || GetParam() == "imu_ros1.mcap" || GetParam() == "imu_bare.mcap";
  if (packed)
    EXPECT_EQ(all_messages(output_), all_messages(input_));
  else if (output_.extension() == ".db3")  // SQLite counts its transactions in the first page
    EXPECT_EQ(read_text(output_).substr(100), read_text(input_).substr(100));
  else
    EXPECT_TRUE(read_text(output_) == read_text(input_));
}

TEST_P(BagCopies, AppearWholeOrNotAtAll) {
  compensated_.recording.time_ns.pop_back();  // one sample has no partner
  EXPECT_THAT([&] { write(); }, ThrowsMessage<Error>(HasSubstr("1 of 60 messages have no compensated sample")));
  const bag::Topic topic = bag::choose_topic(bag::open_bag(input_)->topics(), "/imu0", "in");
  int changed = 0;
  const auto fail_late = [&](std::span<char>) {
    if (++changed == 50) throw Error("late");
  };
  EXPECT_THROW(
      {
        WholeFile out(output_);
        bag::rewrite_bag(input_, topic, fail_late, out);
      },
      Error);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++files;
  EXPECT_EQ(files, 1u) << "only the input";
}

TEST_P(BagCopies, AreOfTheirOwnKindAndOneTopic) {
  const auto write_to = [&](const std::string& name) { write_compensated_bag(folder_ / name, session_, session_.recordings[0], compensated_); };
  for (const std::string other : {".bag", ".mcap", ".db3"})
    if (other != input_.extension()) {
      EXPECT_THAT([&] { write_to("out" + other); }, ThrowsMessage<Error>(HasSubstr("expected a file *" + input_.extension().string())));
    }
  session_.recordings[0].accel.topic = "/imu1";
  EXPECT_THAT([&] { write(); }, ThrowsMessage<Error>(HasSubstr("not in the messages of one topic")));
}

TEST(CompensatedBag, OfSingleMessagesBesideALargePicture) {
  const TemporaryFolder folder;
  for (const std::string& name : bag::sparse_names()) {
    const fs::path out = folder / name;
    const bag::Topic topic = bag::choose_topic(bag::open_bag(bag::fixture(name))->topics(), "", name);
    const std::array<double, 6> readings{1, 2, 3, 4, 5, 6};
    WholeFile file(out);
    bag::rewrite_bag(
        bag::fixture(name), topic, [&](std::span<char> message) { bag::put_readings(topic.message_encoding(), message, readings); }, file);
    file.commit();
    const recording_io::TableRows table = bag::read_columns(out, "/imu0", bag::imu_columns());
    EXPECT_THAT(table.warnings, testing::IsEmpty());
    for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(table.columns[3 + k].numbers, std::vector<double>(bag::sparse_samples, readings[k]));
    EXPECT_EQ(all_messages(out)["/cam0"], all_messages(bag::fixture(name))["/cam0"]);
  }
}

TEST(CompensatedBag, IsNamedLikeABag) {
  EXPECT_TRUE(is_bag_name("a/run.mcap"));
  EXPECT_TRUE(is_bag_name("run.db3"));
  EXPECT_TRUE(is_bag_name("run.bag"));
  EXPECT_FALSE(is_bag_name("run.csv"));
  EXPECT_FALSE(is_bag_name("bag"));
}

}  // namespace
}  // namespace imulab
