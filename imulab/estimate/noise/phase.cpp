#include "imulab/estimate/noise/phase.hpp"

#include "imulab/core/error.hpp"

#include <Eigen/Core>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace imulab::noise {

namespace {

constexpr std::size_t lanes = 8;     // sums in flight: an addition waits for the one before it. As many on every processor: results are equal
constexpr std::size_t piece = 2048;  // points at once: three of them fit into the first cache
using Lanes = Eigen::Array<double, lanes, 1>;
using Points = Eigen::Map<const Lanes>;

using Sum = double (*)(const double* x, std::size_t m, std::size_t n);

double second(const double* x, std::size_t m) { return (x[2 * m] - x[m]) - (x[m] - x[0]); }
double third(const double* x, std::size_t m) { return (x[3 * m] - x[0]) - 3 * (x[2 * m] - x[m]); }

double sum_of_second(const double* x, std::size_t m, std::size_t n) {
  Lanes sum = Lanes::Zero();
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const Lanes b = Points(x + i + m);
    sum += ((Points(x + i + 2 * m) - b) - (b - Points(x + i))).square();
  }
  double total = sum.sum();
  for (; i < n; ++i) total += second(x + i, m) * second(x + i, m);
  return total;
}

double sum_of_third(const double* x, std::size_t m, std::size_t n) {
  Lanes sum = Lanes::Zero();
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) sum += ((Points(x + i + 3 * m) - Points(x + i)) - 3 * (Points(x + i + 2 * m) - Points(x + i + m))).square();
  double total = sum.sum();
  for (; i < n; ++i) total += third(x + i, m) * third(x + i, m);
  return total;
}

#if defined(__x86_64__)
/// As sum_of_second, with registers of four numbers; not fused, so that the result is the same.
__attribute__((target("avx2"))) double wide_sum_of_second(const double* x, std::size_t m, std::size_t n) {
  __m256d low = _mm256_setzero_pd(), high = _mm256_setzero_pd();
  const auto square = [](const double* a, const double* b, const double* c) __attribute__((target("avx2"))) {
    const __m256d middle = _mm256_loadu_pd(b);
    const __m256d d = _mm256_sub_pd(_mm256_sub_pd(_mm256_loadu_pd(c), middle), _mm256_sub_pd(middle, _mm256_loadu_pd(a)));
    return _mm256_mul_pd(d, d);
  };
  std::size_t i = 0;
  for (const double *a = x, *b = x + m, *c = x + 2 * m; i + lanes <= n; i += lanes) {
    low = _mm256_add_pd(low, square(a + i, b + i, c + i));
    high = _mm256_add_pd(high, square(a + i + 4, b + i + 4, c + i + 4));
  }
  Lanes sum;
  _mm256_storeu_pd(sum.data(), low);
  _mm256_storeu_pd(sum.data() + 4, high);
  double total = sum.sum();
  for (; i < n; ++i) total += second(x + i, m) * second(x + i, m);
  return total;
}
#endif

Sum fastest_sum_of_second() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return wide_sum_of_second;
#endif
  return sum_of_second;
}

std::vector<SquareSum> differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors, std::size_t order, Sum sum_of) {
  std::vector<SquareSum> sums(factors.size());
  std::size_t most = 0;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    sums[k].terms = phase.size() > order * factors[k] ? phase.size() - order * factors[k] : 0;
    most = std::max(most, sums[k].terms);
  }
  for (std::size_t begin = 0; begin < most; begin += piece)
    for (std::size_t k = 0; k < factors.size(); ++k)
      if (sums[k].terms > begin) sums[k].sum += sum_of(phase.data() + begin, factors[k], std::min(piece, sums[k].terms - begin));
  return sums;
}

double mean_rate(std::span<const double> rate) {
  const auto n = static_cast<Eigen::Index>(rate.size());
  const Eigen::Map<const Eigen::ArrayXd> readings(rate.data(), n);
  const double origin = rate.empty() ? 0 : rate[0];
  const double mean = origin + (readings - origin).sum() / static_cast<double>(n);
  if (!std::isfinite(mean)) {
    const auto wrong = std::find_if(rate.begin(), rate.end(), [](double x) { return !std::isfinite(x); });
    throw Error(fmt::format("reading {}: is not finite; expected numbers", wrong - rate.begin() + (wrong == rate.end() ? 0 : 1)));
  }
  return mean;
}

}  // namespace

std::vector<double> phase_of(std::span<const double> rate) {
  const double mean = mean_rate(rate);
  std::vector<double> phase(rate.size() + 1);
  double x = 0;
  for (std::size_t i = 0; i < rate.size(); ++i) phase[i + 1] = x += rate[i] - mean;
  return phase;
}

std::vector<double> phase_in_place(std::vector<double>&& rate) {
  const double mean = mean_rate(rate);
  std::vector<double> phase = std::move(rate);
  double x = 0;
  for (double& value : phase) {
    const double before = x;
    x += value - mean;
    value = before;
  }
  phase.push_back(x);
  return phase;
}

std::vector<SquareSum> second_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors) {
  return differences(phase, factors, 2, fastest_sum_of_second());
}

std::vector<SquareSum> third_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors) {
  return differences(phase, factors, 3, sum_of_third);
}

SquareSum strided_differences(const std::vector<double>& phase, std::size_t m, int order) {
  SquareSum out;
  const std::size_t reach = m * static_cast<std::size_t>(order);
  for (std::size_t i = 0; i + reach < phase.size(); i += m) {
    const double d = order == 2 ? second(phase.data() + i, m) : third(phase.data() + i, m);
    out.sum += d * d;
    ++out.terms;
  }
  return out;
}

SquareSum modified_differences(const std::vector<double>& phase, std::size_t m) {
  SquareSum out;
  if (phase.size() < 3 * m) return out;
  const double* const x = phase.data();
  double s = 0;
  for (std::size_t i = 0; i < m; ++i) s += (x[i + 2 * m] - x[i + m]) - (x[i + m] - x[i]);
  const auto mm = static_cast<double>(m);
  out.terms = phase.size() - 3 * m + 1;
  for (std::size_t i = 0;; ++i) {
    out.sum += s * s / (mm * mm);
    if (i + 1 == out.terms) return out;
    s += (x[i + 3 * m] - x[i]) - 3 * (x[i + 2 * m] - x[i + m]);
  }
}

SquareSum total_differences(const std::vector<double>& phase, std::size_t m) {
  SquareSum out;
  const std::size_t last = phase.size() - 1;
  if (phase.size() < 3 || m > last) return out;
  const double* const x = phase.data();
  for (std::size_t i = 1; i < last; ++i) {
    const double before = i >= m ? x[i - m] : 2 * x[0] - x[m - i];
    const double after = i + m <= last ? x[i + m] : 2 * x[last] - x[2 * last - i - m];
    const double d = (after - x[i]) - (x[i] - before);
    out.sum += d * d;
  }
  out.terms = last - 1;
  return out;
}

}  // namespace imulab::noise
