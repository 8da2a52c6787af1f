#include "imulab/formats/recording/bag/copy.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

namespace imulab::bag {

void Copy::write(std::string_view bytes) {
  out_.write(bytes);
  if (checksum_) crc_ = crc32(bytes, crc_);
  written_ += bytes.size();
}

void Copy::until(std::uint64_t place) {
  constexpr std::uint64_t piece = 1 << 20;
  while (taken_ < place) {
    const std::uint64_t count = std::min(piece, place - taken_);
    write(in_.read(taken_, count, buffer_));
    taken_ += count;
  }
}

void Copy::put(std::string_view bytes, std::uint64_t place) {
  write(bytes);
  taken_ = place;
  places_.emplace_back(taken_, written_);
}

std::uint64_t Copy::moved(std::uint64_t place) const {
  const auto after = std::upper_bound(places_.begin(), places_.end(), std::pair(place, std::numeric_limits<std::uint64_t>::max()));
  return after == places_.begin() ? place : place - std::prev(after)->first + std::prev(after)->second;
}

}  // namespace imulab::bag
