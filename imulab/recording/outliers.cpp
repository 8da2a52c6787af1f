#include "imulab/recording/outliers.hpp"

#include "imulab/outlier_filter.hpp"

#include <algorithm>

namespace imulab {

std::vector<std::size_t> samples_of(const std::vector<ReplacedReading>& readings) {
  std::vector<std::size_t> samples;
  for (const ReplacedReading& r : readings)
    if (samples.empty() || samples.back() != r.sample) samples.push_back(r.sample);
  return samples;
}

std::vector<ReplacedReading> outliers_of(const RecordingView& r) {
  constexpr double most_replaced = 0.005;
  const double most = most_replaced * static_cast<double>(r.size());
  std::vector<ReplacedReading> out;
  OutlierFilter filter;
  std::size_t sample = 0, samples = 0;
  const auto take = [&](const OutlierFilter::Output& filtered) {
    for (std::size_t c = 0; c < gyro_temperature_columns; ++c)
      if ((filtered.replaced >> c & 1) != 0) out.push_back({sample, c, filtered.readings[c]});
    samples += filtered.replaced != 0 ? 1 : 0;
    ++sample;
  };
  std::array<std::vector<double>, gyro_temperature_columns> buffers;
  for (std::size_t begin = 0; begin < r.size() && static_cast<double>(samples) <= most; begin += usual_block) {
    const Range block{begin, std::min(r.size(), begin + usual_block)};
    std::array<std::span<const double>, gyro_temperature_columns> columns;
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (r.has(c)) columns[c] = r.samples(c, block, buffers[c]);
    OutlierFilter::Readings readings{};  // 0 where a triad is absent
    for (std::size_t i = 0; i < block.size(); ++i) {
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (!columns[c].empty()) readings[c] = columns[c][i];
      if (const auto filtered = filter.push(readings)) take(*filtered);
    }
  }
  return static_cast<double>(samples) <= most ? out : std::vector<ReplacedReading>{};
}

}  // namespace imulab
