// The result of every method: the model, the uncertainty of each coefficient, and what the residuals say; coefficients in customary units, and
// requirements on them.
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
// SI throughout; times are UTC. The covariance (of standard uncertainties, k = 1) includes sensor noise, the rig's declared errors and priors, and
// what was only considered. Body axes are those of `frame` (frame.hpp). A plain value: const use is safe on any thread. Expanded uncertainty: GUM
// (JCGM 100).
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

/// A requirement, and what was reached.
struct RequirementResult {
  std::string text = {};         ///< "gyro.matrix.diagonal <= 100 ppm"
  std::string coefficient = {};  ///< the worst of them; of other results the figure: "gyro.x.N", "CEP"
  double limit = 0;              ///< SI
  double reached = 0;            ///< SI, of a coefficient the larger of u and U/2; infinite: not determined
  bool met = false;
  std::string note = {};  ///< how it was judged, where that is not plain: "by the bound"
  bool operator==(const RequirementResult&) const = default;
};

// The origin of a calibration's scales, as far as it is declared: no data show it.

/// The instrument behind a quantity, and its certificate. None of this is checked.
struct Reference {
  std::string quantity = {};    ///< acceleration, rotation, time or temperature
  std::string instrument = {};  ///< make, type, serial number
  std::string certificate = {};
  std::string date = {};       ///< of the certificate, YYYY-MM-DD; may be empty
  std::string statement = {};  ///< of the certificate: "U = 2 arcsec, k = 2"; may be empty
  bool operator==(const Reference&) const = default;
};

// The form of a triad's readings in the calibration's recording: a program that takes the same readings must convert them.

/// Reading of column j, as the driver gives it, times `si_factor(unit) / counts_per_unit` (of increments also divided by `interval_s`) is the raw
/// reading of the calibration's model along the body axis `axes[j]`.
struct RecordedAs {
  std::string unit = {};                              ///< as a session names it: "g", "deg/s", "count"; of increments "deg", "g*s"
  double counts_per_unit = 1;                         ///< number of the recording's counts in one `unit`; 1: the recording has the unit itself
  double interval_s = 0;                              ///< of increments: the nominal interval that they were divided by; 0: the readings are rates
  std::array<std::string, 3> axes{"+x", "+y", "+z"};  ///< along which body axis each column measures, with its sign
  bool operator==(const RecordedAs&) const = default;
};

/// One contribution to the stated uncertainty that is common to many coefficients, for example the declared uncertainty of g.
struct UncertaintySource {
  std::string name = {};         ///< "gravity"
  double relative = 0;           ///< its size relative to the quantity itself (sigma_g / g)
  std::string consequence = {};  ///< its effect, in words
  bool operator==(const UncertaintySource&) const = default;
};

/// A term that was tested for significance: seen, or not; a term that is not seen may stay in the fit under its prior.
struct TermTest {
  std::string term = {};  ///< "gyro.g_sensitivity"
  double statistic = 0;   ///< Wald chi-square of the term's coefficients
  int degrees_of_freedom = 0;
  double p_value = 1;
  bool kept = false;
  double cross_validation_with = 0, cross_validation_without = 0;  ///< RMS of left-out points in sigmas of their noise; 0: not done
  bool operator==(const TermTest&) const = default;
};

/// Residuals of one axis relative to the full scale that the data reached.
struct FitResidual {
  std::string axis = {};                        ///< "gyro.x"
  double rms = 0, largest = 0, full_scale = 0;  ///< m/s^2 or rad/s
  bool operator==(const FitResidual&) const = default;
};

/// A rest or a rotation of the recording, and how it agrees with the calibration.
struct PartResidual {
  double begin_s = 0, end_s = 0;  ///< of the recording's clock
  double residual = 0;            ///< RMS over its equations, in the sigmas with which they enter the fit
  bool used = true;               ///< false: dropped as an outlier
  std::string recording = {};     ///< its file, where the session has several
  bool operator==(const PartResidual&) const = default;
};

/// An error of the rig that was estimated jointly with the coefficients: its difference from the declaration. SI. Of a drive's aids the lever arms,
/// delays and mounting angles themselves.
struct RigErrorEstimate {
  std::string name = {};  ///< "centrifuge: radius.+z+x"
  double declared_sigma = 0;
  double value = 0, uncertainty = 0;
  bool operator==(const RigErrorEstimate&) const = default;
};

/// An effect that was estimated beside the coefficients (docs/theory/effects.md).
struct EffectEstimate {
  std::string name, unit;             ///< "accel.asymmetry", "ppm"
  std::vector<double> values, sigma;  ///< of its columns, in that unit
  bool significant = false;           ///< the data show it
  bool operator==(const EffectEstimate&) const = default;
};

