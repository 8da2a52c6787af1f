#include "imulab/formats/recording/bag/write_mcap.hpp"

#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"

#include <algorithm>

namespace imulab::bag {
namespace {

constexpr std::uint8_t header_op = 1;
constexpr std::uint16_t number = 1;  // of the schema, and of the channel
constexpr std::size_t chunk_bytes = 1 << 20;

void append_text(std::string& out, std::string_view text) {
  append<std::uint32_t>(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

void append_record(std::string& out, std::uint8_t op, std::string_view content) {
  out += static_cast<char>(op);
  append<std::uint64_t>(out, content.size());
  out += content;
}
void append_record(std::string& out, McapOp op, std::string_view content) { append_record(out, static_cast<std::uint8_t>(op), content); }

std::string channel_records(const NewTopic& topic) {
  std::string out, schema, channel;
  append<std::uint16_t>(schema, number);
  append_text(schema, topic.type), append_text(schema, "ros2msg"), append_text(schema, topic.definition);
  append_record(out, McapOp::schema, schema);
  append<std::uint16_t>(channel, number), append<std::uint16_t>(channel, number);
  append_text(channel, topic.name), append_text(channel, "cdr"), append_text(channel, "");
  append_record(out, McapOp::channel, channel);
  return out;
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, const NewTopic& topic)
    : file_(path), channel_(channel_records(topic)), compression_(compression_of_new_bags()) {
  std::string head(mcap_magic), content;
  append_text(content, "ros2"), append_text(content, "imulab");
  append_record(head, header_op, content);
  put(head);
  records_ = channel_;
}

void McapWriter::put(std::string_view bytes) {
  file_.write(bytes);
  written_ += bytes.size();
}

void McapWriter::add(std::int64_t time, std::string_view cdr) {
  std::string content;
  append<std::uint16_t>(content, number);
  append<std::uint32_t>(content, static_cast<std::uint32_t>(messages_++));
  append<std::int64_t>(content, time), append<std::int64_t>(content, time);
  content += cdr;
  index_.emplace_back(time, records_.size());
  append_record(records_, McapOp::message, content);
  if (records_.size() > chunk_bytes) write_chunk();
}

void McapWriter::write_chunk() {
  if (index_.empty()) return;
  const auto [first, last] = std::ranges::minmax_element(index_);
  Chunk chunk{.first = first->first, .last = last->first, .place = written_, .size = records_.size()};
  const std::string packed = pack(compression_of(compression_), records_);
  chunk.packed = packed.size();
  std::string content, record, offsets, index;
  append<std::int64_t>(content, chunk.first), append<std::int64_t>(content, chunk.last);
  append<std::uint64_t>(content, chunk.size), append<std::uint32_t>(content, crc32(records_));
  append_text(content, compression_);
  append<std::uint64_t>(content, packed.size());
  append_record(record, McapOp::chunk, content += packed);
  chunk.length = record.size();
  for (const auto& [time, at] : index_) append<std::int64_t>(offsets, time), append<std::uint64_t>(offsets, at);
  append<std::uint16_t>(index, number);
  append_text(index, offsets);
  const std::size_t before = record.size();
  append_record(record, McapOp::message_index, index);
  chunk.index_length = record.size() - before;
  put(record);
  chunks_.push_back(chunk);
  records_.clear(), index_.clear();
}

std::string McapWriter::summary_of(const Chunk& c) const {
  std::string out;
  append<std::int64_t>(out, c.first), append<std::int64_t>(out, c.last);
  append<std::uint64_t>(out, c.place), append<std::uint64_t>(out, c.length);
  append<std::uint32_t>(out, sizeof(std::uint16_t) + sizeof(std::uint64_t));
  append<std::uint16_t>(out, number), append<std::uint64_t>(out, c.place + c.length);  // of its message index
  append<std::uint64_t>(out, c.index_length);
  append_text(out, compression_);
  append<std::uint64_t>(out, c.packed), append<std::uint64_t>(out, c.size);
  return out;
}

void McapWriter::commit() {
  write_chunk();
  std::string tail, footer, statistics;
  append_record(tail, McapOp::data_end, std::string(4, '\0'));  // without a checksum
  const std::uint64_t summary = written_ + tail.size();
  tail += channel_;
  for (const Chunk& chunk : chunks_) append_record(tail, McapOp::chunk_index, summary_of(chunk));
  append<std::uint64_t>(statistics, messages_), append<std::uint16_t>(statistics, 1), append<std::uint32_t>(statistics, 1);
  append<std::uint32_t>(statistics, 0), append<std::uint32_t>(statistics, 0);  // attachments, metadata
  append<std::uint32_t>(statistics, static_cast<std::uint32_t>(chunks_.size()));
  append<std::int64_t>(statistics, chunks_.empty() ? 0 : std::ranges::min_element(chunks_, {}, &Chunk::first)->first);
  append<std::int64_t>(statistics, chunks_.empty() ? 0 : std::ranges::max_element(chunks_, {}, &Chunk::last)->last);
  append<std::uint32_t>(statistics, sizeof(std::uint16_t) + sizeof(std::uint64_t));
  append<std::uint16_t>(statistics, number), append<std::uint64_t>(statistics, messages_);
  append_record(tail, McapOp::statistics, statistics);
  append<std::uint64_t>(footer, summary), append<std::uint64_t>(footer, 0), append<std::uint32_t>(footer, 0);
  append_record(tail, McapOp::footer, footer);
  put(tail += mcap_magic);
  file_.commit();
}

}  // namespace imulab::bag
