// A session: all information besides the readings: recordings, IMU, site, rig and steps. A procedure is a session without recordings.
//
// Example:
//   Session mine;
//   mine.site.latitude = 45 * unit::deg;
//   mine.site.height = 120;  // m
//   mine.imu.grade = "mems";
//   mine.steps.push_back({.kind = StepKind::hold, .start = 0, .end = 60});
//   validate(mine);          // throws Error that names every number out of range
//
// Values are SI and radians, times are s on the recording's clock. files.hpp reads sessions from files (docs/reference/session.md lists keys and
// ranges, which `validate` checks here); procedure.hpp makes standard ones. Absent values are std::optional: a method throws Error if it needs an
// absent one. Types are plain values.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/calibration.hpp"
#include "imulab/grade.hpp"
#include "imulab/recording.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace imulab {

/// Noise terms of a grade in a simulation: white noise only, or all.
enum class NoiseTerms { white, full };
std::string_view to_string(NoiseTerms terms);  ///< these functions return the name in a session file

/// One sigma of optional terms beyond offsets and matrices, SI: priors of a calibration. Absent: from the grade or the IMU's offsets.
struct TermSigmas {
  std::optional<double> accel_quadratic, accel_cubic;  ///< 1/(m/s^2), 1/(m/s^2)^2
  std::optional<double> gyro_quadratic, gyro_cubic;    ///< 1/(rad/s), 1/(rad/s)^2
  std::optional<double> g_sensitivity = {};            ///< (rad/s)/(m/s^2)
  std::optional<double> lever_arm = {};                ///< m
  std::optional<double> delay = {};                    ///< delay [s] of the accelerometers relative to the gyros
  bool operator==(const TermSigmas&) const = default;
};

struct ImuDeclaration {
  std::string name = {};
  std::optional<std::string> serial = {};          ///< serial number of the unit
  std::optional<std::string> firmware = {};        ///< version of the firmware
  std::optional<std::string> filter = {};          ///< description of the filter between sensors and output: "low-pass, 42 Hz"
  std::optional<std::string> grade = {};           ///< source of the sizes for priors, and for draws of simulations
  std::string clock = "own";                       ///< time unit for the gyro scales: seconds of the recording's "own" clock, or "true" seconds
  std::optional<std::string> truth = {};           ///< file of the exact IMU for a simulation
  std::optional<double> accel_noise_density = {};  ///< m/s^2/sqrt(Hz)
  std::optional<double> gyro_noise_density = {};   ///< rad/s/sqrt(Hz)
  NoiseTerms noise = NoiseTerms::white;
  std::optional<std::string> noise_file = {};  ///< noise analysis beside the session; it provides densities and terms that are not declared
  TermSigmas term_sigmas;
  std::map<std::string, double, std::less<>> effect_sigmas = {};                     ///< one sigma by effect name (docs/theory/effects.md), SI
  std::optional<std::map<std::string, double, std::less<>>> simulated_effects = {};  ///< likewise, for effects drawn by a simulation
  std::optional<NoiseModel> accel_noise, gyro_noise;                                 ///< replace the grade's noise; N is the density unless it is 0
  bool operator==(const ImuDeclaration&) const = default;
};

struct Site {
  std::optional<double> latitude, longitude;       ///< rad
  std::optional<double> latitude_sigma = {};       ///< rad; absent: size of the effect site.latitude
  std::optional<double> height = {};               ///< m
  std::optional<double> given_gravity = {};        ///< m/s^2
  std::optional<double> given_gravity_sigma = {};  ///< m/s^2

  /// Returns the given gravity or WGS-84 normal gravity [m/s^2]. Throws Error if neither a latitude nor a gravity is given.
  double gravity() const;
  /// Returns its sigma [m/s^2]: given, or 1e-5 for a given gravity, else 3e-4 (3e-3 without height) combined with the effect of latitude_sigma.
  double gravity_sigma() const;
  bool operator==(const Site&) const = default;
};

enum class RigKind { none, turntable, rate_table, centrifuge, chamber };
std::string_view to_string(RigKind kind);

/// Axes of a turntable, in the order of the arrays by RigAxis.
enum class RigAxis { outer, middle, inner };
std::string_view to_string(RigAxis axis);

