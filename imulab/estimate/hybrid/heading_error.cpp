#include "imulab/estimate/hybrid/heading_error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace imulab::hybrid {

std::optional<HeadingError> heading_error(const std::vector<RestRate>& rates, double most_rate) {
  constexpr std::size_t enough = 2000;  // number of parts of a long recording
  std::vector<std::pair<double, std::complex<double>>> parts;
  const std::size_t in_part = rates.size() / enough + 1;
  double power = 0;
  for (std::size_t k = 0; k < rates.size(); ++k) {
    if (k % in_part == 0) parts.emplace_back(rates[std::min(k + in_part / 2, rates.size() - 1)].time, 0);
    const std::complex<double> rate = rates[k].duration * std::complex<double>(rates[k].rate_n.x(), rates[k].rate_n.y());
    parts.back().second += rate;
    power += std::norm(rate);
  }
  if (parts.empty()) return {};
  const auto sum_at = [&](double rate) {
    std::complex<double> sum = 0;
    for (const auto& [time, part] : parts) sum += std::polar(1.0, -rate * time) * part;
    return sum;
  };
  const double step = 0.5 / std::max(rates.back().time - rates.front().time, 1.0);
  const int steps = std::min(2000, static_cast<int>(most_rate / step));
  std::complex<double> most = 0;
  double best = 0;
  for (int k = -steps; k <= steps; ++k)
    if (const std::complex<double> sum = sum_at(k * step); std::norm(sum) > std::norm(most)) most = sum, best = k * step;
  if (std::norm(most) < 25 * power) return {};
  return HeadingError{std::arg(most) - std::numbers::pi / 2, best};  // in the complex plane of east and north, north is the imaginary axis
}

double noise_of_angle(const std::vector<SeenHeading>& seen, double angle) {
  const auto excess = [&](double more) {
    double sum = -static_cast<double>(seen.size());
    for (const SeenHeading& h : seen) sum += h.whitened * h.whitened * h.variance / (h.variance + more);
    return sum;
  };
  double low = 0, high = std::ranges::max_element(seen, {}, &SeenHeading::variance)->variance;
  while (excess(high) > 0) low = high, high *= 2;
  while (high - low > 1e-3 * high) (excess(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
  return std::hypot(angle, std::sqrt(high / 2));
}

}  // namespace imulab::hybrid
