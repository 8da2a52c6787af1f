// A session: what is known besides the readings. Recordings with their IMU, site, rig and steps; a procedure is a session without recordings.
//
// Example:
//   Session mine;
//   mine.site.latitude = 45 * unit::deg;
//   mine.site.height = 120;  // m
//   mine.imu.grade = "mems";
//   mine.steps.push_back({.kind = StepKind::hold, .start = 0, .end = 60});
//   validate(mine);          // throws Error that names every number out of range
//
// SI and radians, times in s of the recording's clock. Files are read into one by files.hpp (docs/reference/session.md has the keys and ranges, which
// `validate` checks here), procedure.hpp makes standard ones. Absent values are std::optional: what a method needs it asks for by an Error. A plain
// value.
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

/// The noise terms of a grade that a simulation has: white noise alone, or all.
enum class NoiseTerms { white, full };
std::string_view to_string(NoiseTerms terms);

/// One sigma of the terms that an IMU may have beyond offsets and matrices, SI: the priors of a calibration. Absent: by the grade, or the IMU's
/// offsets.
struct TermSigmas {
  std::optional<double> accel_quadratic, accel_cubic;  ///< 1/(m/s^2), 1/(m/s^2)^2
  std::optional<double> gyro_quadratic, gyro_cubic;    ///< 1/(rad/s), 1/(rad/s)^2
  std::optional<double> g_sensitivity = {};            ///< (rad/s)/(m/s^2)
  std::optional<double> lever_arm = {};                ///< m
  std::optional<double> delay = {};                    ///< s: of the accelerometers behind the gyros
  bool operator==(const TermSigmas&) const = default;
};

struct ImuDeclaration {
  std::string name = {};
  std::optional<std::string> serial = {};          ///< number of this one
  std::optional<std::string> firmware = {};        ///< its version
  std::optional<std::string> filter = {};          ///< how the IMU filters the readings before their output, in words: "low-pass, 42 Hz"
  std::optional<std::string> grade = {};           ///< sizes for priors, and for the draws of simulate
  std::string clock = "own";                       ///< the seconds in which the gyros' scales are to be stated: the recording's own, or "true"
  std::optional<std::string> truth = {};           ///< file of the exact IMU to simulate
  std::optional<double> accel_noise_density = {};  ///< m/s^2/sqrt(Hz)
  std::optional<double> gyro_noise_density = {};   ///< rad/s/sqrt(Hz)
  NoiseTerms noise = NoiseTerms::white;
  std::optional<std::string> noise_file = {};  ///< of an analysis, beside the session: it gives the densities and terms that are not declared
  TermSigmas term_sigmas;
  std::map<std::string, double, std::less<>> effect_sigmas = {};  ///< one sigma by the name of the effect (docs/theory/effects.md), SI
  std::optional<std::map<std::string, double, std::less<>>> simulated_effects = {};  ///< likewise, of those that a simulation draws
  std::optional<NoiseModel> accel_noise, gyro_noise;  ///< in place of the grade's; their N, unless it is 0, is the density
  bool operator==(const ImuDeclaration&) const = default;
};

struct Site {
  std::optional<double> latitude, longitude;       ///< rad
  std::optional<double> latitude_sigma = {};       ///< rad; absent: as the effect site.latitude has it
  std::optional<double> height = {};               ///< m
  std::optional<double> given_gravity = {};        ///< m/s^2
  std::optional<double> given_gravity_sigma = {};  ///< m/s^2

  /// Given, or WGS-84 normal gravity. Throws Error where there is neither a latitude nor a given value.
  double gravity() const;
  /// Given, or 1e-5 for a given gravity, 3e-4 from latitude and height, 3e-3 without height; these with what the latitude's sigma makes of it.
  double gravity_sigma() const;
  bool operator==(const Site&) const = default;
};

enum class RigKind { none, turntable, rate_table, centrifuge, chamber };
std::string_view to_string(RigKind kind);

/// The axes of a turntable, in the order of the tables below.
enum class RigAxis { outer, middle, inner };
std::string_view to_string(RigAxis axis);

