#include "imulab/formats/recording/bag/mcap.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab::bag {
namespace {

constexpr std::uint64_t small_read = 1024;    // enough for the head of a chunk, and for most messages
constexpr std::uint64_t sparse_bytes = 8192;  // a message singly is worth as many bytes read in a row
constexpr std::uint64_t message_head_bytes = 22;

struct MessageView {
  std::uint16_t channel;
  std::int64_t log_time;
  std::string_view data;
};

MessageView message_of(std::string_view content) {
  if (content.size() < message_head_bytes) throw Damaged("a message without its head");
  return {load<std::uint16_t>(content.data()), load<std::int64_t>(content.data() + 6), content.substr(message_head_bytes)};
}

}  // namespace

bool McapChunkPlace::may_hold(const Topic& topic) const {
  return indexes.empty() || std::any_of(indexes.begin(), indexes.end(), [&](const auto& index) { return topic.channels.contains(index.first); });
}

McapChunk mcap_chunk(std::string_view content) {
  Bytes bytes(content);
  bytes.take(16);  // first and last time
  McapChunk chunk;
  chunk.size = bytes.number<std::uint64_t>();
  chunk.crc = bytes.number<std::uint32_t>();
  chunk.compression = bytes.counted();
  chunk.packed_size = bytes.number<std::uint64_t>();
  chunk.records = content.size() - bytes.rest().size();
  return chunk;
}

void each_mcap_record(std::string_view records, const std::function<void(McapOp, std::size_t, std::string_view)>& sink) {
  for (std::size_t at = 0; at < records.size();) {
    if (records.size() - at < mcap_head_bytes) throw Damaged("a record without its head");
    const auto size = load<std::uint64_t>(records.data() + at + 1);
    if (size > records.size() - at - mcap_head_bytes) throw Damaged("a record's length points beyond the end");
    sink(static_cast<McapOp>(records[at]), at, records.substr(at + mcap_head_bytes, static_cast<std::size_t>(size)));
    at += static_cast<std::size_t>(mcap_head_bytes + size);
  }
}

Mcap::Mcap(const std::filesystem::path& path) : file_(path), damage_(path.string()), data_end_(file_.size()) {
  try {
    if (file_.read(0, mcap_magic.size(), small_) != mcap_magic) throw Damaged("other first bytes");
  } catch (const Damaged&) {
    throw Error(path.string() + ": is no MCAP file of version 0; expected one");
  }
  if (read_summary()) return;
  if (!footer_ && !damage_.any_index()) damage_.index("was not closed and has no summary");
  scan();
}

/// False where there is none, or none that tells topics and chunks.
bool Mcap::read_summary() {
  const std::uint64_t tail_bytes = mcap_footer_bytes + mcap_magic.size();
  if (file_.size() < mcap_magic.size() + tail_bytes) return false;
  const std::uint64_t footer_at = file_.size() - tail_bytes;
  const std::string_view tail = file_.read(footer_at, tail_bytes, small_);
  if (!tail.ends_with(mcap_magic) || static_cast<McapOp>(tail[0]) != McapOp::footer || load<std::uint64_t>(tail.data() + 1) != 20) return false;
  const auto begin = load<std::uint64_t>(tail.data() + 9), offsets = load<std::uint64_t>(tail.data() + 17);
  const auto crc = load<std::uint32_t>(tail.data() + 25);
  const std::string covered(tail.substr(0, mcap_footer_bytes - 4));
  footer_ = {begin, offsets};
  data_end_ = footer_at;
  if (begin == 0) return false;
  try {
    if (begin < mcap_magic.size() || begin > footer_at) throw Damaged("the footer points outside the file");
    const std::string_view summary = file_.read(begin, footer_at - begin, packed_);
    if (crc != 0 && crc32(covered, crc32(summary)) != crc) throw Damaged("the summary's checksum is wrong");
    each_mcap_record(summary, [this](McapOp op, std::size_t, std::string_view content) { take(op, content); });
    data_end_ = begin;
  } catch (const Damaged& e) {
    damage_.index(e.what());
    footer_.reset();
    topics_.clear(), schemas_.clear(), chunks_.clear();
    counted_ = unknown_schema_ = false;
    return false;
  }
  if (!topics_.empty() && !unknown_schema_ && (counted_ || !chunks_.empty())) return true;
  topics_.clear();
  counted_ = unknown_schema_ = false;
  return false;
}

