// Bags of ROS 1, version 2.0 (https://wiki.ros.org/Bags/Format/2.0).
#pragma once

#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::bag {

constexpr std::string_view ros1_magic = "#ROSBAG V2.0\n";

/// Kinds of records.
enum class Ros1Op : std::uint8_t { message = 2, header = 3, index = 4, chunk = 5, chunk_info = 6, connection = 7 };

/// The named fields of a record's header.
class Ros1Fields {
 public:
  explicit Ros1Fields(std::string_view bytes) : bytes_(bytes) {}
  /// Throws Damaged where it is not there.
  std::string_view text(std::string_view name) const;
  template <class T>
  T number(std::string_view name) const {
    const std::string_view value = text(name);
    if (value.size() != sizeof(T)) throw Damaged("a field " + std::string(name) + " of another length");
    return load<T>(value.data());
  }
  /// Seconds, then nanoseconds.
  std::int64_t time_ns(std::string_view name) const;
  Ros1Op op() const { return static_cast<Ros1Op>(number<std::uint8_t>("op")); }
  bool has(std::string_view name) const;

 private:
  std::string_view bytes_;
};

struct Ros1Record {
  std::uint64_t begin = 0, data = 0, data_size = 0;  ///< in the file
  std::string head;                                  ///< its fields

  Ros1Fields fields() const { return Ros1Fields(head); }
  std::uint64_t end() const { return data + data_size; }
};

class Ros1Bag : public Bag {
 public:
  /// Throws Error for a file that is no bag of version 2.0, or encrypted.
  explicit Ros1Bag(const std::filesystem::path& path);

  void each_message(const Topic& topic, const MessageSink& sink) override;

  const ByteFile& file() const { return file_; }
  /// The number of messages of each connection in the chunk at a byte.
  const std::map<std::uint64_t, std::map<std::uint32_t, std::uint64_t>>& chunks() const { return chunks_; }
  std::uint64_t index_at() const { return index_at_; }  ///< where connections and chunk infos begin; 0: nowhere
  const Damage& damage() const { return damage_; }
  /// Throws Damaged where it is cut off.
  Ros1Record record_at(std::uint64_t place);
  /// The records of a chunk, unpacked; valid until the next call.
  std::string_view chunk_records(const Ros1Record& chunk);

 private:
  bool read_index();
  void scan();
  void scan_chunk(const Ros1Record& chunk);
  void add_connection(const Ros1Fields& fields, std::string_view data);
  void read_chunk(const Ros1Record& chunk, std::uint64_t messages, const Topic& topic, const MessageSink& sink);
  bool read_by_index(const Ros1Record& chunk, std::uint64_t messages, const Topic& topic, const MessageSink& sink);

  ByteFile file_;
  Damage damage_;
  std::uint64_t index_at_ = 0;
  std::map<std::uint64_t, std::map<std::uint32_t, std::uint64_t>> chunks_;
  Buffer packed_, unpacked_, small_;
};

/// Calls with each record of a chunk's bytes: its fields and its data. Throws Damaged.
void each_ros1_record(std::string_view bytes, const std::function<void(const Ros1Fields&, std::string_view)>& sink);

void rewrite_ros1_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

}  // namespace imulab::bag