/// Declared accuracy of a rig, SI.
struct RigDeclaration {
  std::string name = {};  ///< name to which recordings refer if there are several rigs
  RigKind kind = RigKind::none;
  Spread angle, orthogonality, zero;   ///< rad
  Spread timing;                       ///< s
  Spread mount;                        ///< rad: each of three small mounting rotations, drawn for each mount (rate table, centrifuge, chamber)
  Spread rate;                         ///< relative scale error of the rate (rate table, centrifuge)
  Spread radius;                       ///< m: error of a mount's radii, common to the three sensors (rate table, centrifuge)
  double ramp = 0, time_constant = 0;  ///< chamber: K/s toward a set point; thermal time constant of the IMU [s], 0: none
  double hysteresis = 0;               ///< chamber: lag [K] of the IMU's zeros behind its thermal readings, opposite to the direction of change
  std::array<std::optional<std::array<double, 2>>, 3> given_orthogonality;  ///< rad, by RigAxis: exactly known values instead of draws
  std::array<std::optional<double>, 3> given_zero;                          ///< rad, by RigAxis
  bool operator==(const RigDeclaration&) const = default;
};

enum class Output { rate, increment };

/// A column by header name or 1-based number; for readings also a sum of named columns, "gravity.x + userAcceleration.x".
using Column = std::variant<std::string, int>;
inline constexpr std::string_view sum_sign = " + ";

/// Stamps that a calibration uses: recorded, uniform (an even clock), or automatic (uniform if the recorded ones scatter).
enum class Stamps { automatic, recorded, uniform };
std::string_view to_string(Stamps stamps);

/// Source of the row stamps. A stamp is column + fraction_column, or the row number times the interval.
struct TimeSource {
  std::optional<Column> column = Column(1);  ///< absent: consecutive rows at the declared rate
  std::string unit = "s";                    ///< s, ms, us, ns; tick (ticks_per_s); sample: number of samples at the declared rate
  std::optional<Column> fraction_column{};   ///< column to be added, such as nanoseconds to seconds
  std::string fraction_unit = "ns";
  std::optional<double> ticks_per_s{};
  std::optional<int> wrap_bits{};  ///< the number in the column wraps to 0 after 2^wrap_bits units
  std::int64_t zero = 0;           ///< value to be subtracted: ns, or ticks or samples
  Stamps stamps = Stamps::automatic;
  TimeScale scale = TimeScale::own;  ///< gps or utc: seconds since 1970, since 1980 (GPS epoch), or of the week
  /// What was subtracted from a column of seconds; ticks and samples count from nowhere.
  std::int64_t zero_ns() const { return unit == "tick" || unit == "sample" ? 0 : zero; }
  bool operator==(const TimeSource&) const = default;
};

/// Representation of integer readings in a file: as_written, or the integer type of the bits if the file prints values of the other sign shifted by
/// 2^16, 2^24 or 2^32 (for example -132 as 65404).
enum class Integers { as_written, int16, uint16, int24, uint24, int32, uint32 };
std::string_view to_string(Integers integers);

struct TriadSource {
  std::optional<std::string> file{}, topic{};  ///< if they differ from the recording's
  std::optional<TimeSource> time{};
  std::vector<Column> columns{};                  ///< three columns
  std::optional<std::array<BodyAxis, 3>> axes{};  ///< body axis along which each column measures; absent: x, y, z
  Output output = Output::rate;
  std::string unit = "count";
  Integers integers = Integers::as_written;
  std::optional<double> counts_per_unit{};        ///< number of counts in one `unit`, if the file has counts
  std::optional<std::array<double, 2>> limits{};  ///< in the unit of the file
  bool operator==(const TriadSource&) const = default;
};

struct ThermalSource {
  std::optional<std::string> file{}, topic{};  ///< if they differ from the recording's
  std::optional<TimeSource> time{};
  std::vector<Column> columns = {};  ///< one column or three
  std::string unit = "degC";
  // A simulated reading is at_25_degC + per_K (T - 25 degC) plus noise. Three columns represent three sensors.
  double noise = 0;                         ///< one sigma of a reading, in its unit
  std::optional<double> at_25_degC, per_K;  ///< absent: the reading is the temperature
  bool operator==(const ThermalSource&) const = default;
};

/// Samples that a simulation writes: all from the first to the last step, or only those inside steps (recorded point by point).
enum class Extent { all, steps };
std::string_view to_string(Extent extent);

struct RecordingSource {
  std::string file = {};
  std::string topic = {};   ///< table in a file with several: topic of a bag, message of a log; empty: the only one
  std::string layout = {};  ///< layout of binary rows: "f8 f4x6"; empty: the file describes itself
  std::string imu = {};     ///< name of the IMU; empty with one IMU
  std::string rig = {};     ///< name of the rig; empty with one rig
  std::optional<double> rate_hz = {};
  Extent extent = Extent::all;
  TimeSource time;
  TriadSource gyro, accel;
  std::optional<ThermalSource> gyro_temperature, accel_temperature;

  /// Returns the files that contain its columns, each once.
  std::set<std::string> files() const;
  bool operator==(const RecordingSource&) const = default;
};

