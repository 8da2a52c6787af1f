#include "imulab/noise/welch.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace imulab {

WelchSpectrum welch_spectrum(std::span<const double> rate, double interval_s, std::size_t length) {
  if (length < 8 || !std::has_single_bit(length) || length > rate.size())
    throw Error(fmt::format("pieces of {} readings: expected a power of two from 8 to the record's {}", length, rate.size()));
  WelchSpectrum out{0, 1 / (static_cast<double>(length) * interval_s), std::vector<double>(length / 2 - 1)};
  std::vector<double> window(length), piece(length);
  double power = 0;
  for (std::size_t j = 0; j < length; ++j) {
    window[j] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(j) / static_cast<double>(length));
    power += window[j] * window[j];
  }
  Eigen::FFT<double> fourier;
  std::vector<std::complex<double>> transform;
  for (std::size_t begin = 0; begin + length <= rate.size(); begin += length / 2, ++out.pieces) {
    double mean = 0;
    for (std::size_t j = 0; j < length; ++j) mean += (rate[begin + j] - rate[begin]) / static_cast<double>(length);
    for (std::size_t j = 0; j < length; ++j) piece[j] = window[j] * (rate[begin + j] - rate[begin] - mean);
    fourier.fwd(transform, piece);
    for (std::size_t k = 0; k < out.density.size(); ++k) out.density[k] += std::norm(transform[k + 1]);
  }
  for (double& density : out.density) density *= interval_s / (power * static_cast<double>(out.pieces));
  return out;
}

}  // namespace imulab
