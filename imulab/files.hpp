// Files: sessions (TOML), recordings (any format of docs/reference/recordings.md), calibrations and noise (JSON), navigation solutions (CSV).
//
// Example:
//   const Session mine = read_session("session");  // a folder with session.toml, or the file
//   const RecordingReading reading = read_recording(mine, mine.recordings.front());
//   for (const std::string& warning : reading.warnings) std::puts(warning.c_str());
//   const Calibration known = read_calibration("calibration.json");
//   write_calibration("copy.json", known);
//
// Everything is checked on reading and becomes SI. Throws Error with file, line and key or column, what was found and what was expected. What is
// written appears whole or not at all, and reads back to the same numbers. "-" is standard input. Different files may be read and written by several
// threads.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/calibration.hpp"
#include "imulab/compensate.hpp"
#include "imulab/navigate.hpp"
#include "imulab/noise.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Reads a session or a procedure: a folder with session.toml, or the file. Units become SI, absent angles are filled in, a procedure's steps are
/// laid out in time. Throws Error with file, line and key: for unknown keys and units, values out of range, and steps that overlap.
Session read_session(const std::filesystem::path& path);
/// Reads a session from text; `file` is its name in messages, and files that it names are beside it.
Session parse_session(std::string_view text, const std::string& file);

/// The session as TOML text that read_session reads back to the same values.
std::string session_text(const Session& session);
/// Writes that text, whole or not at all. Throws Error where the file cannot be written.
void write_session(const std::filesystem::path& path, const Session& session);

/// The session as text with durations in place of times where read_session computes the same times: the form that a procedure's author edits.
std::string procedure_text(const Session& session);

/// Densities and terms of an analysis (noise.json) where the IMU declares none. Throws Error as read_noise and noise_sizes do.
void take_noise(ImuDeclaration& imu, const std::string& file);

struct RecordingReading {
  Recording recording;
  std::vector<std::string> warnings;  ///< gaps, saturated samples, dropped rows: the findings and their consequences
};

/// Reads one recording of a session, in any of the formats; files are found beside the session's own. Throws Error with file, line and column for
/// text in a number, NaN, infinity, ragged rows, time that runs backwards, missing columns, an empty file, and a declared rate that the stamps
/// contradict.
RecordingReading read_recording(const Session& session, const RecordingSource& source);

/// Writes t,gx,gy,gz,ax,ay,az as CSV, and temperatures where there are any: seconds, SI or counts, increments as increments. The file appears whole
/// or not at all. Numbers read back exactly, except that an increment that is not a whole number may differ by one unit in the last place. Throws
/// Error where the file cannot be written.
void write_recording(const std::filesystem::path& path, const Recording& recording);

/// A compensated recording as CSV: t,gx,gy,gz,ax,ay,az in s, rad/s, m/s^2; where some sample has a flag, a column of them. Whole or not at all.
void write_compensated_rows(const std::filesystem::path& path, const CompensatedRecording& compensated);

/// Copies the bag of a recording with angular_velocity [rad/s] and linear_acceleration [m/s^2] of its topic replaced. All else stays byte for byte:
/// other topics, headers, covariances, orientations, times, order. The file appears whole or not at all; only a chunk of the bag is in memory. Throws
/// Error where the recording is no bag of the kind that the name says, where gyros and accelerometers are not of one topic of sensor_msgs/Imu, where
/// a message has no compensated sample, and where the bag was not closed.
void write_compensated_bag(const std::filesystem::path& path, const Session& session, const RecordingSource& source,
                           const CompensatedRecording& compensated);

/// Writes an .npz archive: `time_ns` [n] int64; `gyro` and `accel` [n, 3] in rad/s and m/s^2 (increments: rad and m/s); where some sample has a flag,
/// `saturated`, `out_of_range` and `replaced` [n] bool. The file appears whole or not at all. Throws Error where it cannot be written, and for more
/// than 4 GB, which an archive of this kind cannot hold.
void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& compensated);

/// Reads calibration.json or truth.json; "-" is standard input. Throws Error naming file, field and what was expected; a newer format is refused by
/// its name. Top-level keys beyond the format (a truth's rig errors) are left alone.
Calibration read_calibration(const std::filesystem::path& path);

/// Reads the text of such a file; `file` is its name in messages.
Calibration parse_calibration(std::string_view text, const std::string& file);

/// The calibration as JSON text that reads back to the same numbers. Throws Error where a coefficient is not finite.
std::string calibration_text(const Calibration& calibration);
/// Writes that text, whole or not at all. Throws Error as `validate` of a calibration, and where the file cannot be written.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

/// SI, or counts; null for what is not determined. Of several logs: mean, spread, and the worst; then each log's own.
std::string noise_json(const NoiseAnalysis& analysis);
std::string noise_json(const NoiseBatch& batch);

/// Throws Error that names file and field where it is no "imulab.noise/1".
ImuNoise read_noise(const std::string& path);
/// From text; `file` is its name in messages.
ImuNoise parse_noise(std::string_view text, const std::string& file);

/// A solution has the columns t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg: s, m above the ellipsoid, m/s east,
/// north and up, Euler angles of the body axes. Reads them in any order. Throws Error with file, line and column as read_recording does, and for a
/// latitude beyond 90 deg.
Solution read_solution(const std::filesystem::path& path);
/// Writes such a file, whole or not at all; the heading from 0 to 360 deg. Throws Error where it cannot be written.
void write_solution(const std::filesystem::path& path, const Solution& solution);

/// Reads the columns t,height_m (s, m), as a barometer gives them. Throws Error with file, line and column.
HeightRecord read_heights(const std::filesystem::path& path);

struct AidsReading {
  std::vector<Aid> aids;              ///< that go with the recording, their records on its clock
  std::vector<std::string> warnings;  ///< what was left out; a clock whose offset has to be estimated
};

/// Reads the files of a session's aids, in any of the formats of docs/reference/recordings.md, "Aids". Their stamps are then those of the recording's
/// clock: exactly (TimeScale::recording), or but for an offset that remains to be estimated (TimeScale::own). An aid that has a record keeps it.
/// Throws Error with file and place for what is damaged or out of range, latitude and longitude swapped, stamps that run back, and an aid of another
/// time.
AidsReading read_aids(const Session& session, const RecordingSource& source, const Recording& recording);

/// GPS time, as that of a date since 1970, less the stamps of the recording [ns], at the begin of an aid; absent where no aid tells it: the recording
/// has its own clock, or the aid has. Reads and throws as read_aids does.
std::optional<std::int64_t> gps_time_ahead(const Session& session, const RecordingSource& source, const Recording& recording);

/// Writes `text` to `path`, whole or not at all.
void write_whole(const std::filesystem::path& path, std::string_view text);

}  // namespace imulab