/// A record of the summary, of a chunk or between chunks.
void Mcap::take(McapOp op, std::string_view content) {
  Bytes bytes(content);
  if (op == McapOp::schema) {
    const auto id = bytes.number<std::uint16_t>();
    schemas_.emplace(id, bytes.counted());
  } else if (op == McapOp::channel) {
    const auto id = bytes.number<std::uint16_t>();
    const auto schema_id = bytes.number<std::uint16_t>();
    const auto schema = schemas_.find(schema_id);
    unknown_schema_ |= schema_id != 0 && schema == schemas_.end();  // 0: none
    const std::string_view topic = bytes.counted(), encoding = bytes.counted();
    add_channel(topics_, id, topic, schema != schemas_.end() ? schema->second : "", encoding);
  } else if (op == McapOp::chunk_index) {
    bytes.take(16);
    const auto at = bytes.number<std::uint64_t>();
    McapChunkPlace place;
    place.length = bytes.number<std::uint64_t>();
    for (Bytes entries(bytes.counted()); !entries.empty();) {
      const auto channel = entries.number<std::uint16_t>();
      place.indexes[channel] = entries.number<std::uint64_t>();
    }
    place.index_length = bytes.number<std::uint64_t>();
    chunks_[at] = std::move(place);
  } else if (op == McapOp::statistics) {
    bytes.take(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8);
    for (Bytes entries(bytes.counted()); !entries.empty();) {
      Topic* topic = topic_of(topics_, entries.number<std::uint16_t>());
      const auto messages = entries.number<std::uint64_t>();
      if (topic != nullptr) topic->messages += messages, counted_ = true;
    }
  }
}

McapRecord Mcap::record_at(std::uint64_t place) {
  const std::string_view head = file_.read(place, mcap_head_bytes, small_);
  const auto size = load<std::uint64_t>(head.data() + 1);
  if (size > file_.size() - place - mcap_head_bytes) throw Damaged("a record is cut off");
  return {static_cast<McapOp>(head[0]), place, mcap_head_bytes + size};
}

std::string_view Mcap::chunk_records(const McapRecord& record) {
  const std::string_view content = file_.read(record.begin, record.size, packed_).substr(mcap_head_bytes);
  const McapChunk chunk = mcap_chunk(content);
  Bytes packed(content.substr(chunk.records));
  const std::string_view records =
      unpack(damage_.compression(chunk.compression, record.begin), packed.take(chunk.packed_size), chunk.size, unpacked_, file_.path().string());
  if (chunk.crc != 0 && crc32(records) != chunk.crc) throw Damaged("its checksum is wrong");
  return records;
}

/// Learns topics and chunks from the whole file, which has no summary that tells them.
void Mcap::scan() {
  for (std::uint64_t at = mcap_magic.size(); at < data_end_;) {
    try {
      const McapRecord record = record_at(at);
      if (record.op == McapOp::data_end || record.op == McapOp::footer) {
        data_end_ = at;
        break;
      }
      if (record.op == McapOp::chunk) scan_chunk(record);
      if (record.op == McapOp::schema || record.op == McapOp::channel) take_records(file_.read(at, record.size, packed_));
      if (record.op == McapOp::message) count_message(message_of(message_head(record)).channel);
      at = record.end();
    } catch (const Damaged& e) {
      damage_.end(at, e.what());
      data_end_ = at;
    }
  }
  counted_ = true;
}

void Mcap::scan_chunk(const McapRecord& record) {
  try {
    take_records(chunk_records(record));
  } catch (const Damaged& e) {
    damage_.chunk(record.begin, e.what());
  }
}

void Mcap::take_records(std::string_view records) {
  each_mcap_record(records, [this](McapOp op, std::size_t, std::string_view content) {
    op == McapOp::message ? count_message(message_of(content).channel) : take(op, content);
  });
}

void Mcap::count_message(std::uint16_t channel) {
  Topic* topic = topic_of(topics_, channel);
  if (topic != nullptr && !counted_) ++topic->messages;
}

/// The first bytes of a message's content.
std::string_view Mcap::message_head(const McapRecord& record) {
  return file_.read(record.begin, std::min(record.size, mcap_head_bytes + message_head_bytes), small_).substr(mcap_head_bytes);
}

void Mcap::count_messages() {
  if (counted_) return;
  for (Topic& topic : topics_) {
    std::uint64_t messages = 0;
    each_message(topic, [&](std::int64_t, std::string_view) { ++messages; });
    topic.messages = messages;
  }
}

