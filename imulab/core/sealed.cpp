#include "imulab/core/sealed.hpp"

#include <bit>

namespace imulab {

static_assert(std::endian::native == std::endian::little, "the bytes of a sealed file are in this order");

std::uint64_t checksum(std::string_view bytes, std::uint64_t sum) {
  for (const char c : bytes) sum = (sum ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return sum;
}

void SealedWriter::number(std::uint64_t number) { bytes_.append(reinterpret_cast<const char*>(&number), sizeof number); }

void SealedWriter::text(std::string_view text) {
  number(text.size());
  bytes_ += text;
}

void SealedWriter::seal() {
  sum_ = checksum(std::string_view(bytes_).substr(summed_), sum_);
  number(sum_);
  sum_ = checksum(std::string_view(bytes_).substr(bytes_.size() - sizeof sum_), sum_);
  summed_ = bytes_.size();
}

bool SealedReader::take(char* to, std::uint64_t size) {
  if (size > left_ || !in_.read(to, static_cast<std::streamsize>(size))) return false;
  left_ -= size;
  sum_ = checksum({to, size}, sum_);
  return true;
}

bool SealedReader::number(std::uint64_t& number) { return take(reinterpret_cast<char*>(&number), sizeof number); }

bool SealedReader::text(std::string& text) {
  std::uint64_t size = 0;
  if (!number(size) || size > left_) return false;
  text.resize(size);
  return take(text.data(), size);
}

bool SealedReader::seal() {
  const std::uint64_t expected = sum_;
  std::uint64_t there = 0;
  return number(there) && there == expected;
}

}  // namespace imulab