/// Declared accuracy of a rig, SI.
struct RigDeclaration {
  std::string name = {};  ///< recordings refer to it where there are several
  RigKind kind = RigKind::none;
  Spread angle, orthogonality, zero;  ///< rad
  Spread timing;                      ///< s
  Spread mount;   ///< rad: each of the three small rotations of a mounting (rate table, centrifuge, chamber), drawn for each mount
  Spread rate;    ///< relative: the scale of the rate (rate table, centrifuge)
  Spread radius;  ///< m: of a mount's radii, common to the three sensors (rate table, centrifuge)
  double ramp = 0, time_constant = 0;  ///< chamber: K/s toward a set point, and time constant [s] of the IMU; 0: at once
  double hysteresis = 0;               ///< chamber: K by which the IMU's zeros lag behind its thermal readings, against the direction of change
  std::array<std::optional<std::array<double, 2>>, 3> given_orthogonality;  ///< rad, by RigAxis: exactly known instead of drawn
  std::array<std::optional<double>, 3> given_zero;                          ///< rad, by RigAxis
  bool operator==(const RigDeclaration&) const = default;
};

enum class Output { rate, increment };

/// A column by its header name or its 1-based number; of readings also a sum of columns by name, "gravity.x + userAcceleration.x".
using Column = std::variant<std::string, int>;
inline constexpr std::string_view sum_sign = " + ";

/// Which stamps a calibration uses: the file's, an even clock's, or the latter if the file's scatter.
enum class Stamps { automatic, recorded, uniform };
std::string_view to_string(Stamps stamps);

/// Where the stamps of rows come from. A stamp is column + fraction_column, or the row's number times the interval.
struct TimeSource {
  std::optional<Column> column = Column(1);  ///< absent: the rows follow each other at the declared rate
  std::string unit = "s";                    ///< s, ms, us, ns; tick (ticks_per_s); sample: a number of samples at the declared rate
  std::optional<Column> fraction_column{};   ///< added to the first, as nanoseconds to seconds
  std::string fraction_unit = "ns";
  std::optional<double> ticks_per_s{};
  std::optional<int> wrap_bits{};  ///< the column's number wraps to 0 after 2^wrap_bits of its unit
  std::int64_t zero = 0;           ///< subtracted: ns, or ticks or samples
  Stamps stamps = Stamps::automatic;
  TimeScale scale = TimeScale::own;  ///< gps or utc: seconds since 1970, since 1980 (the epoch of GPS), or of the week
  bool operator==(const TimeSource&) const = default;
};

/// How a file prints the bits of whole readings: as their numbers, or so that those of the other sign are 2^16, 2^24 or 2^32 away, as where -132 is
/// printed as 65404. The name is the kind of integer that they are.
enum class Integers { as_written, int16, uint16, int24, uint24, int32, uint32 };
std::string_view to_string(Integers integers);

struct TriadSource {
  std::optional<std::string> file{}, topic{};  ///< if they differ from the recording's
  std::optional<TimeSource> time{};
  std::vector<Column> columns{};                  ///< three
  std::optional<std::array<BodyAxis, 3>> axes{};  ///< along which body axis each column measures; absent: x, y, z
  Output output = Output::rate;
  std::string unit = "count";
  Integers integers = Integers::as_written;
  std::optional<double> counts_per_unit{};        ///< the file has counts: this number is one `unit`
  std::optional<std::array<double, 2>> limits{};  ///< in the file's unit
  bool operator==(const TriadSource&) const = default;
};

struct ThermalSource {
  std::optional<std::string> file{}, topic{};  ///< if they differ from the recording's
  std::optional<TimeSource> time{};
  std::vector<Column> columns = {};  ///< one or three
  std::string unit = "degC";
  // In a simulation a reading is at_25_degC + per_K (T - 25 degC) and noise; three columns, three sensors.
  double noise = 0;                         ///< one sigma of a reading, in its unit
  std::optional<double> at_25_degC, per_K;  ///< absent: the temperature itself
  bool operator==(const ThermalSource&) const = default;
};

/// The samples that a simulation writes: all from the first to the last step, or those inside the steps (the operator records point by point).
enum class Extent { all, steps };
std::string_view to_string(Extent extent);

struct RecordingSource {
  std::string file = {};
  std::string topic = {};   ///< the table of a file that has several: a bag's topic, a log's message; empty: the only one
  std::string layout = {};  ///< of rows of binary numbers: "f8 f4x6"; empty: the file describes itself
  std::string rig = {};     ///< empty with one rig
  std::optional<double> rate_hz = {};
  Extent extent = Extent::all;
  TimeSource time;
  TriadSource gyro, accel;
  std::optional<ThermalSource> gyro_temperature, accel_temperature;

  /// The files that its columns are in, each once.
  std::set<std::string> files() const;
  bool operator==(const RecordingSource&) const = default;
};

struct Mount {
  BodyAxis up{2, 1}, outward{0, 1};
  bool operator==(const Mount&) const = default;
};