void Mcap::each_message(const Topic& topic, const MessageSink& sink) {
  for (std::uint64_t at = mcap_magic.size(); at < data_end_;) {
    const auto place = chunks_.find(at);
    try {
      const McapRecord record = record_at(at);
      std::uint64_t next = record.end();
      if (record.op == McapOp::chunk) {
        const bool known = place != chunks_.end() && place->second.length == record.size;
        if (known && place->second.index_length <= data_end_ - std::min(data_end_, next)) next += place->second.index_length;
        if (!known || place->second.may_hold(topic)) read_chunk(record, known ? &place->second : nullptr, topic, sink);
      } else if (record.op == McapOp::message) {
        if (topic.channels.contains(message_of(message_head(record)).channel)) {
          const MessageView message = message_of(file_.read(at, record.size, packed_).substr(mcap_head_bytes));
          sink(message.log_time, message.data);
        }
      } else if (record.op == McapOp::data_end || record.op == McapOp::footer) {
        break;
      }
      at = next;
    } catch (const Damaged& e) {
      damage_.end(at, e.what());
      break;
    }
  }
  warnings_ = damage_.warnings();
}

void Mcap::read_chunk(const McapRecord& record, const McapChunkPlace* place, const Topic& topic, const MessageSink& sink) {
  try {
    if (place != nullptr && read_by_index(record, *place, topic, sink)) return;
    each_mcap_record(chunk_records(record), [&](McapOp op, std::size_t, std::string_view content) {
      if (op != McapOp::message) return;
      const MessageView message = message_of(content);
      if (topic.channels.contains(message.channel)) sink(message.log_time, message.data);
    });
  } catch (const Damaged& e) {
    damage_.chunk(record.begin, e.what());
  }
}

/// Reads messages one by one out of a chunk that is not compressed and holds much else; its checksum remains unknown. False where it is not such a
/// one.
bool Mcap::read_by_index(const McapRecord& record, const McapChunkPlace& place, const Topic& topic, const MessageSink& sink) {
  const McapChunk chunk = mcap_chunk(file_.read_some(record.begin, std::min(record.size, small_read), small_).substr(mcap_head_bytes));
  const std::uint64_t begin = record.begin + mcap_head_bytes + chunk.records;
  if (damage_.compression(chunk.compression, record.begin) != Compression::none || chunk.size > record.end() - begin) return false;
  std::vector<std::uint64_t> offsets;
  for (const auto& [channel, at] : place.indexes) {
    if (!topic.channels.contains(channel)) continue;
    const McapRecord index = record_at(at);
    if (index.op != McapOp::message_index) return false;
    Bytes content(file_.read(at, index.size, packed_).substr(mcap_head_bytes));
    if (content.number<std::uint16_t>() != channel) return false;
    for (Bytes entries(content.counted()); !entries.empty();) {
      entries.take(8);
      offsets.push_back(entries.number<std::uint64_t>());
    }
  }
  if (offsets.empty() || offsets.size() * sparse_bytes > chunk.size) return false;
  std::sort(offsets.begin(), offsets.end());
  for (const std::uint64_t offset : offsets) {
    if (offset >= chunk.size) throw Damaged("an index points outside");
    std::string_view bytes = file_.read(begin + offset, std::min(small_read, chunk.size - offset), small_);
    Bytes head(bytes);
    const auto op = static_cast<McapOp>(head.number<std::uint8_t>());
    const auto size = head.number<std::uint64_t>();
    if (op != McapOp::message || size > chunk.size - offset - mcap_head_bytes) throw Damaged("an index points to no message");
    if (size > head.rest().size()) bytes = file_.read(begin + offset, mcap_head_bytes + size, small_);
    const MessageView message = message_of(bytes.substr(mcap_head_bytes, static_cast<std::size_t>(size)));
    if (!topic.channels.contains(message.channel)) throw Damaged("an index points to a message of another topic");
    sink(message.log_time, message.data);
  }
  return true;
}

}  // namespace imulab::bag

imulab::RecordingFormat imulab::recording_io::mcap_format() {
  static constexpr bag::BagFormat format{".mcap", bag::opened<bag::Mcap>, bag::rewrite_mcap};
  return bag::bag_row(
      "ROS 2 bag in MCAP", [](std::string_view head) { return head.starts_with(bag::mcap_magic.substr(0, 5)); }, format);
}
