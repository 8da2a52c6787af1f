// Reading a bag. Target: half the speed of copying what its chunks hold, so that a bag costs little more than its bytes.
#include "imulab/files.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/table_reader.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>

namespace {

using namespace imulab;
using namespace imulab::bag;

constexpr std::size_t messages_in_chunk = 11000, chunks = 24;  // 4 MB each, as recorders write them

void append_text(std::string& out, std::string_view text) {
  append<std::uint32_t>(out, text.size());
  out += text;
}

void append_record(std::string& out, McapOp op, const std::string& content) {
  out += static_cast<char>(op);
  append<std::uint64_t>(out, content.size());
  out += content;
}

/// Record of a message of sensor_msgs/msg/Imu.
void append_message(std::string& out, std::size_t i) {
  std::string message;
  append<std::uint16_t>(message, 1);
  append<std::uint32_t>(message, i);
  for (int k = 0; k < 2; ++k) append<std::uint64_t>(message, 5'000'000 * i);
  message.append("\0\1\0\0", 4);
  append<std::int32_t>(message, static_cast<std::int32_t>(i / 200));
  append<std::uint32_t>(message, static_cast<std::uint32_t>(i % 200 * 5'000'000));
  append_text(message, std::string_view("imu\0", 4));
  for (std::size_t k = 0; k < 37; ++k) append<double>(message, k >= 13 && k < 28 ? std::sin(0.01 * static_cast<double>(i + k)) : 0);
  append_record(out, McapOp::message, message);
}

/// A file of about 100 MB, removed at the end.
class Example {
 public:
  explicit Example(const std::string& compression) {
    std::string file(mcap_magic), summary;
    append_record(file, static_cast<McapOp>(1), std::string(8, '\0'));
    std::string schema, channel;
    append<std::uint16_t>(schema, 1);
    for (const char* text : {"sensor_msgs/msg/Imu", "ros2msg", ""}) append_text(schema, text);
    for (int k = 0; k < 2; ++k) append<std::uint16_t>(channel, 1);
    for (const char* text : {"/imu0", "cdr", ""}) append_text(channel, text);
    append_record(summary, McapOp::schema, schema);
    append_record(summary, McapOp::channel, channel);
    for (std::size_t c = 0; c < chunks; ++c) append_chunk(file, summary, c, compression);
    std::string end, footer;
    append<std::uint32_t>(end, 0);
    append_record(file, McapOp::data_end, end);
    append<std::uint64_t>(footer, file.size());
    footer.append(12, '\0');
    file += summary;
    append_record(file, McapOp::footer, footer);
    write_whole(path_, file += mcap_magic);
  }
  ~Example() { std::filesystem::remove(path_); }
  Example(const Example&) = delete;
  Example& operator=(const Example&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::int64_t bytes() const { return static_cast<std::int64_t>(unpacked_); }

 private:
  void append_chunk(std::string& file, std::string& summary, std::size_t number, const std::string& compression) {
    std::string records, chunk(16, '\0'), index(16, '\0');
    for (std::size_t i = 0; i < messages_in_chunk; ++i) append_message(records, number * messages_in_chunk + i);
    unpacked_ += records.size();
    const std::string packed = pack(compression_of(compression), records);
    append<std::uint64_t>(chunk, records.size());
    append<std::uint32_t>(chunk, crc32(records));
    append_text(chunk, compression);
    append<std::uint64_t>(chunk, packed.size());
    chunk += packed;
    append<std::uint64_t>(index, file.size());
    append<std::uint64_t>(index, mcap_head_bytes + chunk.size());
    append_text(index, "");
    append<std::uint64_t>(index, 0);
    append_text(index, compression);
    append<std::uint64_t>(index, packed.size());
    append<std::uint64_t>(index, records.size());
    append_record(file, McapOp::chunk, chunk);
    append_record(summary, McapOp::chunk_index, index);
  }

  std::filesystem::path path_ = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()) + ".mcap");
  std::size_t unpacked_ = 0;
};

void copy_chunks(benchmark::State& state, const std::string& compression) {  // the measure: unpacked, and copied once
  const Example example(compression);
  Buffer packed, unpacked, copy;
  for (auto _ : state) {
    const Mcap bag(example.path());
    for (const auto& [at, place] : bag.chunks()) {
      const std::string_view content = bag.file().read(at, place.length, packed).substr(mcap_head_bytes);
      const McapChunk chunk = mcap_chunk(content);
      const std::string_view records =
          unpack(compression_of(chunk.compression), content.substr(chunk.records, chunk.packed_size), chunk.size, unpacked);
      std::memcpy(copy.of(records.size()), records.data(), records.size());
      benchmark::ClobberMemory();
    }
  }
  state.SetBytesProcessed(state.iterations() * example.bytes());
}
BENCHMARK_CAPTURE(copy_chunks, none, "")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(copy_chunks, lz4, "lz4")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(copy_chunks, zstd, "zstd")->Unit(benchmark::kMillisecond);

void read_bag(benchmark::State& state, const std::string& compression) {  // stamps and six readings; >= half of copy_chunks
  const Example example(compression);
  const TableRequest request{example.path(), "/imu0", ""};
  const std::vector<Column> columns{"header.stamp",          "angular_velocity.x",    "angular_velocity.y",   "angular_velocity.z",
                                    "linear_acceleration.x", "linear_acceleration.y", "linear_acceleration.z"};
  for (auto _ : state) {
    const recording_io::TableRows table = recording_io::read_columns(request, columns);
    if (table.columns[0].size() != chunks * messages_in_chunk) state.SkipWithError("messages are missing");
  }
  state.SetBytesProcessed(state.iterations() * example.bytes());
}
BENCHMARK_CAPTURE(read_bag, none, "")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bag, lz4, "lz4")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_bag, zstd, "zstd")->Unit(benchmark::kMillisecond);

}  // namespace
