// The noise of an IMU from a log at rest: Allan-type deviations and the coefficients of IEEE Std 952 (doi:10.1109/IEEESTD.1998.86153) with intervals.
//
// Example:
//   const NoiseAnalysis log = analyze_noise(recording, session);
//   for (const NoiseAxis& axis : log.axes)
//     if (axis.fit) std::printf("%s N = %g, u = %g\n", axis.name.c_str(), axis.fit->N.value, axis.fit->N.standard_uncertainty);
//   const std::vector<DeviationPoint> curve = deviation(gyro[0], 0.01, averaging_factors(gyro[0].size()));
//
// Coefficients: maximum likelihood on the spectrum (Whittle), intervals from the profile of the likelihood (docs/theory/noise.md). Valid for
// stationary noise of 64 readings and more; slow terms (B, K) need records that are long against the times at which they dominate. Deviations: NIST
// SP 1065 (Riley 2008); degrees of freedom: Greenhall and Riley 2003, for the noise identified at each averaging time by the lag-1 autocorrelation
// (Riley and Greenhall 2004), and with fewer than 30 averages by the ratio of standard to Allan variance (Barnes 1969). Units are those of the
// readings: rad/s, m/s^2 or counts. n samples take a time of n log n. Safe on any thread.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Unit as in NoiseModel. Where the interval holds zero the coefficient is not determined: value and standard uncertainty are NaN, and `upper` bounds
/// its size with 95 %.
struct NoiseCoefficient {
  double value = 0, standard_uncertainty = 0;
  double lower = 0, upper = 0;  ///< 95 %
  bool determined = false;
};
/// One of which no more is known than this bound.
inline NoiseCoefficient undetermined_below(double upper) { return {NAN, NAN, 0, upper, false}; }

/// A first-order Gauss-Markov process: standard deviation [u] and correlation time [s]. Two-sided density 2 sigma^2 time / (1 + (2 pi f time)^2).
struct MarkovTerm {
  NoiseCoefficient sigma, time;
};

/// The noise coefficients of one axis.
struct NoiseCoefficients {
  NoiseCoefficient Q, N, B, K, R;
  std::vector<MarkovTerm> markov = {};  ///< by falling correlation time
};

/// The contribution of each term to the Allan variance over an averaging time [u^2] (IEEE Std 952); a term that is not determined adds nothing.
struct AllanTerms {
  double Q = 0, N = 0, B = 0, K = 0, R = 0, markov = 0;
  double sum() const { return Q + N + B + K + R + markov; }
};
AllanTerms allan_variance(const NoiseCoefficients& noise, double tau_s);

/// Axes without coefficients (constant readings) have none.
struct ImuNoise {
  std::string recording = {};
  double interval_s = 0;
  std::string gyro_unit, accel_unit;  ///< of u: "rad/s", "m/s^2", or "count"
  std::array<std::optional<NoiseCoefficients>, 3> gyro, accel;
};

/// The sizes of a triad's terms: the root mean square over its axes of what is determined, 0 where it is on no axis. Throws Error for readings in
/// counts, or where N is determined on no axis. Markov processes are left out: NoiseModel has none.
NoiseModels noise_sizes(const ImuNoise& noise);

enum class DeviationKind { overlapping_allan, allan, modified_allan, hadamard, overlapping_hadamard, total };
/// By kind.
inline constexpr std::array<std::string_view, 6> deviation_names{"overlapping-allan",    "allan", "modified-allan", "hadamard",
                                                                 "overlapping-hadamard", "total"};
/// Empty where no kind has this name.
std::optional<DeviationKind> deviation_kind(std::string_view name);

/// One averaging time. Bounds are two-sided, from chi-square with `edf`. A total deviation is not corrected for its bias in flicker and random walk.
struct DeviationPoint {
  std::size_t factor = 0;  ///< averaging time in samples
  double tau = 0;          ///< [s]
  double deviation = 0;    ///< unit of the rate
  std::size_t terms = 0;   ///< number of squares averaged
  int noise_type = 0;      ///< power-law exponent alpha of the rate's spectrum: 2 (quantization) to -2 (random walk; -4 for Hadamard)
  double edf = 0;          ///< equivalent degrees of freedom
  double lower_68 = 0, upper_68 = 0, lower_95 = 0, upper_95 = 0;
};

/// Four averaging factors an octave (4 to 7 times a power of two) up to a third of the record.
std::vector<std::size_t> averaging_factors(std::size_t samples);

/// The deviation at each of the factors that the record is long enough for: at least one term (with the modified and Hadamard kinds 3 factors of
/// N + 1 points, with the others 2). Throws Error for fewer than 3 samples, a reading that is not finite, an interval that is not positive, or a
/// factor 0.
std::vector<DeviationPoint> deviation(std::span<const double> rate, double interval_s, const std::vector<std::size_t>& factors,
                                      DeviationKind kind = DeviationKind::overlapping_allan);
