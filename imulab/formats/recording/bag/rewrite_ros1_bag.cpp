#include "imulab/core/error.hpp"
#include "imulab/formats/recording/bag/copy.hpp"
#include "imulab/formats/recording/bag/ros1_bag.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <span>
#include <string>

namespace imulab::bag {
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

/// The same record with another place in one of its fields.
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
