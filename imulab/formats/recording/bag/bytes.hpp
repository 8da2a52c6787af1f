// Bytes of a bag: numbers and counted strings, read with every length checked.
#pragma once

#include "imulab/formats/recording/logs/binary.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace imulab::bag {

/// A fault in the bytes; the caller, which knows the file and the place, turns it into an Error or a warning.
struct Damaged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

using recording_io::append;
using recording_io::crc32;
using recording_io::load;
using recording_io::store;

/// Takes one thing after the other off the front. Throws Damaged where less is left.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : rest_(bytes) {}

  bool empty() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }
  std::string_view take(std::uint64_t count) {
    if (count > rest_.size()) throw Damaged("a length points beyond the end");
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  template <class T>
  T number() {
    return load<T>(take(sizeof(T)).data());
  }
  /// Its length in four bytes, then as many.
  std::string_view counted() { return take(number<std::uint32_t>()); }

 private:
  std::string_view rest_;
};

/// Memory that is used again and never cleared.
class Buffer {
 public:
  /// At least `size` bytes; the first `kept` stay as they are.
  char* of(std::size_t size, std::size_t kept = 0) {
    if (size <= size_) return bytes_.get();
    std::unique_ptr<char[]> larger(new char[size]);
    if (kept > 0) std::memcpy(larger.get(), bytes_.get(), kept);
    bytes_ = std::move(larger);
    size_ = size;
    return bytes_.get();
  }
  std::size_t size() const { return size_; }
  char* data() { return bytes_.get(); }

 private:
  std::unique_ptr<char[]> bytes_;
  std::size_t size_ = 0;
};

}  // namespace imulab::bag
