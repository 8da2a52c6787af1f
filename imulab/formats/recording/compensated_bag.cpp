#include "imulab/formats/recording/compensated_bag.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/bag/kinds.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"
#include "imulab/formats/recording/bag/ros1_bag.hpp"
#include "imulab/formats/recording/bag/ros2_database.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/compensate_recording.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// The kind that a file's name says; null for another name.
const bag::BagKind* named_kind(const fs::path& path) {
  const std::string extension = path.extension().string();
  const auto found =
      std::find_if(bag::bag_kinds().begin(), bag::bag_kinds().end(), [&](const bag::BagKind& kind) { return kind.extension == extension; });
  return found != bag::bag_kinds().end() ? &*found : nullptr;
}

void expect_kind(const fs::path& path, const fs::path& input) {
  const bag::BagKind* kind = bag::kind_of(input);
  if (kind != nullptr && kind == named_kind(path)) return;
  throw Error(fmt::format("{}: {} is {}; expected {} for the compensated recording", path.string(), input.string(),
                          kind != nullptr ? fmt::format("a {}", kind->name) : "no bag",
                          kind != nullptr ? fmt::format("a file *{}", kind->extension) : "a .csv file"));
}

/// Both triads are in the messages of one topic, as rates.
void expect_one_topic(const RecordingSource& source, const fs::path& path) {
  const auto own = [&](const TriadSource& triad) {
    return triad.file.value_or(source.file) != source.file || triad.topic.value_or(source.topic) != source.topic ||
           triad.time.value_or(source.time) != source.time;
  };
  if (own(source.gyro) || own(source.accel))
    throw Error(fmt::format("{}: gyros and accelerometers of {} are not in the messages of one topic; expected one, or a .csv file", path.string(),
                            source.file));
  if (source.gyro.output == Output::increment || source.accel.output == Output::increment)
    throw Error(fmt::format("{}: the session has increments, and messages have rates; expected output = \"rate\", or a .csv file", path.string()));
}

/// For each message its compensated sample. A message that repeats the one before has the same.
std::vector<std::size_t> samples_of(const std::vector<std::int64_t>& stamps, const Recording& recording, const fs::path& path) {
  std::vector<std::size_t> samples;
  samples.reserve(stamps.size());
  std::size_t missing = 0;
  for (const std::int64_t stamp : stamps) {
    const auto at = std::lower_bound(recording.time_ns.begin(), recording.time_ns.end(), stamp);
    if (at == recording.time_ns.end() || *at != stamp) ++missing;
    samples.push_back(static_cast<std::size_t>(at - recording.time_ns.begin()));
  }
  if (missing > 0)
    throw Error(
        fmt::format("{}: {} of {} messages have no compensated sample, since they have no partner in another table (a temperature); expected a "
                    "table that covers all messages, or a .csv file",
                    path.string(), missing, stamps.size()));
  return samples;
}

}  // namespace

bool is_bag_name(const fs::path& path) { return named_kind(path) != nullptr; }

void write_compensated_bag(const fs::path& path, const Session& session, const RecordingSource& source, const CompensatedRecording& compensated) {
  const fs::path input = session_path(session, source.file);
  expect_kind(path, input);
  expect_one_topic(source, path);
  const bag::Topic topic = bag::choose_topic(bag::open_bag(input)->topics(), source.topic, input.string());
  if (!bag::is_imu(topic.type))
    throw Error(fmt::format("{}: topic {} has messages of {}; expected sensor_msgs/Imu", path.string(), topic.name, topic.type));
  const Recording& recording = compensated.recording;
  const std::vector<std::size_t> samples =
      samples_of(recording_io::read_stamps({input, source.topic, source.layout}, source.time, source.rate_hz), recording, path);

  std::size_t next = 0;
  const auto replace = [&](std::span<char> message) {
    if (next == samples.size()) throw Error(input.string() + ": changed while it was read; expected it to stay");
    const std::size_t i = samples[next++];
    const std::array<double, 6> readings{recording.gyro[0][i],  recording.gyro[1][i],  recording.gyro[2][i],
                                         recording.accel[0][i], recording.accel[1][i], recording.accel[2][i]};
    bag::put_readings(topic.message_encoding(), message, readings);
  };
  WholeFile out(path);
  bag::rewrite_bag(input, topic, replace, out);
  if (next != samples.size()) throw Error(input.string() + ": changed while it was read, or is damaged; expected a whole bag");
  out.commit();
}

}  // namespace imulab
