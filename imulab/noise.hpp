// IMU noise from a log at rest: Allan-type deviations, and IEEE Std 952 coefficients (doi:10.1109/IEEESTD.1998.86153) with intervals.
//
// Example:
//   const NoiseAnalysis log = analyze_noise(recording, session);
//   for (const NoiseAxis& axis : log.axes)
//     if (axis.fit) std::printf("%s N = %g, u = %g\n", axis.name.c_str(), axis.fit->N.value, axis.fit->N.standard_uncertainty);
//   const std::vector<DeviationPoint> curve = deviation(gyro[0], 0.01, averaging_factors(gyro[0].size()));
//
// Coefficients are maximum likelihood estimates from the spectrum (Whittle) with intervals from the likelihood profile (docs/theory/noise.md). They
// are valid for at least 64 readings with stationary noise; slow terms (B, K) require records that are long compared with the times at which they
// dominate. Deviations follow NIST SP 1065 (Riley 2008), and degrees of freedom Greenhall and Riley 2003. The noise type at each averaging time is
// identified by the lag-1 autocorrelation (Riley and Greenhall 2004), or for fewer than 30 averages by the ratio of standard to Allan variance
// (Barnes 1969). Units are those of the readings: rad/s, m/s^2 or counts. The time for n samples is of order n log n. Safe on any thread.
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

/// Units are those of NoiseModel. If the interval contains zero, the coefficient is not determined: value and uncertainty are NaN; `upper` bounds its
/// size.
struct NoiseCoefficient {
  double value = 0, standard_uncertainty = 0;
  double lower = 0, upper = 0;  ///< bounds of the 95 % interval
  bool determined = false;
  bool bounded = false;  ///< of a data sheet: derived from its other values, as a bound
};
/// Returns a coefficient of which only the upper bound is known.
inline NoiseCoefficient undetermined_below(double upper) { return {NAN, NAN, 0, upper, false}; }

/// A first-order Gauss-Markov process: standard deviation [u], correlation time [s]; two-sided density 2 sigma^2 time / (1 + (2 pi f time)^2).
struct MarkovTerm {
  NoiseCoefficient sigma, time;
};

/// Options of a bound.
struct BoundOptions {
  double horizon_s = 600;    ///< longest time for which a filter runs without aids
  double confidence = 0.95;  ///< that the spectrum at a frequency is below the largest that is assumed
};

/// The largest two-sided density [u^2/Hz] that a log permits at a frequency.
struct UpperDensity {
  double hz = 0, density = 0;
};

/// A first-order Gauss-Markov process of a bound: standard deviation [u], correlation time [s].
struct BoundProcess {
  double sigma = 0, time = 0;
};

/// The cost of a bound: its Allan deviation at a time over that of the fitted coefficients.
struct BoundCoast {
  double time_s = 0, ratio = 1;
};

/// A noise model for a filter whose spectrum is nowhere below the largest that the log permits, or the logs in motion that were compared with it, from
/// 1 / (10 horizon) to half the rate (docs/theory/noise.md). Units as NoiseModel.
struct NoiseBound {
  double N = 0;
  std::vector<BoundProcess> markov = {};  ///< at most two, in the order of decreasing times
  double K = 0;
  double start_sigma = 0;  ///< standard deviation at the start of the walk, or of a constant bias, without that of switch-on
  double confidence = 0.95, horizon_s = 600;
  double tightness = 1;  ///< mean of the model's density over the bound's, over the logarithm of the frequency
  std::vector<BoundCoast> coast = {};
  std::vector<UpperDensity> upper = {};
  bool in_motion = false;  ///< true if a log in motion raised `upper`
};

/// The Allan deviation of bias instability and random walk together at the averaging time where a log determines it best.
struct JointNoise {
  double tau_s = 0;
  NoiseCoefficient deviation;
};

/// The noise coefficients of one axis.
struct NoiseCoefficients {
  NoiseCoefficient Q, N, B, K, R;
  std::vector<MarkovTerm> markov = {};  ///< in the order of decreasing correlation time
  std::optional<NoiseBound> bound = {};
};