struct Mount {
  BodyAxis up{2, 1}, outward{0, 1};
  bool operator==(const Mount&) const = default;
};

enum class StepKind { hold, rotate, spin };
std::string_view to_string(StepKind kind);

/// An action of the rig, in time order. Omitted angles were copied from the previous step (initially 0 in each recording).
struct Step {
  StepKind kind = StepKind::hold;
  std::string recording = {};               ///< file of the recording that contains the step
  double start = 0, end = 0;                ///< s on the clock of the recording or procedure
  std::array<double, 3> angles{0, 0, 0};    ///< rad, by RigAxis: angles of a hold, or start of a rotate or spin
  RigAxis axis = RigAxis::outer;            ///< rotate
  double angle = 0;                         ///< rotate: rad, signed
  double rate = 0;                          ///< rotate (> 0) and spin (signed): rad/s
  std::optional<double> acceleration = {};  ///< rad/s^2
  std::optional<Mount> mount = {};
  std::array<double, 3> radius{0, 0, 0};   ///< spin: radius [m] by sensor axis
  std::optional<double> temperature = {};  ///< set point, degC
  bool operator==(const Step&) const = default;
};

/// Returns "step 3 (hold at 120 s)" for the step with `index` 2 (counted from 0).
std::string step_name(const Step& step, std::size_t index);

struct InitialState {
  double time = 0, latitude = 0, longitude = 0, height = 0;  ///< s, rad, rad, m
  std::array<double, 3> velocity_enu{0, 0, 0};               ///< m/s
  double roll = 0, pitch = 0, heading = 0;                   ///< rad
  bool operator==(const InitialState&) const = default;
};

/// The vertical channel: pure inertial height errors grow by a factor e every 570 s. State the vertical channel with every result.
enum class VerticalChannel {
  free,   ///< integrated like the horizontal channels
  fixed,  ///< height of the start, no vertical velocity
  aided,  ///< corrected by a barometer's height in a third-order loop
  held,   ///< height from the barometer; the vertical velocity is integrated freely
};
std::string_view to_string(VerticalChannel vertical);
/// Returns the channel with this name; throws Error if it is unknown.
VerticalChannel vertical_channel(std::string_view name);

struct Session {
  std::string file = {};                        ///< the TOML file
  std::string sha256;                           ///< hash of its text
  std::optional<std::string> noise_taken = {};  ///< noise analysis from which the IMU's noise was taken
  std::optional<std::string> operated_by = {};  ///< person who measured
  std::optional<std::string> station = {};      ///< place
  std::optional<std::string> measured = {};     ///< UTC, "2026-03-31" or "2026-03-31T12:00:00Z"
  std::optional<std::string> valid_until = {};  ///< recalibration due date
  std::optional<std::string> warm_up = {};      ///< description of the warm-up before the recording
  std::optional<std::string> power_cycles = {};
  std::vector<Reference> references = {};  ///< at most one for each quantity
  ImuDeclaration imu;
  Site site;
  std::vector<RigDeclaration> rigs = {};
  std::vector<RecordingSource> recordings = {};
  std::vector<Step> steps = {};
  std::optional<InitialState> initial = {};
  std::optional<std::string> truth_file = {};    ///< reference solution for navigation
  std::optional<VerticalChannel> vertical = {};  ///< vertical channel of a navigation
  std::optional<std::string> barometer_file = {};
  std::vector<Aid> aids = {};  ///< aids of a drive or flight

  /// Returns the declaration of the recording with this file name; if the session has none, a declaration with the name only.
  RecordingSource source_of(std::string_view name) const;
  /// Returns the rig that a recording names, or the first rig if it names none; null if there is none.
  const RigDeclaration* rig_of(const RecordingSource& source) const;
  /// Returns the steps that name the recording's file, or all steps if the session has at most one recording.
  std::vector<Step> steps_of(const RecordingSource& source) const;

  bool operator==(const Session&) const = default;
};

/// Returns the declared noise of each triad: its own terms (`accel_noise`, `accel_noise_density`), else the grade's if `imu.noise` is
/// NoiseTerms::full, else 0.
NoiseModels declared_terms(const ImuDeclaration& imu);

/// Like declared_terms, with the grade's white noise N if no density is declared. Throws Error if neither density nor grade is declared.
NoiseModels declared_noise(const ImuDeclaration& imu);

/// Throws an Error that lists every number outside the range of session files (latitude in -90 to 90 deg, gravity in m/s^2, nonnegative noise, ...),
/// every invalid text (dates, units, names of effects, rigs and recordings), and every step that ends before it begins, overlaps the previous step,
/// or is a rotation without an angle.
void validate(const Session& session);

}  // namespace imulab
