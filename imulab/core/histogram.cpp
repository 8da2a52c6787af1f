#include "imulab/core/histogram.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace imulab {

namespace {

constexpr int dropped_bits = 15;  // of the 23 of a number's fraction
constexpr std::uint32_t sign_bit = 0x80000000;

std::int32_t key_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto leading = static_cast<std::int32_t>((bits & ~sign_bit) >> dropped_bits);
  return (bits & sign_bit) != 0 ? -1 - leading : leading;
}

/// The end of a bin nearer to zero, or the other one.
double bound_of(std::int32_t key, int farther) {
  const std::int32_t leading = key < 0 ? -1 - key : key;
  const auto size = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(leading + farther) << dropped_bits));
  return key < 0 ? -size : size;
}

template <class Value>
void append(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class Value>
void take(std::string_view& bytes, Value& value) {
  if (bytes.size() < sizeof value) throw Error("a histogram that was kept is cut short: another version of imulab wrote it");
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
}

}  // namespace

Histogram::Bin& Histogram::bin(std::int32_t key) {
  const auto place = std::lower_bound(bins_.begin(), bins_.end(), key, [](const Bin& b, std::int32_t k) { return b.key < k; });
  return place != bins_.end() && place->key == key ? *place : *bins_.insert(place, Bin{.key = key});
}

void Histogram::add(float value) {
  Bin& b = bin(key_of(value));
  ++b.count;
  b.sum += static_cast<double>(value);
}

void Histogram::add(const Histogram& other) {
  for (const Bin& theirs : other.bins_) {
    Bin& b = bin(theirs.key);
    b.count += theirs.count;
    b.sum += theirs.sum;
  }
}

std::uint64_t Histogram::count() const {
  std::uint64_t all = 0;
  for (const Bin& b : bins_) all += b.count;
  return all;
}

/// Numbers of a bin lie evenly about their mean.
double Histogram::of_rank(std::uint64_t rank) const {
  for (const Bin& b : bins_) {
    if (rank >= b.count) {
      rank -= b.count;
      continue;
    }
    const auto n = static_cast<double>(b.count);
    const double one = bound_of(b.key, 0), two = bound_of(b.key, 1), from_mean = (static_cast<double>(rank) + 0.5) / n - 0.5;
    return std::clamp(b.sum / n + from_mean * std::abs(two - one), std::min(one, two), std::max(one, two));
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double Histogram::quantile(double p) const {
  const std::uint64_t n = count();
  if (n == 0) return std::numeric_limits<double>::quiet_NaN();
  const double place = p * static_cast<double>(n - 1), part = place - std::floor(place);
  const auto rank = static_cast<std::uint64_t>(place);
  const double below = of_rank(rank);
  return part > 0 ? below + part * (of_rank(std::min(rank + 1, n - 1)) - below) : below;
}

void Histogram::write(std::string& bytes) const {
  append(bytes, static_cast<std::uint64_t>(bins_.size()));
  for (const Bin& b : bins_) append(bytes, b.key), append(bytes, b.count), append(bytes, b.sum);
}

void Histogram::read(std::string_view& bytes) {
  std::uint64_t bins = 0;
  take(bytes, bins);
  bins_.clear();
  for (Bin b; bins > 0; --bins) {
    take(bytes, b.key), take(bytes, b.count), take(bytes, b.sum);
    if (!bins_.empty() && b.key <= bins_.back().key)
      throw Error("a histogram that was kept has its bins in disorder: another version of imulab wrote it");
    bins_.push_back(b);
  }
}

}  // namespace imulab
