#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"

#include <fmt/core.h>

#include <map>
#include <span>
#include <string>

namespace imulab::bag {
namespace {

constexpr std::size_t data_in_message = 22;      // after channel, sequence number and two times
constexpr std::size_t crc_in_chunk = 8 + 8 + 8;  // after two times and the size
constexpr std::size_t channel_bytes = 2, index_entry_bytes = 10;

class McapRewriter {
 public:
  McapRewriter(Mcap& bag, const Topic& topic, const MessageChange& change, WholeFile& out)
      : bag_(bag), topic_(topic), change_(change), checked_(data_end_is_checked()), copy_(bag.file(), out, checked_) {}

  void run() {
    for (std::uint64_t at = mcap_magic.size(); at < bag_.data_end();) at = next(at);
    const std::uint64_t footer = bag_.file().size() - mcap_magic.size() - mcap_footer_bytes;
    const std::uint64_t begin = bag_.summary_start() != 0 ? bag_.summary_start() : footer;
    copy_.until(begin);
    std::string tail(bag_.file().read(begin, bag_.file().size() - begin, buffer_));
    change_summary({tail.data(), static_cast<std::size_t>(footer - begin)});
    change_footer({tail.data(), tail.size() - mcap_magic.size()}, static_cast<std::size_t>(footer - begin));
    copy_.put(tail, bag_.file().size());
  }

 private:
  struct NewChunk {
    std::uint64_t length = 0, packed = 0;
  };

  /// True if the data section has a checksum, which its last record holds.
  bool data_end_is_checked() {
    const std::uint64_t at = bag_.data_end() - std::min<std::uint64_t>(bag_.data_end(), mcap_head_bytes + 4);
    const std::string_view record = bag_.file().read(at, bag_.data_end() - at, buffer_);
    return static_cast<McapOp>(record[0]) == McapOp::data_end && load<std::uint32_t>(record.data() + mcap_head_bytes) != 0;
  }

  /// Copies or changes one record, or more that need no look; gives where the next begins.
  std::uint64_t next(std::uint64_t at) {
    const McapRecord record = bag_.record_at(at);
    if (record.end() > bag_.data_end()) throw Damaged("a record reaches into its summary");
    if (record.op == McapOp::chunk) {
      const auto place = bag_.chunks().find(at);
      if (place == bag_.chunks().end() || place->second.may_hold(topic_)) change_chunk(record);
    } else if (record.op == McapOp::message) {
      copy_.until(at);
      std::string bytes(bag_.file().read(at, record.size, buffer_));
      if (change_message({bytes.data() + mcap_head_bytes, bytes.size() - mcap_head_bytes})) copy_.put(bytes, record.end());
    } else if (record.op == McapOp::data_end) {
      copy_.until(at);
      std::string bytes(bag_.file().read(at, record.size, buffer_));
      if (bytes.size() < mcap_head_bytes + 4) throw Damaged("its data section has no end");
      store<std::uint32_t>(bytes.data() + mcap_head_bytes, copy_.crc());
      copy_.put(bytes, record.end());
    }
    return record.end();
  }

  bool change_message(std::span<char> content) {
    if (content.size() < data_in_message) throw Damaged("a message without its head");
    if (!topic_.channels.contains(load<std::uint16_t>(content.data()))) return false;
    change_(content.subspan(data_in_message));
    return true;
  }

  void change_chunk(const McapRecord& record) {
    std::string records(bag_.chunk_records(record));
    bool changed = false;
    each_mcap_record(records, [&](McapOp op, std::size_t at, std::string_view content) {
      if (op == McapOp::message) changed |= change_message({records.data() + at + mcap_head_bytes, content.size()});
    });
    if (!changed) return;
    const std::string_view old = bag_.file().read(record.begin, record.size, buffer_).substr(mcap_head_bytes);
    const McapChunk chunk = mcap_chunk(old);
    const std::string packed = pack(bag_.damage().compression(chunk.compression, record.begin), records);
    std::string bytes(1, static_cast<char>(McapOp::chunk));
    append<std::uint64_t>(bytes, chunk.records + packed.size());
    bytes += old.substr(0, chunk.records);
    if (chunk.crc != 0) store<std::uint32_t>(bytes.data() + mcap_head_bytes + crc_in_chunk, crc32(records));
    store<std::uint64_t>(bytes.data() + bytes.size() - 8, packed.size());
    bytes += packed;
    copy_.until(record.begin);
    copy_.put(bytes, record.end());
    chunks_[record.begin] = {bytes.size(), packed.size()};
  }

  void move(char* place) { store<std::uint64_t>(place, copy_.moved(load<std::uint64_t>(place))); }

  void change_summary(std::span<char> summary) {
    each_mcap_record({summary.data(), summary.size()}, [&](McapOp op, std::size_t at, std::string_view content) {
      char* bytes = summary.data() + at + mcap_head_bytes;
      if (op == McapOp::chunk_index) change_chunk_index(bytes, content);
      if ((op == McapOp::attachment_index || op == McapOp::metadata_index) && content.size() >= 8) move(bytes);
      if (op == McapOp::summary_offset && content.size() >= 9) move(bytes + 1);  // after the kind of its records
    });
  }

  /// First and last time, place and length of the chunk, its message indexes, their length, compression, packed and unpacked size.
  void change_chunk_index(char* bytes, std::string_view content) {
    Bytes fields(content);
    fields.take(16);
    const auto old = chunks_.find(fields.number<std::uint64_t>());
    fields.take(8);
    const std::string_view indexes = fields.counted();
    fields.take(8);
    fields.counted();
    const std::size_t packed_at = content.size() - fields.rest().size();
    fields.take(16);
    for (std::size_t at = 0; at < indexes.size(); at += index_entry_bytes) {
      if (indexes.size() - at < index_entry_bytes) throw Damaged("a chunk index that is cut off");
      move(bytes + (indexes.data() - content.data()) + at + channel_bytes);
    }
    move(bytes + 16);
    if (old == chunks_.end()) return;
    store<std::uint64_t>(bytes + 24, old->second.length);
    store<std::uint64_t>(bytes + packed_at, old->second.packed);
  }

  void change_footer(std::span<char> summary_and_footer, std::size_t footer_at) {
    char* footer = summary_and_footer.data() + footer_at + mcap_head_bytes;
    for (const std::size_t at : {std::size_t{0}, std::size_t{8}})
      if (load<std::uint64_t>(footer + at) != 0) move(footer + at);
    char* crc = footer + 16;
    if (load<std::uint32_t>(crc) != 0) store<std::uint32_t>(crc, crc32({summary_and_footer.data(), summary_and_footer.size() - 4}));
  }

  Mcap& bag_;
  const Topic& topic_;
  const MessageChange& change_;
  Buffer buffer_;
  bool checked_;
  Copy copy_;
  std::map<std::uint64_t, NewChunk> chunks_;
};

}  // namespace

void rewrite_mcap(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  Mcap bag(in);
  if (!bag.complete() || bag.damage().any())
    throw Error(fmt::format("{}: was not closed or is damaged; expected a whole bag: repair it with mcap recover", in.string()));
  try {
    McapRewriter(bag, topic, change, out).run();
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {}; expected a whole bag: repair it with mcap recover", in.string(), e.what()));
  }
}

}  // namespace imulab::bag