/// Computes the same deviations, bit for bit, in the memory of the readings, if the vector has room for one more number.
std::vector<DeviationPoint> deviation_in_place(std::vector<double>&& rate, double interval_s, const std::vector<std::size_t>& factors,
                                               DeviationKind kind = DeviationKind::overlapping_allan);

/// A range of frequencies in which the spectrum is not the model's.
struct NoiseMisfit {
  double low_hz = 0, high_hz = 0, ratio = 1;  ///< measured power over the model's
};

/// A sinusoid in the readings, taken out of the spectrum: amplitude [u].
struct NoiseLine {
  double hz = 0;
  NoiseCoefficient amplitude;
};

/// The sensor's own: a Butterworth filter, before the readings are taken or digital at their rate.
struct LowPass {
  int order = 1;
  bool digital = false;
  NoiseCoefficient cutoff_hz;
};

/// The measured density and the model's, two-sided, at a frequency; on `count` degrees of freedom.
struct SpectrumPoint {
  double hz = 0, density = 0, model = 0, count = 0;
};

struct NoiseFit : NoiseCoefficients {
  std::optional<LowPass> low_pass = {};
  std::vector<NoiseLine> lines = {};         ///< by frequency; lines above half the rate appear at their alias below it
  double resolution = 0;                     ///< step of the readings; 0: not rounded, or finely
  double chi2_per_dof = 0;                   ///< of the power in some dozens of ranges of frequency
  double highest_hz = 0;                     ///< higher frequencies were left out because the model does not hold there; else half the rate
  bool cut = false;                          ///< whether some were
  std::vector<NoiseMisfit> misfits = {};     ///< remaining misfits; all intervals are then widened by the root of chi2_per_dof
  std::vector<SpectrumPoint> spectrum = {};  ///< without the lines

  bool accepted() const { return misfits.empty(); }
};

/// Q, N, B, K and the ramp are always fitted; Markov processes (up to two), a low-pass and lines (up to eight) where the spectrum shows them. The
/// intervals of B and K also allow for one more process, as far as the spectrum does not exclude it. Throws Error for fewer than 64 readings, a
/// reading that is not finite or an interval that is not positive; Unsupported where the readings are constant. `step`: of rounded readings, 0 where
/// they are not rounded; absent: the step that the readings show.
NoiseFit fit_noise(std::span<const double> rate, double interval_s, std::optional<double> step = {});

struct NoiseAxis {
  std::string name = {};  ///< "gyro.x"
  std::string unit = {};  ///< of its readings: "rad/s", "m/s^2" or "count"
  std::vector<DeviationPoint> deviation = {};
  std::optional<NoiseFit> fit = {};  ///< none where the axis has no usable noise:
  std::string problem = {};          ///< why
};

struct NoiseAnalysis {
  std::string recording = {};
  double begin_s = 0, end_s = 0, interval_s = 0;
  std::size_t samples = 0;
  DeviationKind kind = DeviationKind::overlapping_allan;
  std::vector<NoiseAxis> axes = {};        ///< gyros, then accelerometers
  std::vector<std::string> notes = {};     ///< what was cut
  std::vector<std::string> warnings = {};  ///< findings, and their consequence for the result
};

struct NoiseOptions {
  DeviationKind kind = DeviationKind::overlapping_allan;
  bool remove_temperature = false;  ///< a least-squares parabola in the triad's temperature is subtracted; this removes some of K and B, too
  bool accel_joined = false;        ///< the accelerometers' readings are means over the gyros' intervals: no warning of the end of their spectrum
};

/// Axes in parallel; the result does not depend on the number of threads. The longest part at rest counts, whose limits the notes name: between the
/// holds of the session's steps, or found; without gaps or saturated samples, but that a few lost ones are filled. Throws Unsupported where none is
/// as long as 30 s and 1024 samples, and where a temperature is to be removed that the recording does not have, or that does not change; Error as
/// detect_rests.
NoiseAnalysis analyze_noise(Recording recording, const Session& session, const NoiseOptions& options = {});

// Several logs together, of one unit or of a batch: mean, spread and worst of each coefficient.

struct BatchCoefficient {
  int determined = 0;  ///< number of logs that determine it
  /// Mean of these, with the larger of the uncertainty that the logs state and that their scatter shows; where none determines it, the largest bound.
  NoiseCoefficient mean;
  double spread = 0;  ///< standard deviation from log to log beyond what the logs' uncertainties explain; NaN for fewer than two
  double worst = 0;   ///< largest value, or bound of a log that does not determine it
  std::size_t worst_log = 0;
};

/// Q, N, B, K, R of one axis, in this order.
struct BatchAxis {
  std::string name, unit;
  std::array<BatchCoefficient, 5> coefficients;
};

struct NoiseBatch {
  std::vector<NoiseAnalysis> logs = {};
  std::vector<BatchAxis> axes = {};
};

/// Throws Error where the logs' units differ.
NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs);

}  // namespace imulab
