#include "imulab/formats/recording/written/compensated_file.hpp"

#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/archive/zip.hpp"
#include "imulab/formats/recording/bag/folder.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

namespace {

namespace fs = std::filesystem;

/// The format that a file's name says; null for another name.
const RecordingFormat* named_format(const fs::path& path) {
  const std::string extension = path.extension().string();
  const std::vector<RecordingFormat>& formats = recording_formats();
  const auto found = std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) { return f.bag && f.bag->extension == extension; });
  return found != formats.end() ? &*found : nullptr;
}

void expect_format(const fs::path& path, const fs::path& input) {
  const RecordingFormat* format = bag::bag_format(input);
  if (format != nullptr && format->recognizes_path != nullptr)
    throw Error(fmt::format("{}: {} is a bag of several files; expected a .csv file for the compensated recording", path.string(), input.string()));
  if (format != nullptr && format == named_format(path)) return;
  throw Error(fmt::format("{}: {} is {}; expected {} for the compensated recording", path.string(), input.string(),
                          format != nullptr ? fmt::format("a {}", format->name) : "no bag",
                          format != nullptr ? fmt::format("a file *{}", format->bag->extension) : "a .csv file"));
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

bool is_bag_name(const fs::path& path) { return named_format(path) != nullptr; }

void write_compensated_bag(const fs::path& path, const Session& session, const RecordingSource& source, const CompensatedRecording& compensated) {
  const fs::path input = bag::only_part(session_path(session, source.file));
  expect_format(path, input);
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

namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they are in memory");

using recording_io::append;

/// The head of an .npy file, version 1.0: a dictionary padded to a multiple of 64 bytes.
std::string npy_head(std::string_view type, const std::string& shape) {
  std::string dictionary = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, shape);
  constexpr std::size_t magic = 10, multiple = 64;
  dictionary.append((multiple - (magic + dictionary.size() + 1) % multiple) % multiple, ' ');
  dictionary += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  append<std::uint16_t>(head, static_cast<std::uint16_t>(dictionary.size()));
  return head + dictionary;
}

std::string stamps_array(const Recording& recording) {
  std::string array = npy_head("<i8", fmt::format("{},", recording.size()));
  array.append(reinterpret_cast<const char*>(recording.time_ns.data()), recording.size() * sizeof(std::int64_t));
  return array;
}

std::string triad_array(const Columns3& triad, double factor) {
  std::string array = npy_head("<f8", fmt::format("{}, 3", triad[0].size()));
  array.reserve(array.size() + 3 * sizeof(double) * triad[0].size());
  for (std::size_t i = 0; i < triad[0].size(); ++i)
    for (const auto& column : triad) append<double>(array, column[i] * factor);
  return array;
}

std::string flags_array(const std::vector<std::size_t>& samples, std::size_t size) {
  std::string array = npy_head("|b1", fmt::format("{},", size));
  const std::size_t begin = array.size();
  array.append(size, '\0');
  for (const std::size_t i : samples) array[begin + i] = 1;
  return array;
}

}  // namespace

void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& c) {
  const Recording& r = c.recording;
  WholeFile file(path);
  recording_io::ZipWriter archive([&](std::string_view bytes) { file.write(bytes); });
  archive.add("time_ns.npy", stamps_array(r));
  archive.add("gyro.npy", triad_array(r.gyro, r.gyro_increment ? r.interval_s : 1));
  archive.add("accel.npy", triad_array(r.accel, r.accel_increment ? r.interval_s : 1));
  if (!(r.saturated.empty() && c.out_of_range.empty() && c.replaced.empty())) {
    archive.add("saturated.npy", flags_array(r.saturated, r.size()));
    archive.add("out_of_range.npy", flags_array(c.out_of_range, r.size()));
    archive.add("replaced.npy", flags_array(c.replaced, r.size()));
  }
  archive.finish();
  file.commit();
}

}  // namespace imulab