/// The contribution of each term to the Allan variance at one averaging time [u^2] (IEEE Std 952). A term that is not determined contributes nothing.
struct AllanTerms {
  double Q = 0, N = 0, B = 0, K = 0, R = 0, markov = 0;
  double sum() const { return Q + N + B + K + R + markov; }
};
AllanTerms allan_variance(const NoiseCoefficients& noise, double tau_s);  ///< `tau_s`: averaging time [s]

/// The noise of an IMU. An axis with constant readings has no coefficients.
struct ImuNoise {
  std::string recording = {};
  double interval_s = 0;
  std::string gyro_unit, accel_unit;  ///< units u: "rad/s", "m/s^2" or "count"
  std::array<std::optional<NoiseCoefficients>, 3> gyro, accel;
  bool from_data_sheet = false;
  bool has_moving = false;  ///< the file also contains values in motion
};

/// True if every axis with noise has a bound.
bool has_bounds(const ImuNoise& noise);

/// Returns the sizes of each triad's terms: the RMS over the axes that determine a term, or 0 if no axis does. Markov processes are omitted because
/// NoiseModel has none. Throws Error for readings in counts, or if no axis determines N.
NoiseModels noise_sizes(const ImuNoise& noise);

enum class DeviationKind { overlapping_allan, allan, modified_allan, hadamard, overlapping_hadamard, total };
/// Names in the order of DeviationKind.
inline constexpr std::array<std::string_view, 6> deviation_names{"overlapping-allan",    "allan", "modified-allan", "hadamard",
                                                                 "overlapping-hadamard", "total"};
/// Returns the kind with this name; empty if there is none.
std::optional<DeviationKind> deviation_kind(std::string_view name);

/// A deviation at one averaging time. Bounds are two-sided, from chi-square with `edf`. A total deviation is not corrected for its bias in flicker
/// and random walk noise.
struct DeviationPoint {
  std::size_t factor = 0;  ///< averaging time in samples
  double tau = 0;          ///< [s]
  double deviation = 0;    ///< unit of the rate
  std::size_t terms = 0;   ///< number of averaged squares
  int noise_type = 0;      ///< power-law exponent alpha of the rate's spectrum: 2 (quantization) to -2 (random walk; -4 for Hadamard)
  double edf = 0;          ///< equivalent degrees of freedom
  double lower_68 = 0, upper_68 = 0, lower_95 = 0, upper_95 = 0;
};

/// Returns four averaging factors per octave (4 to 7 times a power of two) up to a third of `samples`.
std::vector<std::size_t> averaging_factors(std::size_t samples);

/// Returns the deviation at each factor for which the record is long enough: modified and Hadamard kinds require 3 factors of N + 1 points, the
/// others 2. `rate`: readings (any unit) at equal intervals `interval_s` [s]; `factors`: averaging times in samples; `kind`: type of deviation.
/// Throws Error for fewer than 3 samples, a reading that is not finite, an interval that is not positive, or a factor 0.
std::vector<DeviationPoint> deviation(std::span<const double> rate, double interval_s, const std::vector<std::size_t>& factors,
                                      DeviationKind kind = DeviationKind::overlapping_allan);
/// Computes bit-identical deviations in the memory of the readings, if the vector has capacity for one more number.
std::vector<DeviationPoint> deviation_in_place(std::vector<double>&& rate, double interval_s, const std::vector<std::size_t>& factors,
                                               DeviationKind kind = DeviationKind::overlapping_allan);

/// A frequency range in which the spectrum differs from the model.
struct NoiseMisfit {
  double low_hz = 0, high_hz = 0, ratio = 1;  ///< ratio of measured power to the model's
};

/// A sinusoid that was removed from the spectrum; amplitude in u.
struct NoiseLine {
  double hz = 0;
  NoiseCoefficient amplitude;
};

/// The sensor's own low-pass: an analog Butterworth filter before sampling, or a digital one at the sampling rate.
struct LowPass {
  int order = 1;
  bool digital = false;
  NoiseCoefficient cutoff_hz;
};