/// How large the effects of this IMU are against their sizes in its grade, as the data show (docs/theory/effects.md).
struct UnitSize {
  double factor = 1, factor_sigma = 0;         ///< its logarithm is that of the factor's mean; the standard deviation of the natural logarithm
  std::string grade;                           ///< the declared one; else the most probable
  std::map<std::string, double> weights = {};  ///< without a declared one: the probabilities of the grades
  bool operator==(const UnitSize&) const = default;
};

/// The estimate of another method from the same data.
struct SecondOpinion {
  std::string method, coefficient;  ///< that differs most
  double sigmas = 0;                ///< by this many standard deviations of the difference
  bool operator==(const SecondOpinion&) const = default;
};

struct Quality {
  double chi2_per_dof = 0;  ///< residuals against the declared or measured sample noise alone; on a turntable also its declared errors
  int degrees_of_freedom = 0;
  double condition = 0;   ///< of the scaled normal equations
  bool converged = true;  ///< false: the fit stopped before its corrections were small against their uncertainties
  std::vector<std::string> unobservable = {};
  Verdict verdict = Verdict::none;                   ///< good, or doubtful for the doubts among the findings
  Findings findings = {};                            ///< doubts, warnings, and notes on the data and settings used: rests, thresholds, spreads
  std::vector<std::string> considered = {};          ///< coefficients that the data hardly show: their prior enters the uncertainty of the others
  std::optional<double> rotation_residual_deg = {};  ///< cross-validated, RMS over rotations left out of the fit (handheld)
  std::vector<TermTest> term_tests = {};
  std::optional<SecondOpinion> second_opinion = {};
  std::vector<EffectEstimate> effects = {};
  std::optional<UnitSize> unit_size = {};
  std::optional<std::string> cause = {};          ///< of a doubt: the effect, or those that the data do not tell apart
  std::vector<FitResidual> fit_residuals = {};    ///< whole-unit
  std::vector<RigErrorEstimate> rig_errors = {};  ///< whole-unit, drive
  std::vector<UncertaintySource> sources = {};
  std::vector<PartResidual> rests, rotations;
  std::vector<RequirementResult> requirements = {};
  bool operator==(const Quality&) const = default;
};

/// The seconds of the gyros' scales: those of the recording's own clock, or true ones. By how much that clock gains, relative, as far as is known.
struct ClockScale {
  std::string seconds = "own";  ///< or "true"
  double gain = 0, sigma = 0;
  bool operator==(const ClockScale&) const = default;
};

/// "of the recording's own clock, known to 50 ppm"; empty where it is not stated.
std::string clock_text(const std::optional<ClockScale>& clock);

/// "good", or "doubtful, because ...; ...".
std::string verdict_text(const Quality& quality);

/// A recording's file in its state when it was used.
struct SourceFile {
  std::string file = {};  ///< as the session names it
  std::string sha256;
  std::uint64_t bytes = 0;
  double first_s = 0, last_s = 0;                                            ///< first and last stamp
  std::optional<std::array<double, 2>> accel_temperature, gyro_temperature;  ///< smallest and largest thermal reading
  std::string topic{};                                                       ///< of a bag: of the gyros' messages
  bool operator==(const SourceFile&) const = default;
};

/// The offsets of the turn-ons that were recorded, or their mean, about those of the unit: one sigma, SI, as it is declared, or as several recordings
/// show it. The covariance does not contain it; a comparison of calibrations does.
struct TurnOn {
  double accel = 0, gyro = 0;
  bool operator==(const TurnOn&) const = default;
};

/// White noise of the compensated output in the rests of the calibration's recordings: densities, SI. Zero: of an axis that shows none.
struct RestNoise {
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
  double interval_s = 0;  ///< of the samples
  int rests = 0;
  double seconds = 0;  ///< of all rests
  bool operator==(const RestNoise&) const = default;
};

/// What defines the body axes: x_b along the x accelerometer and y_b in the plane of the x and y accelerometers, or the axes of the rig.
enum class BodyFrame : std::uint8_t { accelerometers, rig };
std::string_view to_string(BodyFrame frame);

