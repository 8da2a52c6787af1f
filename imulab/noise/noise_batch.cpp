#include "imulab/noise/noise_batch.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The spread t^2 for which sum of (value - mean)^2 / (u^2 + t^2) is its degrees of freedom (Mandel and Paule 1970), and the mean with these weights.
struct CommonValue {
  double mean = 0, sigma = 0, spread = 0;
};

CommonValue common_value(const std::vector<NoiseCoefficient>& values) {
  const auto with = [&](double t2) {
    CommonValue out;
    double weights = 0;
    for (const NoiseCoefficient& c : values) {
      const double w = 1 / (c.standard_uncertainty * c.standard_uncertainty + t2);
      out.mean += w * c.value, weights += w;
    }
    out.mean /= weights, out.sigma = 1 / std::sqrt(weights), out.spread = std::sqrt(t2);
    return out;
  };
  const double freedom = static_cast<double>(values.size()) - 1;
  const auto scatter = [&](double t2) {
    const double mean = with(t2).mean;
    double sum = 0;
    for (const NoiseCoefficient& c : values) sum += std::pow(c.value - mean, 2) / (c.standard_uncertainty * c.standard_uncertainty + t2);
    return sum - freedom;
  };
  if (values.size() < 2 || scatter(0) <= 0) return with(0);
  double low = 0, high = 1e-300;
  for (const NoiseCoefficient& c : values) high = std::max(high, 4 * c.value * c.value);
  while (scatter(high) > 0) high *= 4;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (scatter(middle) > 0 ? low : high) = middle;
  }
  return with(high);
}

BatchCoefficient together(const std::vector<NoiseCoefficient>& logs) {
  BatchCoefficient out;
  std::vector<NoiseCoefficient> known;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (logs[i].determined) known.push_back(logs[i]);
    const double size = std::abs(logs[i].determined ? logs[i].value : logs[i].upper);
    if (i == 0 || size > out.worst) out.worst = size, out.worst_log = i;
  }
  out.determined = static_cast<int>(known.size());
  out.spread = nan;
  if (known.empty()) {
    out.mean = undetermined_below(out.worst);
    return out;
  }
  const CommonValue all = common_value(known);
  if (known.size() > 1) out.spread = all.spread;
  // Few logs know their own spread badly: Student's quantile where there is one.
  const double width = known.size() > 1 && all.spread > 0 ? student_quantile(0.975, static_cast<double>(known.size()) - 1) : 1.96;
  out.mean = {all.mean, all.sigma, all.mean - width * all.sigma, all.mean + width * all.sigma, true};
  return out;
}

}  // namespace

NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs) {
  NoiseBatch batch{std::move(logs), {}};
  for (std::size_t k = 0; k < batch.logs.front().axes.size(); ++k) {
    BatchAxis axis{batch.logs.front().axes[k].name, batch.logs.front().axes[k].unit, {}};
    std::array<std::vector<NoiseCoefficient>, 5> values;
    for (const NoiseAnalysis& log : batch.logs) {
      if (log.axes[k].unit != axis.unit)
        throw Error(fmt::format("{}: {} is in {}, that of {} in {}; expected logs in the same unit", log.recording, axis.name, log.axes[k].unit,
                                batch.logs.front().recording, axis.unit));
      if (const auto& fit = log.axes[k].fit)
        for (std::size_t j = 0; j < 5; ++j) values[j].push_back(*std::array{&fit->Q, &fit->N, &fit->B, &fit->K, &fit->R}[j]);
    }
    if (values[0].empty()) continue;
    for (std::size_t j = 0; j < 5; ++j) axis.coefficients[j] = together(values[j]);
    batch.axes.push_back(std::move(axis));
  }
  return batch;
}

}  // namespace imulab
