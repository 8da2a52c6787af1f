#include "imulab/formats/recording/bag/ros1_bag.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/byte_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace imulab::bag {
namespace {

constexpr std::uint64_t small_record = 512;     // enough for most headers, and most messages
constexpr std::uint64_t sparse_message = 8192;  // a message singly is worth as many bytes read in a row

/// The value of a field; nothing where it is not there.
std::optional<std::string_view> field_of(std::string_view bytes, std::string_view name) {
  for (Bytes rest(bytes); !rest.empty();) {
    const std::string_view field = rest.counted();
    if (field.size() > name.size() && field[name.size()] == '=' && field.starts_with(name)) return field.substr(name.size() + 1);
  }
  return std::nullopt;
}

std::int64_t nanoseconds_at(const char* bytes) { return std::int64_t{load<std::uint32_t>(bytes)} * 1'000'000'000 + load<std::uint32_t>(bytes + 4); }

}  // namespace

std::string_view Ros1Fields::text(std::string_view name) const {
  const auto value = field_of(bytes_, name);
  if (!value) throw Damaged("a record without the field " + std::string(name));
  return *value;
}

bool Ros1Fields::has(std::string_view name) const { return field_of(bytes_, name).has_value(); }

std::int64_t Ros1Fields::time_ns(std::string_view name) const {
  const std::string_view value = text(name);
  if (value.size() != 8) throw Damaged("a time of another length");
  return nanoseconds_at(value.data());
}

void each_ros1_record(std::string_view records, const std::function<void(const Ros1Fields&, std::string_view)>& sink) {
  for (Bytes rest(records); !rest.empty();) {
    const Ros1Fields fields(rest.counted());
    sink(fields, rest.counted());
  }
}

Ros1Bag::Ros1Bag(const std::filesystem::path& path) : file_(path), damage_(path.string()) {
  try {
    if (file_.read(0, ros1_magic.size(), small_) != ros1_magic) throw Error(path.string() + ": is no bag of ROS 1, version 2.0; expected one");
    const Ros1Record header = record_at(ros1_magic.size());
    if (header.fields().op() != Ros1Op::header) throw Damaged("no bag header");
    if (header.fields().has("encryptor") && !header.fields().text("encryptor").empty())
      throw Error(path.string() + ": is encrypted, which is not read; expected a plain bag");
    index_at_ = header.fields().number<std::uint64_t>("index_pos");
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {} at its beginning; expected a bag of ROS 1, version 2.0", path.string(), e.what()));
  }
  if (!read_index()) scan();
}

Ros1Record Ros1Bag::record_at(std::uint64_t place) {
  std::string_view bytes = file_.read_some(place, small_record, small_);
  Bytes sizes(bytes);
  const auto head_size = sizes.number<std::uint32_t>();
  if (head_size + std::uint64_t{8} > bytes.size()) bytes = file_.read(place, head_size + std::uint64_t{8}, small_);
  Ros1Record record{.begin = place, .data = place + 8 + head_size, .head = std::string(bytes.substr(4, head_size))};
  record.data_size = load<std::uint32_t>(bytes.data() + 4 + head_size);
  if (record.data_size > file_.size() - record.data) throw Damaged("a record is cut off");
  return record;
}

void Ros1Bag::add_connection(const Ros1Fields& fields, std::string_view data) {
  const auto id = fields.number<std::uint32_t>("conn");
  if (topic_of(topics_, id) == nullptr) add_channel(topics_, id, fields.text("topic"), Ros1Fields(data).text("type"), "ros1");
}

/// False where there is none, or a damaged one.
bool Ros1Bag::read_index() {
  if (index_at_ == 0) {
    damage_.index("the bag was not closed and has no index");
    return false;
  }
  try {
    if (index_at_ >= file_.size()) throw Damaged("the index is cut off");
    for (std::uint64_t at = index_at_; at < file_.size();) {
      const Ros1Record record = record_at(at);
      const Ros1Fields fields = record.fields();
      const std::string_view data = file_.read(record.data, record.data_size, packed_);
      if (fields.op() == Ros1Op::connection) add_connection(fields, data);
      if (fields.op() == Ros1Op::chunk_info) {
        auto& counts = chunks_[fields.number<std::uint64_t>("chunk_pos")];
        for (Bytes entries(data); !entries.empty();) {
          const auto connection = entries.number<std::uint32_t>();
          const auto count = entries.number<std::uint32_t>();
          counts[connection] += count;
          if (Topic* topic = topic_of(topics_, connection); topic != nullptr) topic->messages += count;
        }
      }
      at = record.end();
    }
  } catch (const Damaged& e) {
    damage_.index(e.what());
    index_at_ = 0;
    topics_.clear(), chunks_.clear();
    return false;
  }
  return true;
}

/// Learns topics and chunks from the whole file.
void Ros1Bag::scan() {
  for (std::uint64_t at = ros1_magic.size(); at < file_.size();) {
    try {
      const Ros1Record record = record_at(at);
      if (record.fields().op() == Ros1Op::chunk) scan_chunk(record);
      at = record.end();
    } catch (const Damaged& e) {
      damage_.end(at, e.what());
      break;
    }
  }
}

void Ros1Bag::scan_chunk(const Ros1Record& chunk) {
  auto& counts = chunks_[chunk.begin];
  try {
    each_ros1_record(chunk_records(chunk), [&](const Ros1Fields& fields, std::string_view data) {
      if (fields.op() == Ros1Op::connection) return add_connection(fields, data);
      if (fields.op() != Ros1Op::message) return;
      const auto connection = fields.number<std::uint32_t>("conn");
      ++counts[connection];
      if (Topic* topic = topic_of(topics_, connection); topic != nullptr) ++topic->messages;
    });
  } catch (const Damaged& e) {
    damage_.chunk(chunk.begin, e.what());
  }
}

std::string_view Ros1Bag::chunk_records(const Ros1Record& chunk) {
  const Compression compression = damage_.compression(chunk.fields().text("compression"), chunk.begin);
  return unpack(compression, file_.read(chunk.data, chunk.data_size, packed_), chunk.fields().number<std::uint32_t>("size"), unpacked_,
                file_.path().string());
}

void Ros1Bag::each_message(const Topic& topic, const MessageSink& sink) {
  for (const auto& [at, counts] : chunks_) {
    std::uint64_t messages = 0;
    for (const auto& [connection, count] : counts)
      if (topic.channels.contains(connection)) messages += count;
    if (messages == 0) continue;
    try {
      const Ros1Record chunk = record_at(at);
      if (chunk.fields().op() != Ros1Op::chunk) throw Damaged("the index points to no chunk");
      read_chunk(chunk, messages, topic, sink);
    } catch (const Damaged& e) {
      damage_.chunk(at, e.what());
    }
  }
  warnings_ = damage_.warnings();
}

void Ros1Bag::read_chunk(const Ros1Record& chunk, std::uint64_t messages, const Topic& topic, const MessageSink& sink) {
  if (read_by_index(chunk, messages, topic, sink)) return;
  each_ros1_record(chunk_records(chunk), [&](const Ros1Fields& fields, std::string_view data) {
    if (fields.op() == Ros1Op::message && topic.channels.contains(fields.number<std::uint32_t>("conn"))) sink(fields.time_ns("time"), data);
  });
}

/// Reads messages one by one out of a chunk that is not compressed and holds much else. False where it is not such a one.
bool Ros1Bag::read_by_index(const Ros1Record& chunk, std::uint64_t messages, const Topic& topic, const MessageSink& sink) {
  if (index_at_ == 0 || chunk.fields().text("compression") != "none" || messages > chunk.data_size / sparse_message) return false;
  std::vector<std::uint64_t> offsets;
  for (std::uint64_t at = chunk.end(); at < index_at_;) {  // its index follows, a record a connection
    const Ros1Record index = record_at(at);
    if (index.fields().op() != Ros1Op::index) break;
    if (topic.channels.contains(index.fields().number<std::uint32_t>("conn")))
      for (Bytes entries(file_.read(index.data, index.data_size, packed_)); !entries.empty();) {
        entries.take(8);
        offsets.push_back(entries.number<std::uint32_t>());
      }
    at = index.end();
  }
  if (offsets.size() != messages) return false;
  std::sort(offsets.begin(), offsets.end());
  for (const std::uint64_t offset : offsets) {
    if (offset >= chunk.data_size) throw Damaged("its index points outside");
    const Ros1Record message = record_at(chunk.data + offset);
    if (message.end() > chunk.end() || message.fields().op() != Ros1Op::message ||
        !topic.channels.contains(message.fields().number<std::uint32_t>("conn")))
      throw Damaged("its index points to no message of the topic");
    sink(message.fields().time_ns("time"), file_.read(message.data, message.data_size, unpacked_));
  }
  return true;
}

namespace {

std::string record_bytes(const std::string& head, std::string_view data) {
  const auto size_of = [](std::string_view text) {
    if (text.size() > UINT32_MAX) throw Damaged("a record of more than 4 GiB");
    return static_cast<std::uint32_t>(text.size());
  };
  std::string bytes;
  append<std::uint32_t>(bytes, size_of(head));
  bytes += head;
  append<std::uint32_t>(bytes, size_of(data));
  return bytes.append(data);
}

/// A record as bytes, with another place in one of its fields.
std::string with_place(Ros1Record record, std::string_view field, std::uint64_t place, std::string_view data) {
  const std::string_view value = record.fields().text(field);
  if (value.size() != sizeof place) throw Damaged("a place of another length");
  store<std::uint64_t>(record.head.data() + (value.data() - record.head.data()), place);
  return record_bytes(record.head, data);
}

class Ros1Rewriter {
 public:
  Ros1Rewriter(Ros1Bag& bag, const Topic& topic, const MessageChange& change, WholeFile& out)
      : bag_(bag), topic_(topic), change_(change), out_(out), copy_(bag.file(), out, false) {}