/// Measured density and model density, two-sided, at one frequency, with `count` degrees of freedom.
struct SpectrumPoint {
  double hz = 0, density = 0, model = 0, count = 0;
};

struct NoiseFit : NoiseCoefficients {
  std::optional<JointNoise> joint = {};  ///< if the log determines neither B nor K, but both together
  std::optional<LowPass> low_pass = {};
  std::vector<NoiseLine> lines = {};         ///< sorted by frequency; lines above half the sampling rate appear at their alias below it
  double resolution = 0;                     ///< step of the readings; 0: not rounded, or the step is negligible
  double chi2_per_dof = 0;                   ///< chi-square of the power in several dozen frequency ranges
  double highest_hz = 0;                     ///< highest frequency used: half the rate, or less if the model is invalid above
  bool cut = false;                          ///< higher frequencies were excluded
  std::vector<NoiseMisfit> misfits = {};     ///< remaining misfits; all intervals are then widened by the square root of chi2_per_dof
  std::vector<SpectrumPoint> spectrum = {};  ///< measured spectrum without lines

  bool accepted() const { return misfits.empty(); }  ///< true if the model fits the spectrum
};

/// The terms of a model in addition to white noise and a ramp.
struct NoiseModelTerms {
  bool Q = false, B = false, K = false;
  int processes = 0;  ///< first-order Gauss-Markov processes, at most two
};

/// "N, B, K" or "N, M1, M2" of the terms. Throws Error for another text.
NoiseModelTerms parse_noise_terms(std::string_view text);
std::string to_string(const NoiseModelTerms& terms);

struct NoiseFitOptions {
  std::optional<double> step = {};            ///< of rounded readings, 0 if they are not rounded; absent: estimated from the readings
  std::optional<NoiseModelTerms> model = {};  ///< absent: Q, B, K, and processes as the spectrum requires
  std::optional<BoundOptions> bound = {};
};

/// Fits the noise terms to readings `rate` at intervals `interval_s` [s]. N and the ramp are always fitted, and without a `model` also Q, B and K; up
/// to two Markov processes, a low-pass and up to eight lines only if significant. The intervals of B and K also allow for one more process unless the
/// spectrum excludes it. A term that a given `model` does not have is not determined, with a bound of 0. With `bound`, the fit has one. Throws Error
/// for fewer than 64 readings, a reading that is not finite or an interval that is not positive; throws Unsupported for constant readings, or a
/// horizon longer than a third of the record.
NoiseFit fit_noise(std::span<const double> rate, double interval_s, const NoiseFitOptions& options = {});

struct NoiseAxis {
  std::string name = {};  ///< "gyro.x"
  std::string unit = {};  ///< unit of the readings: "rad/s", "m/s^2" or "count"
  double mean = NAN;      ///< of the readings; NaN: unknown
  std::vector<DeviationPoint> deviation = {};
  std::optional<NoiseFit> fit = {};  ///< absent if the axis has no usable noise
  std::string problem = {};          ///< reason for an absent fit
};

/// A value of a data sheet beside that of a log, in SI. `value` is NaN if the log does not determine it; `upper` then bounds it.
struct SheetComparison {
  std::string name = {};  ///< "gyro.x.N", or "gyro.x.stability": the minimum of the deviation
  double sheet = 0, value = 0, lower = 0, upper = 0;
  double ratio() const { return value / sheet; }
  bool contained() const { return lower <= sheet && sheet <= upper; }
};

/// A cause of the noise in motion that a log at rest does not contain (docs/theory/noise.md has the equation of each).
struct MovingCause {
  std::string name = {};                              ///< "white", "vibration", "below 1 Hz", "stamps", "rectification", "drift" or "motion"
  std::string parameter = {};                         ///< the filter's parameter that the factor multiplies: "N", "K" or "bias" (bias instability)
  NoiseCoefficient factor = {NAN, NAN, 0, INFINITY};  ///< at least 1, except of white
  double size = NAN;                                  ///< the cause itself in SI or counts, as docs/reference/noise.md lists it
  std::optional<double> hz = {};                      ///< of vibration: frequency of its largest density
  std::optional<double> stamps_s = {};                ///< of stamps: their RMS deviation from an even clock
  std::optional<double> temperature_change = {};      ///< of drift: in the unit of the thermometer, if there is one
  std::string file = {};                              ///< the log or result that shows it
  std::string reason = {};                            ///< why it is not determined, or what limits it
};

