#include "imulab/formats/recording/compensated_npz.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/crc32.hpp"
#include "imulab/formats/recording/number_bytes.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/compensate_recording.hpp"

#include <fmt/core.h>

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {
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

/// A zip archive (PKWARE APPNOTE 6.3) of members that are stored.
class ZipWriter {
 public:
  ZipWriter(WholeFile& file, std::string name) : file_(file), name_(std::move(name)) {}

  void add(const std::string& name, const std::string& content) {
    const auto check = recording_io::crc32(content);
    const std::uint64_t end = offset_ + content.size() + name.size() + local_head;
    if (end > UINT32_MAX) throw Error(name_ + ": more than 4 GB do not fit into .npz; expected .csv");
    std::string head("PK\x03\x04", 4);
    const std::string common = description(name, content.size(), check);
    head += common + name;
    directory_ += std::string("PK\x01\x02", 4);
    append<std::uint16_t>(directory_, 20);  // made by version 2.0
    directory_ += common;
    directory_.append(10, '\0');  // comment, disk, attributes
    append<std::uint32_t>(directory_, static_cast<std::uint32_t>(offset_));
    directory_ += name;
    file_.write(head);
    file_.write(content);
    offset_ += head.size() + content.size();
    ++members_;
  }
  void finish() {
    std::string end("PK\x05\x06\0\0\0\0", 8);
    append<std::uint16_t>(end, members_);
    append<std::uint16_t>(end, members_);
    append<std::uint32_t>(end, static_cast<std::uint32_t>(directory_.size()));
    append<std::uint32_t>(end, static_cast<std::uint32_t>(offset_));
    append<std::uint16_t>(end, 0);
    file_.write(directory_ + end);
  }

 private:
  static constexpr std::size_t local_head = 30;

  /// What a member's own head and the directory have in common.
  static std::string description(const std::string& name, std::size_t size, std::uint32_t check) {
    std::string out;
    constexpr std::uint16_t words[] = {20, 0, 0, 0, 0x21};
    for (const std::uint16_t word : words) append<std::uint16_t>(out, word);  // version 2.0, no flags, stored, 1980-01-01
    append<std::uint32_t>(out, check);
    append<std::uint32_t>(out, static_cast<std::uint32_t>(size));
    append<std::uint32_t>(out, static_cast<std::uint32_t>(size));
    append<std::uint16_t>(out, static_cast<std::uint16_t>(name.size()));
    append<std::uint16_t>(out, 0);
    return out;
  }

  WholeFile& file_;
  std::string name_;
  std::string directory_;
  std::uint64_t offset_ = 0;
  std::uint16_t members_ = 0;
};

}  // namespace

void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& c) {
  const Recording& r = c.recording;
  WholeFile file(path);
  ZipWriter archive(file, path.string());
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