struct Calibration {
  std::string imu, serial, method, created, software;
  std::string operated_by, station, measured;  ///< who took the data, where, and when (UTC)
  std::string firmware, filter, warm_up, power_cycles, valid_until;
  std::vector<Reference> references = {};  ///< as the session declares them
  std::string session_file, session_sha256;
  std::vector<SourceFile> sources = {};
  std::map<std::string, std::string> options = {};  ///< of the calibration, as they were given
  BodyFrame frame = BodyFrame::accelerometers;
  std::optional<ClockScale> clock = {};  ///< absent: no gyros, or not known
  SensorModel model;
  std::optional<RecordedAs> recorded_accel, recorded_gyro;  ///< absent: not known, or the recordings differ
  std::vector<CoefficientIndex> estimated = {};             ///< table indices of the coefficients in `covariance`, in its order
  Eigen::MatrixXd covariance;                               ///< SI, estimated.size() squared
  Eigen::MatrixXd constant_covariance = {};                 ///< part of it that the same IMU brings again at its next calibration; empty: zero
  Quality quality;
  std::optional<TurnOn> turn_on = {};  ///< absent: not declared, or in the covariance
  /// Standard uncertainties of the offsets at the next switch-on, by the name of the coefficient, SI: empty where the recordings are of one alone.
  std::map<std::string, double> next_switch_on = {};
  std::optional<RestNoise> rest_noise = {};  ///< absent: not known, or the recordings have no rests
};

/// Throws Error that lists all that is wrong with a calibration made in memory, as with one read from a file: estimated coefficients that are not in
/// the table or listed twice; a covariance of another size, that is not finite or not symmetric, with a negative variance or a correlation beyond 1;
/// a model that is not finite, has units that there are not, or thermal terms without a reference. A calibration without covariance has no
/// estimated coefficients.
void validate(const Calibration& calibration);

/// The raw readings at which a triad's compensated output is zero, of the linear model: -A1^-1 A0, and their standard uncertainties (NaN where a
/// coefficient of the row was not estimated). For readings in counts this is what datasheets call the zero level.
struct RawZero {
  Vector3d value, uncertainty;
};
RawZero raw_zero(const Calibration& calibration, Triad triad);

/// The coefficients of offsets and matrices that the data did not determine: they keep starting values, which compensate nothing.
std::vector<std::string> unusable(const Calibration& calibration);

/// Standard uncertainty of a table coefficient; absent where it was not estimated or is fixed by the frame. Throws Error for an index outside the
/// table, and a covariance of another size than the estimated coefficients.
std::optional<double> standard_uncertainty(const Calibration& calibration, CoefficientIndex index);

struct UserValue {
  double value = 0;
  double uncertainty = 0;  ///< standard; NaN where it was not estimated
  std::string unit = {};   ///< the same for all coefficients of one term of a triad; empty where the readings are counts and the term has no name
};

/// A calibration's coefficient in user units. Scales: ppm from one, or counts per unit; misalignments: relative to their row's scale.
UserValue user_value(const Calibration& calibration, CoefficientIndex index);

/// The coefficient in `other`, for example the start of the fit, with the calibration's unit and uncertainty.
UserValue user_value(const Calibration& calibration, CoefficientIndex index, const SensorModel& other);

// The uncertainty of a coefficient as a certificate states it (GUM, JCGM 100): u, effective degrees of freedom, k, U.

/// SI. Type A is the uncertainty that the fit found from the data; type B is the declared uncertainty that is known separately: that of g, which
/// enters the accelerometers' scales. Declared errors of a rig and priors are part of the first: a calibration does not separate them.
struct ExpandedUncertainty {
  double standard = 0;            ///< u
  double from_fit = 0;            ///< type A
  double declared = 0;            ///< type B
  double degrees_of_freedom = 0;  ///< effective (Welch-Satterthwaite); infinite where the declared part dominates
  double coverage_factor = 0;     ///< k: 95.45 % of a t distribution
  double expanded = 0;            ///< U = k u
};

/// The uncertainty of an estimated coefficient. Throws Error for a coefficient without uncertainty.
ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index);

struct Requirement {
  std::string selector = {};
  std::vector<CoefficientIndex> coefficients = {};
  double limit = 0;  ///< SI, above 0
  UserUnit unit;     ///< in which it was stated
};

/// "gyro.matrix.off_diagonal <= 5 arcsec"
std::string to_string(const Requirement& requirement);

/// Requirements separated by commas. Throws Error for text of another form, an unknown coefficient, one that cannot be required (all but offset,
/// matrix and g_sensitivity), a number that is not above 0, and a unit that the coefficients cannot have.
std::vector<Requirement> parse_requirements(std::string_view text);

/// Compares the larger of u and U/2 of the worst coefficient with a limit, of matrices relative to the row's scale. One that was not estimated is
/// infinite, one fixed by the frame is left out; fewer than 3 effective degrees of freedom, or a doubtful calibration, meet none.
RequirementResult assess(const Calibration& calibration, const Requirement& requirement);

}  // namespace imulab