/// What a filter should use in motion, of one axis.
struct MovingTotal {
  double factor = NAN, value = NAN;  ///< of and as the parameter; NaN: no cause of it is determined
};
struct MovingAxis {
  std::string name = {}, unit = {};  ///< as in NoiseAxis
  std::vector<MovingCause> causes = {};
  MovingTotal N, K, bias;  ///< N of the variance per sample; the value of bias is the shift, 0 if it is not significant
  MovingTotal slow_N;      ///< N of what accumulates over a second and more
};

/// Where the factor between the noise of a log at rest and that of a filter in motion comes from.
struct MovingNoise {
  std::vector<std::string> files = {};  ///< each with what it is: "idle.csv: at rest, 120 s"
  std::vector<MovingAxis> axes = {};
};

struct NoiseAnalysis {
  std::string source = {};  ///< "data sheet" if no log was analyzed
  std::string recording = {};
  double begin_s = 0, end_s = 0, interval_s = 0;
  std::size_t samples = 0;
  DeviationKind kind = DeviationKind::overlapping_allan;
  std::vector<NoiseAxis> axes = {};  ///< gyros, then accelerometers
  std::vector<SheetComparison> sheet = {};
  std::optional<MovingNoise> moving = {};
  std::vector<std::string> notes = {};     ///< excluded parts of the log, or the values of a data sheet as given
  std::vector<std::string> warnings = {};  ///< findings and their consequences

  bool from_data_sheet() const { return !source.empty(); }
};

struct NoiseOptions {
  DeviationKind kind = DeviationKind::overlapping_allan;
  /// Subtracts a least-squares parabola in the triad's temperature; this also removes part of K and B.
  bool remove_temperature = false;
  std::optional<NoiseModelTerms> model = {};  ///< absent: chosen by the spectrum
  std::optional<BoundOptions> bound = {};
  /// The accelerometer readings are means over the gyro intervals: suppresses the warning that their spectrum ends early.
  bool accel_joined = false;
};

/// Analyzes all axes in parallel; the result does not depend on the number of threads. The analysis uses the longest part at rest, either between the
/// holds of the session's steps or found in the data, and its notes state the limits. That part has no gaps or saturated samples, but a few lost
/// samples are filled in. Throws Unsupported if no part is as long as 30 s and 1024 samples, or if a temperature to be removed is missing or
/// constant; throws Error as detect_rests does.
NoiseAnalysis analyze_noise(Recording recording, const Session& session, const NoiseOptions& options = {});

// Joint statistics of several logs of one unit or a batch: mean, spread and worst value of each coefficient.

struct BatchCoefficient {
  int determined = 0;  ///< number of logs that determine it
  /// Mean over these logs, with the larger of stated uncertainty and uncertainty from the scatter; if there are none, the largest bound.
  NoiseCoefficient mean;
  /// Standard deviation between logs beyond their stated uncertainties; NaN for fewer than two logs.
  double spread = 0;
  double worst = 0;  ///< largest value, or largest bound of a log that does not determine the coefficient
  std::size_t worst_log = 0;
};

/// Coefficients Q, N, B, K, R of one axis, in this order.
struct BatchAxis {
  std::string name, unit;
  std::array<BatchCoefficient, 5> coefficients;
  std::optional<NoiseBound> bound = {};  ///< above the spectra of all logs
};

struct NoiseBatch {
  std::vector<NoiseAnalysis> logs = {};
  std::vector<BatchAxis> axes = {};
};

/// Combines analyses of several logs. Throws Error if their units differ.
NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs);

}  // namespace imulab
