// Whittle's likelihood of a spectrum: the density of the model compared with the measured power of every bin, and its maximum.
//
//   S(f) = L(f) (N^2 + B^2 b(f) + K^2 k(f) + sum of sigma^2 m(f; time)) + Q^2 q(f) + r^2 T / 12,   L = 1 / (1 + (f / cutoff)^2n)
//   -2 ln likelihood = sum of count (ln S + power / S)
//
// Rounding to steps r and quantization occur after the sensor's low-pass.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/noise/spectral_terms.hpp"
#include "imulab/noise/spectrum.hpp"

#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace imulab::noise {

/// The terms of the model in addition to Q, N, B, K and the ramp.
struct Terms {
  int markov = 0;  ///< number of processes, at most two
  LowPassShape low_pass{};
  std::array<bool, 4> has{true, true, true, true};  ///< Q, N, B, K; those that the model does not have are zero
  /// Indices in Point::at and, below 4, in `has`.
  static constexpr int Q = 0, N = 1, B = 2, K = 3;
  static int sigma(int process) { return 4 + 2 * process; }
  static int time(int process) { return 5 + 2 * process; }
  int cutoff() const { return 4 + 2 * markov; }
  int count() const { return 4 + 2 * markov + (low_pass.order > 0 ? 1 : 0); }
};

inline constexpr double absent = -1e300;  ///< logarithm of an absent term
using Parameters = Eigen::Array<double, Eigen::Dynamic, 1, 0, 9, 1>;

/// Parameters: Q^2 in units of SpectrumLikelihood::Q_scale, which may be negative during the fit so that an absent term does not bias N; for the
/// others logarithms: of N^2, B^2, K^2, of sigma^2 and time of each process, then of the cutoff frequency.
struct Point {
  Parameters at = Parameters::Constant(4, absent);
  double ramp = 0;                                          ///< in addition to the line that was removed
  double misfit = std::numeric_limits<double>::infinity();  ///< -2 ln likelihood
};

/// The parameters that are fixed during a fit.
struct Fixed {
  int parameter = -1;
  std::optional<double> ramp;
  int second = -1;  ///< another parameter
};

/// A reward during a fit: the density of one bin without quantization is raised. The fit then minimizes -2 ln likelihood - weight ln S(bin).
struct Pull {
  Eigen::Index bin = 0;
  double weight = 0;
};

/// The model at one point: for each bin the density, and the part that passes the filter.
struct Modeled {
  Eigen::ArrayXd density;
  FilterShares::Shares filter;  ///< empty without a filter
};

class SpectrumLikelihood {
 public:
  /// Uses the bins of a spectrum up to a frequency; `resolution` is r of the readings, 0 if they are not rounded.
  SpectrumLikelihood(const Spectrum& spectrum, double highest_hz, double resolution, const Terms& terms);

  const std::vector<SpectrumBin>& bins() const { return bins_; }
  const Terms& terms() const { return terms_; }
  double Q_scale() const { return Q_scale_; }
  SpectrumLikelihood with(const Terms& terms) const;

  Modeled modeled(const Parameters& at) const;
  Eigen::ArrayXd density(const Parameters& at) const { return modeled(at).density; }
  /// Returns the density of a bin less that of quantization.
  double without_quantization(double density, const Parameters& at, Eigen::Index bin) const;
  /// Returns the power without the ramp, for ordinates with an amplitude.
  Eigen::ArrayXd power(double ramp) const;
  /// Returns for each ordinate the ramp's squared amplitude divided by the power of the noise: their sum is the information about the ramp.
  Eigen::ArrayXd ramp_information(const Eigen::ArrayXd& density) const;
  /// Returns derivatives of the logarithm of the density, bins by parameters.
  Eigen::MatrixXd sensitivity(const Parameters& at, const Modeled& modeled) const;
  const Eigen::ArrayXd& counts() const { return counts_; }

  /// Returns Q, N, B, K each at the largest value that the spectrum below a frequency permits over several bins; other terms are absent.
  Point start(double below_hz = std::numeric_limits<double>::infinity()) const;
  /// Returns this point with those of N, B and K that the model has at least a thousandth of the density somewhere, because a fit does not recover a
  /// vanished term.
  Point revived(Point point) const;
  /// Fits by damped Fisher scoring (Levenberg and Marquardt) until the misfit falls by less than `precision`, at most `iterations` times.
  Point fitted(Point from, const Fixed& fixed = {}, double precision = 1e-5, int iterations = 200, const Pull& pull = {}) const;
  /// Returns the model of these terms at other frequencies [Hz] of the readings, only for densities.
  SpectrumLikelihood at(const std::vector<double>& hz) const;

 private:
  SpectrumLikelihood() = default;
  Modeled judge(Point& point, const Fixed& fixed, const Pull& pull) const;
  void set_bins(std::vector<SpectrumBin> bins);
  bool possible(const Parameters& at) const;

  Terms terms_;
  std::vector<SpectrumBin> bins_;
  Eigen::ArrayXXd unit_;  // columns Q, N, B, K
  Eigen::ArrayXd counts_, power_, cosine_;
  FilterShares filter_;
  double Q_scale_ = 1, resolution_ = 0, rounding_ = 0, shortest_interval_ = std::numeric_limits<double>::infinity(), longest_time_ = 0;
};

}  // namespace imulab::noise
