// The result of every method: the model, the uncertainty of each coefficient, quality figures, conversion to customary units, and requirements.
//
// Example:
//   for (const CoefficientIndex index : calibration.estimated) {
//     const UserValue value = user_value(calibration, index);
//     std::printf("%s %g +- %g %s\n", coefficient(index).name.data(), value.value, value.uncertainty, value.unit.c_str());
//   }
//   if (calibration.quality.verdict != Verdict::good) std::puts(verdict_text(calibration.quality).c_str());
//   for (const Requirement& r : parse_requirements("gyro.matrix.off_diagonal <= 5 arcsec"))
//     if (!assess(calibration, r).met) std::puts(to_string(r).c_str());
//
// All values are in SI units, times in UTC. The covariance of standard uncertainties (k = 1) includes sensor noise, declared rig errors, priors, and
// parameters that were considered but not estimated. Body axes are those of `frame` (frame.hpp). Types are plain values: const use is safe on any
// thread. Expanded uncertainty follows the GUM (JCGM 100).
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/finding.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A requirement and the value that was reached.
struct RequirementResult {
  std::string text = {};         ///< "gyro.matrix.diagonal <= 100 ppm"
  std::string coefficient = {};  ///< worst coefficient; of other results the figure: "gyro.x.N", "CEP"
  double limit = 0;              ///< SI
  double reached = 0;            ///< SI; for a coefficient the larger of u and U/2; infinite: not determined
  bool met = false;
  std::string note = {};  ///< basis of the judgement if it is not the usual one: "by the bound"
  bool operator==(const RequirementResult&) const = default;
};

// The declared traceability of a calibration's scales, which no data can verify.

/// The instrument that realizes a quantity, and its certificate. These declarations are not checked.
struct Reference {
  std::string quantity = {};    ///< acceleration, rotation, time or temperature
  std::string instrument = {};  ///< make, type, serial number
  std::string certificate = {};
  std::string date = {};       ///< date of the certificate, YYYY-MM-DD; may be empty
  std::string statement = {};  ///< statement of the certificate: "U = 2 arcsec, k = 2"; may be empty
  bool operator==(const Reference&) const = default;
};

// Form of a triad's readings in the calibration's recording: a program must convert such readings before it applies the model.

/// Multiply the driver's reading in column j by `si_factor(unit) / counts_per_unit`, and divide increments also by `interval_s`. The product is the
/// model's raw reading along the body axis `axes[j]`.
struct RecordedAs {
  std::string unit = {};                              ///< unit name in a session: "g", "deg/s", "count"; of increments "deg", "g*s"
  double counts_per_unit = 1;                         ///< number of counts in one `unit`; 1: the readings are in the unit itself
  double interval_s = 0;                              ///< nominal interval [s] by which increments were divided; 0: the readings are rates
  std::array<std::string, 3> axes{"+x", "+y", "+z"};  ///< body axis, with sign, along which each column measures
  bool operator==(const RecordedAs&) const = default;
};

/// A contribution to the stated uncertainty that many coefficients have in common, for example the declared uncertainty of g.
struct UncertaintySource {
  std::string name = {};         ///< "gravity"
  double relative = 0;           ///< its size relative to the quantity itself (sigma_g / g)
  std::string consequence = {};  ///< its effect, in words
  bool operator==(const UncertaintySource&) const = default;
};

/// A term that was tested for significance. A term that is not significant may stay in the fit under its prior.
struct TermTest {
  std::string term = {};  ///< "gyro.g_sensitivity"
  double statistic = 0;   ///< Wald chi-square of the term's coefficients
  int degrees_of_freedom = 0;
  double p_value = 1;
  bool kept = false;
  double cross_validation_with = 0, cross_validation_without = 0;  ///< RMS of left-out points in sigmas of their noise; 0: not computed
  bool operator==(const TermTest&) const = default;
};

/// Residuals of one axis, and the full scale that its data reached.
struct FitResidual {
  std::string axis = {};                        ///< "gyro.x"
  double rms = 0, largest = 0, full_scale = 0;  ///< m/s^2 or rad/s
  bool operator==(const FitResidual&) const = default;
};

/// A rest or rotation of the recording and its residual in the calibration.
struct PartResidual {
  double begin_s = 0, end_s = 0;  ///< [s] on the recording's clock
  double residual = 0;            ///< RMS over its equations, in units of the sigmas used in the fit
  bool used = true;               ///< false: rejected as an outlier
  std::string recording = {};     ///< file name, if the session has several recordings
  bool operator==(const PartResidual&) const = default;
};

/// An error of the rig that was estimated jointly with the coefficients, as its difference from the declaration, SI. For the aids of a drive, the
/// values are the lever arms, delays and mounting angles themselves.
struct RigErrorEstimate {
  std::string name = {};  ///< "centrifuge: radius.+z+x"
  double declared_sigma = 0;
  double value = 0, uncertainty = 0;
  bool operator==(const RigErrorEstimate&) const = default;
};

