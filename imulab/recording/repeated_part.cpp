#include "imulab/recording/repeated_part.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <set>
#include <unordered_map>

namespace imulab {

namespace {

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 32)) * 0x9e3779b97f4a7c15;
  return x ^ (x >> 29);
}

/// A hash of the six readings of a sample.
std::uint64_t hash_of(const Recording& r, std::size_t i) {
  std::uint64_t hash = 0;
  for (const Columns3* triad : {&r.gyro, &r.accel})
    for (const std::vector<double>& column : *triad) hash = mixed(hash + std::bit_cast<std::uint64_t>(column[i]));
  return hash;
}

bool same(const Recording& a, std::size_t i, const Recording& b, std::size_t k) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (a.gyro[axis][i] != b.gyro[axis][k] || a.accel[axis][i] != b.accel[axis][k]) return false;
  return true;
}

/// A polynomial of the last `least_repeated` samples, modulo 2^64, that follows them sample by sample, and how many of them differ from the one
/// before.
class RollingHash {
 public:
  RollingHash() {
    for (std::size_t i = 0; i < least_repeated; ++i) oldest_factor_ *= factor;
  }
  void add(std::uint64_t sample) {
    const std::size_t at = count_ % least_repeated;
    const bool differs = count_ > 0 && sample != samples_[(count_ - 1) % least_repeated];
    value_ = value_ * factor + sample - oldest_factor_ * samples_[at];
    changes_ += differs, changes_ -= differs_[at];
    samples_[at] = sample, differs_[at] = differs;
    ++count_;
  }
  std::uint64_t value() const { return value_; }
  bool says_something() const { return count_ >= least_repeated && 2 * changes_ >= least_repeated; }

 private:
  static constexpr std::uint64_t factor = 0x9e3779b97f4a7c15;
  std::uint64_t value_ = 0, oldest_factor_ = 1;
  std::array<std::uint64_t, least_repeated> samples_{};
  std::array<bool, least_repeated> differs_{};
  std::size_t count_ = 0, changes_ = 0;
};

struct StretchBegin {
  std::size_t recording, begin;
};

/// Readings that go to and fro between a few values repeat themselves without having been written twice.
bool vary(const Recording& r, std::size_t begin) {
  std::set<std::uint64_t> distinct;
  for (std::size_t i = begin; i < begin + least_repeated; ++i) distinct.insert(hash_of(r, i));
  return 4 * distinct.size() >= least_repeated;
}

}  // namespace

std::optional<RepeatedPart> repeated_part(std::span<const Recording> recordings) {
  std::optional<RepeatedPart> first;
  std::unordered_map<std::uint64_t, StretchBegin> seen;  // stretches that lie end to end
  std::size_t in_all = 0;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const Recording& r = recordings[k];
    RollingHash hash;
    std::size_t counted = 0, next = 0;  // samples before these are known to repeat others; are done with
    for (std::size_t i = 0; i < r.size(); ++i) {
      hash.add(hash_of(r, i));
      if (i < next || !hash.says_something()) continue;
      std::size_t begin = i + 1 - least_repeated;
      const auto found = seen.find(hash.value());
      if (found == seen.end()) {
        if (begin % least_repeated == 0) seen.emplace(hash.value(), StretchBegin{k, begin});
        continue;
      }
      next = i + least_repeated;
      if (!vary(r, begin)) continue;
      StretchBegin from = found->second;
      const Recording& earlier = recordings[from.recording];
      while (begin > counted && from.begin > 0 && same(r, begin - 1, earlier, from.begin - 1)) --begin, --from.begin;
      const std::size_t end_of_earlier = from.recording == k ? begin : earlier.size();
      std::size_t size = 0;
      while (begin + size < r.size() && from.begin + size < end_of_earlier && same(r, begin + size, earlier, from.begin + size)) ++size;
      if (size < least_repeated) continue;
      in_all += begin + size - std::max(begin, counted);
      counted = next = begin + size;
      if (!first) first = {k, from.recording, {begin, begin + size}, {from.begin, from.begin + size}, 0};
    }
  }
  if (first) first->in_all = in_all;
  return first;
}

}  // namespace imulab
