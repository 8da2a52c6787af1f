// MCAP files (https://mcap.dev/spec, version 0): ROS 2 bags, and ROS 1 bags converted.
#pragma once

#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/text/file.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::bag {

constexpr std::string_view mcap_magic("\x89MCAP0\r\n", 8);

/// Kinds of records.
enum class McapOp : std::uint8_t {
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  chunk_index = 8,
  attachment_index = 10,
  statistics = 11,
  metadata_index = 13,
  summary_offset = 14,
  data_end = 15
};

constexpr std::uint64_t mcap_head_bytes = 9;     // of a record: its kind, the length of its content
constexpr std::uint64_t mcap_footer_bytes = 29;  // the whole record

struct McapRecord {
  McapOp op{};
  std::uint64_t begin = 0, size = 0;  ///< in the file, with its head

  std::uint64_t end() const { return begin + size; }
};

/// Where a chunk is, and what the summary says of it.
struct McapChunkPlace {
  std::uint64_t length = 0, index_length = 0;        ///< of the record; of the message indexes behind it
  std::map<std::uint16_t, std::uint64_t> indexes{};  ///< the message index of each channel in it; empty where there are none

  bool may_hold(const Topic& topic) const;
};

/// The content of a chunk, packed.
struct McapChunk {
  std::uint64_t size = 0;  ///< unpacked
  std::uint32_t crc = 0;   ///< 0: not computed
  std::string_view compression;
  std::uint64_t records = 0, packed_size = 0;  ///< where they begin in the record's content; packed
};

/// Reads the first bytes of a chunk's content.
McapChunk mcap_chunk(std::string_view content);

/// Calls with each record of a chunk's or summary's bytes: its kind, where it begins in `bytes`, and its content. Throws Damaged.
void each_mcap_record(std::string_view bytes, const std::function<void(McapOp, std::size_t, std::string_view)>& sink);

class Mcap : public Bag {
 public:
  /// Throws Error for a file that is no MCAP.
  explicit Mcap(const std::filesystem::path& path);

  void each_message(const Topic& topic, const MessageSink& sink) override;

  void count_messages() override;

  const ByteFile& file() const { return file_; }
  bool complete() const { return footer_.has_value(); }
  std::uint64_t summary_start() const { return footer_ ? (*footer_)[0] : 0; }  ///< 0 without one
  std::uint64_t data_end() const { return data_end_; }                         ///< where summary or footer begin, or the file ends
  const std::map<std::uint64_t, McapChunkPlace>& chunks() const { return chunks_; }
  const Damage& damage() const { return damage_; }
  /// The record at a place. Throws Damaged where it is cut off.
  McapRecord record_at(std::uint64_t place);
  /// The records of a chunk, unpacked and checked; valid until the next call. Throws Damaged, and Error for its compression.
  std::string_view chunk_records(const McapRecord& record);

 private:
  bool read_summary();
  void scan();
  void scan_chunk(const McapRecord& record);
  void take(McapOp op, std::string_view content);
  void take_records(std::string_view records);
  void count_message(std::uint16_t channel);
  std::string_view message_head(const McapRecord& record);
  void read_chunk(const McapRecord& record, const McapChunkPlace* place, const Topic& topic, const MessageSink& sink);
  bool read_by_index(const McapRecord& record, const McapChunkPlace& place, const Topic& topic, const MessageSink& sink);

  ByteFile file_;
  Damage damage_;
  std::optional<std::array<std::uint64_t, 2>> footer_;  // where the summary and its offsets begin
  std::uint64_t data_end_ = 0;
  std::map<std::uint16_t, std::string> schemas_;  // names
  std::map<std::uint64_t, McapChunkPlace> chunks_;
  bool counted_ = false;         // the summary says how many messages there are
  bool unknown_schema_ = false;  // a channel came before its schema, or without
  Buffer packed_, unpacked_, small_;
};

void rewrite_mcap(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

}  // namespace imulab::bag
