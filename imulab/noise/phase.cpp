#include "imulab/noise/phase.hpp"

#include "imulab/error.hpp"

#include <Eigen/Core>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace imulab::noise {

namespace {

constexpr std::size_t lanes = 8;     // parallel sums, as an addition waits for the previous one; equal on all processors for equal results
constexpr std::size_t piece = 2048;  // points at once: three pieces fit into the first-level cache
using Lanes = Eigen::Array<double, lanes, 1>;
using Points = Eigen::Map<const Lanes>;

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

constexpr std::size_t most_octaves = 4;  // together: their sums and points fit into the registers

/// Computes `octaves` sums for the factors m, 2m, 4m, ... in order: a point that two of them need is read once.
using OctaveSums = void (*)(const double* x, std::size_t m, std::size_t n, double* sums);

template <std::size_t octaves>
void octave_sums(const double* x, std::size_t m, std::size_t n, double* sums) {
  for (std::size_t k = 0; k < octaves; ++k) sums[k] = sum_of_second(x, m << k, n);
}

#if defined(__x86_64__)
/// Like octave_sums, with registers of four numbers; not fused, so that the result is the same.
template <std::size_t octaves>
__attribute__((target("avx2"))) void wide_octave_sums(const double* x, std::size_t m, std::size_t n, double* sums) {
  __m256d low[octaves], high[octaves];
  for (std::size_t k = 0; k < octaves; ++k) low[k] = high[k] = _mm256_setzero_pd();
  const auto add = [m](__m256d * sum, const double* at) __attribute__((target("avx2"))) {
    const __m256d begin = _mm256_loadu_pd(at);
    __m256d middle = _mm256_loadu_pd(at + m);
    for (std::size_t k = 0; k < octaves; ++k) {
      const __m256d end = _mm256_loadu_pd(at + (m << (k + 1)));
      const __m256d d = _mm256_sub_pd(_mm256_sub_pd(end, middle), _mm256_sub_pd(middle, begin));
      sum[k] = _mm256_add_pd(sum[k], _mm256_mul_pd(d, d));
      middle = end;
    }
  };
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) add(low, x + i), add(high, x + i + 4);
  for (std::size_t k = 0; k < octaves; ++k) {
    Lanes sum;
    _mm256_storeu_pd(sum.data(), low[k]);
    _mm256_storeu_pd(sum.data() + 4, high[k]);
    sums[k] = sum.sum();
    for (std::size_t j = i; j < n; ++j) sums[k] += second(x + j, m << k) * second(x + j, m << k);
  }
}
#endif

/// Returns the fastest functions, indexed by the number of octaves minus one.
std::array<OctaveSums, most_octaves> fastest_octave_sums() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return {wide_octave_sums<1>, wide_octave_sums<2>, wide_octave_sums<3>, wide_octave_sums<4>};
#endif
  return {octave_sums<1>, octave_sums<2>, octave_sums<3>, octave_sums<4>};
}

/// Indices of factors, each twice the previous one.
using Octaves = std::vector<std::size_t>;

std::vector<Octaves> octaves_of(const std::vector<std::size_t>& factors) {
  std::vector<Octaves> out;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const auto before = std::find_if(
        out.begin(), out.end(), [&](const Octaves& octaves) { return octaves.size() < most_octaves && 2 * factors[octaves.back()] == factors[k]; });
    if (before == out.end())
      out.push_back({k});
    else
      before->push_back(k);
  }
  return out;
}

std::vector<SquareSum> terms_of(const std::vector<double>& phase, const std::vector<std::size_t>& factors, std::size_t order) {
  std::vector<SquareSum> sums(factors.size());
  for (std::size_t k = 0; k < factors.size(); ++k) sums[k].terms = phase.size() > order * factors[k] ? phase.size() - order * factors[k] : 0;
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

std::vector<double> phase_of(std::vector<double>&& rate) {
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
  const std::array<OctaveSums, most_octaves> sums_of = fastest_octave_sums();
  const std::vector<Octaves> together = octaves_of(factors);
  std::vector<SquareSum> sums = terms_of(phase, factors, 2);
  std::array<double, most_octaves> of_piece;
  for (std::size_t begin = 0; begin < phase.size(); begin += piece)
    for (const Octaves& octaves : together) {
      const double* const x = phase.data() + begin;
      if (sums[octaves.back()].terms >= begin + piece) {
        sums_of[octaves.size() - 1](x, factors[octaves.front()], piece, of_piece.data());
        for (std::size_t j = 0; j < octaves.size(); ++j) sums[octaves[j]].sum += of_piece[j];
      } else {
        for (const std::size_t k : octaves)
          if (sums[k].terms > begin) sums_of[0](x, factors[k], std::min(piece, sums[k].terms - begin), of_piece.data()), sums[k].sum += of_piece[0];
      }
    }
  return sums;
}

std::vector<SquareSum> third_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors) {
  std::vector<SquareSum> sums = terms_of(phase, factors, 3);
  for (std::size_t begin = 0; begin < phase.size(); begin += piece)
    for (std::size_t k = 0; k < factors.size(); ++k)
      if (sums[k].terms > begin) sums[k].sum += sum_of_third(phase.data() + begin, factors[k], std::min(piece, sums[k].terms - begin));
  return sums;
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
