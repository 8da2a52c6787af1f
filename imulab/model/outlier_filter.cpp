#include "imulab/outlier_filter.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace imulab {

namespace {

constexpr std::size_t channels = 6;

}  // namespace

OutlierFilter::OutlierFilter(double factor) : factor_(factor) {
  if (!(factor > 0 && std::isfinite(factor))) throw Error("outlier filter: the factor is " + std::to_string(factor) + "; expected more than 0");
}

void OutlierFilter::learn_resolution() {
  for (std::size_t c = 0; c < channels; ++c) {
    const double difference = std::abs(window_[4][c] - window_[3][c]);
    const bool finer = resolution_[c] == 0 || difference < resolution_[c];
    resolution_[c] = difference > 0 && finer ? difference : resolution_[c];
  }
}

OutlierFilter::Output OutlierFilter::judge() {
  Readings distance, unlikely, middle, threshold;
  for (std::size_t c = 0; c < channels; ++c) {
    const double before2 = window_[0][c], before = window_[1][c], x = window_[2][c], after = window_[3][c], after2 = window_[4][c];
    const double one = std::max(std::min(before2, before), std::min(after, after2)),
                 other = std::min(std::max(before2, before), std::max(after, after2));
    const double a = std::min(one, other), b = std::max(one, other);
    const double cubic = (4 * (before + after) - (before2 + after2)) * (1.0 / 6);
    const double outside = std::max(x - b, a - x);  // negative between a and b
    distance[c] = outside;
    unlikely[c] = std::min(outside, std::abs(x - cubic));
    middle[c] = 0.5 * a + 0.5 * b;
    threshold[c] = factor_ * usual_[c] + resolutions * resolution_[c];
  }
  Output out{window_[2], 0};
  for (std::size_t c = 0; c < channels; ++c) {
    if (!(distance[c] >= 0)) continue;
    if (taught_[c] < memory) ++taught_[c];
    if (taught_[c] > learning) {
      usual_[c] += (std::min(distance[c], threshold[c]) - usual_[c]) / taught_[c];
    } else {
      usual_[c] += distance[c];
      largest_[1][c] = std::max(largest_[1][c], std::min(largest_[0][c], distance[c]));
      largest_[0][c] = std::max(largest_[0][c], distance[c]);
      if (taught_[c] == learning) usual_[c] = std::max(usual_[c] - largest_[0][c] - largest_[1][c], 0.0) / (learning - 2);
      continue;
    }
    if (unlikely[c] > threshold[c]) {
      out.readings[c] = middle[c];
      out.replaced |= static_cast<std::uint8_t>(1u << c);
    }
  }
  return out;
}

std::optional<OutlierFilter::Output> OutlierFilter::push(const Readings& readings) {
  for (std::size_t i = 0; i < 4; ++i) window_[i] = window_[i + 1];
  window_[4] = readings;
  if (++taken_ >= 2) learn_resolution();
  if (taken_ <= delay) return std::nullopt;
  ++given_;
  return taken_ < 5 ? Output{window_[2], 0} : judge();
}

std::optional<OutlierFilter::Output> OutlierFilter::rest() {
  if (given_ == taken_) return std::nullopt;
  return Output{window_[4 - (taken_ - ++given_)], 0};
}

std::vector<std::uint8_t> reject_outliers(const std::array<std::span<double>, 6>& columns, double factor) {
  const std::size_t n = columns[0].size();
  for (const auto& column : columns)
    if (column.size() != n) throw Error("reject_outliers: columns of different lengths, expected six of one length");
  std::vector<std::uint8_t> replaced(n, 0);
  OutlierFilter filter(factor);
  std::size_t at = 0;
  const auto put = [&](const OutlierFilter::Output& out) {
    for (std::size_t c = 0; c < channels; ++c) columns[c][at] = out.readings[c];
    replaced[at++] = out.replaced;
  };
  for (std::size_t i = 0; i < n; ++i)
    if (const auto out = filter.push({columns[0][i], columns[1][i], columns[2][i], columns[3][i], columns[4][i], columns[5][i]})) put(*out);
  while (const auto out = filter.rest()) put(*out);
  return replaced;
}

}  // namespace imulab
