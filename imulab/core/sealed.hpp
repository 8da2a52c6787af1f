// Files of numbers and texts that are read again whole, or not at all: a running sum over every byte shows any damage to them (not malice).
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

namespace imulab {

/// FNV-1a, 64 bits: a changed byte always changes it. `sum`: of the bytes before.
std::uint64_t checksum(std::string_view bytes, std::uint64_t sum = 0xcbf29ce484222325);

/// Numbers of 64 bits, least significant byte first; texts as their size and their bytes; a seal is the sum so far.
class SealedWriter {
 public:
  /// `sum`: of what stands before.
  explicit SealedWriter(std::uint64_t sum = checksum("")) : sum_(sum) {}

  void number(std::uint64_t number);
  void text(std::string_view text);
  void seal();
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  std::size_t summed_ = 0;
  std::uint64_t sum_;
};

/// Each returns false at the end, and for what is not as it was written.
class SealedReader {
 public:
  /// `size`: of what there is to read; a text is never longer. `sum`: of what was read before.
  SealedReader(std::istream& in, std::uint64_t size, std::uint64_t sum = checksum("")) : in_(in), left_(size), sum_(sum) {}

  bool number(std::uint64_t& number);
  bool text(std::string& text);
  bool seal();
  std::uint64_t left() const { return left_; }
  std::uint64_t sum() const { return sum_; }

 private:
  bool take(char* to, std::uint64_t size);

  std::istream& in_;
  std::uint64_t left_, sum_;
};

}  // namespace imulab