  void run() {
    for (const auto& [at, counts] : bag_.chunks()) {
      bool holds = false;
      for (const auto& [connection, count] : counts) holds |= count > 0 && topic_.channels.contains(connection);
      if (holds) change_chunk(bag_.record_at(at));
    }
    copy_.until(bag_.index_at());
    for (std::uint64_t at = bag_.index_at(); at < bag_.file().size();) {
      const Ros1Record record = bag_.record_at(at);
      copy_.until(at);
      if (record.fields().op() == Ros1Op::chunk_info)
        copy_.put(with_place(record, "chunk_pos", copy_.moved(record.fields().number<std::uint64_t>("chunk_pos")), data_of(record)), record.end());
      at = record.end();
    }
    copy_.until(bag_.file().size());
    const Ros1Record header = bag_.record_at(ros1_magic.size());  // the first record tells where the index begins, which is known now
    out_.write_at(header.begin, with_place(header, "index_pos", copy_.moved(bag_.index_at()), data_of(header)));
  }

 private:
  std::string_view data_of(const Ros1Record& record) { return bag_.file().read(record.data, record.data_size, buffer_); }

  void change_chunk(const Ros1Record& chunk) {
    if (chunk.fields().op() != Ros1Op::chunk || chunk.end() > bag_.index_at()) throw Damaged("its index points to no chunk");
    std::string records(bag_.chunk_records(chunk));
    each_ros1_record(records, [&](const Ros1Fields& fields, std::string_view data) {
      if (fields.op() != Ros1Op::message || !topic_.channels.contains(fields.number<std::uint32_t>("conn"))) return;
      change_({records.data() + (data.data() - records.data()), data.size()});
    });
    const Compression compression = bag_.damage().compression(chunk.fields().text("compression"), chunk.begin);
    copy_.until(chunk.begin);
    copy_.put(record_bytes(chunk.head, pack(compression, records)), chunk.end());
  }

  Ros1Bag& bag_;
  const Topic& topic_;
  const MessageChange& change_;
  WholeFile& out_;
  Copy copy_;
  Buffer buffer_;
};

}  // namespace

void rewrite_ros1_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  Ros1Bag bag(in);
  if (bag.index_at() == 0)
    throw Error(fmt::format("{}: was not closed or is damaged; expected a whole bag: repair it with rosbag reindex", in.string()));
  try {
    Ros1Rewriter(bag, topic, change, out).run();
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {}; expected a whole bag: repair it with rosbag reindex", in.string(), e.what()));
  }
}

}  // namespace imulab::bag

imulab::RecordingFormat imulab::recording_io::ros1_bag_format() {
  static constexpr bag::BagFormat format{".bag", bag::opened<bag::Ros1Bag>, bag::rewrite_ros1_bag};
  return bag::bag_row(
      "ROS 1 bag", [](std::string_view head) { return head.starts_with("#ROSBAG V"); }, format);
}