/// An effect that was estimated jointly with the coefficients (docs/theory/effects.md).
struct EffectEstimate {
  std::string name, unit;             ///< "accel.asymmetry", "ppm"
  std::vector<double> values, sigma;  ///< one value for each column of the effect, in `unit`
  bool significant = false;           ///< whether the effect is significant
  bool operator==(const EffectEstimate&) const = default;
};

/// Estimated sizes of this IMU's effects relative to the sizes expected for its grade (docs/theory/effects.md).
struct UnitSize {
  double factor = 1, factor_sigma = 0;         ///< exponential of the mean logarithm of the factor; standard deviation of that natural logarithm
  std::string grade;                           ///< the declared grade; else the most probable one
  std::map<std::string, double> weights = {};  ///< probabilities of the grades, if none is declared
  bool operator==(const UnitSize&) const = default;
};

/// Comparison with the estimate of another method from the same data.
struct SecondOpinion {
  std::string method, coefficient;  ///< `coefficient` is the one that differs most
  double sigmas = 0;                ///< its difference in standard deviations of the difference
  bool operator==(const SecondOpinion&) const = default;
};

struct Quality {
  double chi2_per_dof = 0;  ///< residuals relative to the declared or measured sample noise; on a turntable also to its declared errors
  int degrees_of_freedom = 0;
  double condition = 0;   ///< condition number of the scaled normal equations
  bool converged = true;  ///< false: the fit stopped before its corrections were small compared with their uncertainties
  std::vector<std::string> unobservable = {};
  Verdict verdict = Verdict::none;                   ///< good, or doubtful if `findings` has a doubt
  Findings findings = {};                            ///< doubts, warnings, and notes on data and settings: rests, thresholds, spreads
  std::vector<std::string> considered = {};          ///< weakly observable coefficients: their prior enters the uncertainty of the others
  std::optional<double> rotation_residual_deg = {};  ///< RMS over rotations left out of the fit (cross-validation, handheld)
  std::vector<TermTest> term_tests = {};
  std::optional<SecondOpinion> second_opinion = {};
  std::vector<EffectEstimate> effects = {};
  std::optional<UnitSize> unit_size = {};
  std::optional<std::string> cause = {};          ///< effect that causes a doubt, or effects that the data do not separate
  std::vector<FitResidual> fit_residuals = {};    ///< whole-unit
  std::vector<RigErrorEstimate> rig_errors = {};  ///< whole-unit, drive
  std::vector<UncertaintySource> sources = {};
  std::vector<PartResidual> rests, rotations;
  std::vector<RequirementResult> requirements = {};
  bool operator==(const Quality&) const = default;
};

/// The time unit of the gyro scales: seconds of the recording's own clock, or true seconds. `gain` is the known relative rate error of that clock.
struct ClockScale {
  std::string seconds = "own";  ///< "own" or "true"
  double gain = 0, sigma = 0;
  bool operator==(const ClockScale&) const = default;
};

/// Returns a text such as "of the recording's own clock, known to 50 ppm"; empty if `clock` is absent.
std::string clock_text(const std::optional<ClockScale>& clock);

/// Returns "good" or "doubtful, because ...; ..." for `quality`.
std::string verdict_text(const Quality& quality);

/// The state of a recording's file when it was used.
struct SourceFile {
  std::string file = {};  ///< name in the session
  std::string sha256;
  std::uint64_t bytes = 0;
  double first_s = 0, last_s = 0;                                            ///< first and last stamp [s]
  std::optional<std::array<double, 2>> accel_temperature, gyro_temperature;  ///< smallest and largest thermal reading
  std::string topic{};                                                       ///< topic of the gyro messages in a bag
  bool operator==(const SourceFile&) const = default;
};

/// Standard deviation (SI) of the offset at the recorded turn-on, or of the mean over several turn-ons, about the unit's mean offset. It is declared,
/// or estimated from several recordings. The covariance does not contain it; a comparison of calibrations adds it.
struct TurnOn {
  double accel = 0, gyro = 0;
  bool operator==(const TurnOn&) const = default;
};

/// White noise density of the compensated output in the rests of the calibration's recordings, SI. Zero: the axis has no visible noise.
struct RestNoise {
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
  double interval_s = 0;  ///< sample interval [s]
  int rests = 0;
  double seconds = 0;  ///< total duration of the rests [s]
  bool operator==(const RestNoise&) const = default;
};

/// Definition of the body axes: x_b along the x accelerometer and y_b in the plane of the x and y accelerometers, or the axes of the rig.
enum class BodyFrame : std::uint8_t { accelerometers, rig };
std::string_view to_string(BodyFrame frame);  ///< returns "accelerometers" or "rig"