enum class StepKind { hold, rotate, spin };
std::string_view to_string(StepKind kind);

/// One action of the rig, in time order. Omitted angles have been filled in from the previous step (first 0, anew in each recording).
struct Step {
  StepKind kind = StepKind::hold;
  std::string recording = {};               ///< file of the recording it belongs to
  double start = 0, end = 0;                ///< s of the recording's clock; also for a procedure
  std::array<double, 3> angles{0, 0, 0};    ///< rad, by RigAxis: of a hold; where a rotate or spin begins
  RigAxis axis = RigAxis::outer;            ///< rotate
  double angle = 0;                         ///< rotate: rad, signed
  double rate = 0;                          ///< rotate (> 0) and spin (signed): rad/s
  std::optional<double> acceleration = {};  ///< rad/s^2
  std::optional<Mount> mount = {};
  std::array<double, 3> radius{0, 0, 0};   ///< spin: m, by sensor axis
  std::optional<double> temperature = {};  ///< set point, degC
  bool operator==(const Step&) const = default;
};

/// "step 3 (hold at 120 s)": the step with this index, from 0.
std::string step_name(const Step& step, std::size_t index);

struct InitialState {
  double time = 0, latitude = 0, longitude = 0, height = 0;  ///< s, rad, rad, m
  std::array<double, 3> velocity_enu{0, 0, 0};               ///< m/s
  double roll = 0, pitch = 0, heading = 0;                   ///< rad
  bool operator==(const InitialState&) const = default;
};

/// Treatment of the height, whose pure inertial error grows by a factor e every 570 s: state the vertical channel with every result.
enum class VerticalChannel {
  free,   ///< integrated like the others
  fixed,  ///< height as at the start, no vertical velocity
  aided,  ///< corrected towards a barometer's height by a loop of third order
  held,   ///< the height is the barometer's, the vertical velocity is integrated freely
};
std::string_view to_string(VerticalChannel vertical);
/// Of such a name; throws Error for another.
VerticalChannel vertical_channel(std::string_view name);

struct Session {
  std::string file = {};                        ///< the TOML file
  std::string sha256;                           ///< of its text
  std::optional<std::string> noise_taken = {};  ///< the file of an analysis that the IMU's noise is from
  std::optional<std::string> operated_by = {};  ///< who took the data
  std::optional<std::string> station = {};      ///< where
  std::optional<std::string> measured = {};     ///< when: UTC, "2026-03-31" or "2026-03-31T12:00:00Z"
  std::optional<std::string> valid_until = {};  ///< the day until which the owner uses the calibration
  std::optional<std::string> warm_up = {};      ///< before the recording, in words
  std::optional<std::string> power_cycles = {};
  std::vector<Reference> references = {};  ///< at most one of each quantity
  ImuDeclaration imu;
  Site site;
  std::vector<RigDeclaration> rigs = {};
  std::vector<RecordingSource> recordings = {};
  std::vector<Step> steps = {};
  std::optional<InitialState> initial = {};
  std::optional<std::string> truth_file = {};    ///< reference solution for navigation
  std::optional<VerticalChannel> vertical = {};  ///< of a navigation
  std::optional<std::string> barometer_file = {};
  std::vector<Aid> aids = {};  ///< of a drive or flight

  /// The declaration of the recording with this file name; if the session has none, one with the name alone.
  RecordingSource source_of(std::string_view name) const;
  /// The rig of a recording: the one it names, or the first where it names none; null where there is none.
  const RigDeclaration* rig_of(const RecordingSource& source) const;
  /// The steps of a recording: those that name its file, or all where the session has at most one recording.
  std::vector<Step> steps_of(const RecordingSource& source) const;

  bool operator==(const Session&) const = default;
};

/// The noise of each triad as an IMU declares it: its own terms (`accel_noise`, `accel_noise_density`), else the grade's where `imu.noise` is
/// NoiseTerms::full, else none (0).
NoiseModels declared_terms(const ImuDeclaration& imu);

/// As declared_terms, with the grade's white noise N where no density is declared. Throws Error where there is neither a density nor a grade.
NoiseModels declared_noise(const ImuDeclaration& imu);

/// Throws Error that lists every number of a session outside the range that a session file allows (latitude in -90 to 90 deg, a gravity in m/s^2,
/// noise of at least 0, ...), every text that such a file refuses (dates, units, names of effects, rigs and recordings), and every step that ends
/// before it begins, begins before the end of the one before it, or turns nowhere.
void validate(const Session& session);

}  // namespace imulab