struct Calibration {
  std::string imu, serial, method, created, software;
  std::string operated_by, station, measured;  ///< person, place and time (UTC) of the measurement
  std::string firmware, filter, warm_up, power_cycles, valid_until;
  std::vector<Reference> references = {};  ///< declared in the session
  std::string session_file, session_sha256;
  std::vector<SourceFile> sources = {};
  std::map<std::string, std::string> options = {};  ///< calibration options as they were given
  BodyFrame frame = BodyFrame::accelerometers;
  std::optional<ClockScale> clock = {};  ///< absent: no gyros, or unknown
  SensorModel model;
  std::optional<RecordedAs> recorded_accel, recorded_gyro;  ///< absent: unknown, or different in the recordings
  std::vector<CoefficientIndex> estimated = {};             ///< rows and columns of `covariance`, in order
  Eigen::MatrixXd covariance;                               ///< SI, one row and column for each of `estimated`
  Eigen::MatrixXd constant_covariance = {};                 ///< part of `covariance` that recurs in the next calibration of the same IMU; empty: zero
  Quality quality;
  std::optional<TurnOn> turn_on = {};  ///< absent: not declared, or included in the covariance
  /// Standard uncertainties [SI] of the offsets after the next switch-on, by coefficient name; empty if all recordings are from one switch-on.
  std::map<std::string, double> next_switch_on = {};
  std::optional<RestNoise> rest_noise = {};  ///< absent: unknown, or the recordings have no rests
};

/// Throws Error with all faults of a calibration, made in memory or read from a file: estimated coefficients that are unknown or listed twice; a
/// covariance of another size, not finite, not symmetric, with a negative variance or a correlation beyond 1; a model that is not finite, has unknown
/// units, or has thermal terms without a reference. A calibration without covariance must have no estimated coefficients.
void validate(const Calibration& calibration);

/// The raw readings for which the linear model of a triad gives zero output, -A1^-1 A0, and their standard uncertainties (NaN if a coefficient of the
/// row was not estimated). For readings in counts, datasheets call this the zero level.
struct RawZero {
  Vector3d value, uncertainty;
};
RawZero raw_zero(const Calibration& calibration, Triad triad);

/// Returns the coefficients of offsets and matrices that the data did not determine: they still have starting values and must not be used.
std::vector<std::string> unusable(const Calibration& calibration);

/// Returns the standard uncertainty [SI] of the coefficient `index`; absent if it was not estimated or the frame fixes it. Throws Error if the index
/// is outside the table or the covariance has another size than `estimated`.
std::optional<double> standard_uncertainty(const Calibration& calibration, CoefficientIndex index);

struct UserValue {
  double value = 0;
  double uncertainty = 0;  ///< standard uncertainty; NaN if it was not estimated
  /// The same for all coefficients of one term of a triad; empty if the readings are counts and the unit has no name.
  std::string unit = {};
};

/// Returns a coefficient in user units. Scales: ppm from one, or counts per unit. Misalignments: relative to the scale of their row.
UserValue user_value(const Calibration& calibration, CoefficientIndex index);

/// Returns the value of the coefficient in `other`, for example the start of the fit, with the unit and uncertainty of `calibration`.
UserValue user_value(const Calibration& calibration, CoefficientIndex index, const SensorModel& other);

// The uncertainty of a coefficient as a certificate states it (GUM, JCGM 100): u, effective degrees of freedom, k, U.

/// All values are SI. Type A is the uncertainty of the fit, which includes declared rig errors and priors: a calibration does not separate these.
/// Type B is the declared uncertainty that is known separately, that of g, which enters the accelerometer scales.
struct ExpandedUncertainty {
  double standard = 0;            ///< u
  double from_fit = 0;            ///< type A
  double declared = 0;            ///< type B
  double degrees_of_freedom = 0;  ///< effective (Welch-Satterthwaite); infinite if the declared part dominates
  double coverage_factor = 0;     ///< k for 95.45 % of a t distribution
  double expanded = 0;            ///< U = k u
};

/// Returns the expanded uncertainty of the estimated coefficient `index`. Throws Error if the coefficient has no uncertainty.
ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index);

struct Requirement {
  std::string selector = {};
  std::vector<CoefficientIndex> coefficients = {};
  double limit = 0;  ///< SI, above 0
  UserUnit unit;     ///< unit in which the limit was stated
};

/// Returns a text such as "gyro.matrix.off_diagonal <= 5 arcsec".
std::string to_string(const Requirement& requirement);

/// Parses requirements separated by commas. Throws Error for text of another form, for an unknown coefficient or one that cannot be required (only
/// offset, matrix and g_sensitivity can), for a number that is not above 0, and for a unit that the coefficients cannot have.
std::vector<Requirement> parse_requirements(std::string_view text);

/// Compares the larger of u and U/2 of the worst coefficient with the limit; matrix elements are relative to the scale of their row. A coefficient
/// that was not estimated counts as infinite; one that the frame fixes is skipped. A doubtful calibration, or fewer than 3 effective degrees of
/// freedom, does not meet a requirement.
RequirementResult assess(const Calibration& calibration, const Requirement& requirement);

}  // namespace imulab
