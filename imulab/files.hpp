// Reads and writes files: sessions (TOML), recordings (all formats of docs/reference/recordings.md), calibrations and noise (JSON), solutions (CSV).
//
// Example:
//   const Session mine = read_session("session");  // a folder with session.toml, or the file
//   const RecordingReading reading = read_recording(mine, mine.recordings.front());
//   for (const std::string& warning : reading.warnings) std::puts(warning.c_str());
//   const Calibration known = read_calibration("calibration.json");
//   write_calibration("copy.json", known);
//
// Every value is checked on reading and converted to SI units. Functions throw Error with file, line and key or column, what was found and what was
// expected. A file is written completely or not at all, and reads back to the same numbers. "-" is standard input. Different threads may use
// different files.
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

/// Reads a session or a procedure; `path` is the TOML file, or a folder with session.toml. Units become SI, absent angles are filled in, and a
/// procedure's steps get times. Throws Error with file, line and key for unknown keys and units, values out of range, and steps that overlap.
Session read_session(const std::filesystem::path& path);
/// Reads a session from text; `file` is its name in messages, and relative file names refer to its folder.
Session parse_session(std::string_view text, const std::string& file);

/// Returns the session as TOML text that read_session reads back to the same values.
std::string session_text(const Session& session);
/// Writes that text to `path`, completely or not at all. Throws Error if the file cannot be written.
void write_session(const std::filesystem::path& path, const Session& session);

/// Returns the session as text for editing: with durations instead of times if read_session computes the same times from them.
std::string procedure_text(const Session& session);

/// Adds the densities and terms of the noise analysis `file` (noise.json) that `imu` does not declare. Throws Error as read_noise and noise_sizes do.
void take_noise(ImuDeclaration& imu, const std::string& file);

struct RecordingReading {
  Recording recording;
  std::vector<std::string> warnings;  ///< gaps, saturated samples, dropped rows, and their consequences
};

/// Reads the recording `source` of a session, in any format; relative file names refer to the session's folder. Throws Error with file, line and
/// column for text in a number, NaN, infinity, ragged rows, decreasing time, missing columns, an empty file, and a contradictory declared rate.
RecordingReading read_recording(const Session& session, const RecordingSource& source);

/// Writes t,gx,gy,gz,ax,ay,az and any temperatures as CSV in seconds and SI units or counts; increments remain increments. The file is written
/// completely or not at all. Numbers read back exactly, but an increment that is not a whole number may differ in the last place. Throws Error if the
/// file cannot be written.
void write_recording(const std::filesystem::path& path, const Recording& recording);

/// Writes a compensated recording as CSV, completely or not at all: t,gx,gy,gz,ax,ay,az in s, rad/s, m/s^2; a column of flags if a sample has any.
void write_compensated_rows(const std::filesystem::path& path, const CompensatedRecording& compensated);

/// Copies the bag of the recording `source` to `path` and replaces angular_velocity [rad/s] and linear_acceleration [m/s^2] of its topic by
/// `compensated`. All other bytes stay the same: other topics, headers, covariances, orientations, times, order. The file is written completely or
/// not at all; only one chunk is in memory. Throws Error if the recording is not a bag of the kind that its name implies, if gyros and accelerometers
/// are not in one topic of sensor_msgs/Imu, if a message has no compensated sample, or if the bag was not closed.
void write_compensated_bag(const std::filesystem::path& path, const Session& session, const RecordingSource& source,
                           const CompensatedRecording& compensated);

/// Writes an .npz archive: `time_ns` [n] int64; `gyro` and `accel` [n, 3] in rad/s and m/s^2 (increments: rad and m/s); if a sample has a flag,
/// `saturated`, `out_of_range` and `replaced` [n] bool. It is written completely or not at all. Throws Error if it cannot be written, or exceeds 4
/// GB, the limit of this kind of archive.
void write_compensated_npz(const std::filesystem::path& path, const CompensatedRecording& compensated);

/// Reads calibration.json or truth.json; "-" is standard input. Throws Error with file, field and what was expected, also for a newer format. Unknown
/// top-level keys (such as a truth's rig errors) are ignored.
Calibration read_calibration(const std::filesystem::path& path);

/// Parses the text of such a file; `file` is its name in messages.
Calibration parse_calibration(std::string_view text, const std::string& file);

/// Returns the calibration as JSON text that reads back to the same numbers. Throws Error if a coefficient is not finite.
std::string calibration_text(const Calibration& calibration);
/// Writes that text, completely or not at all. Throws Error if `validate` refuses the calibration or the file cannot be written.
void write_calibration(const std::filesystem::path& path, const Calibration& calibration);

/// Returns an analysis as JSON text, in SI units or counts; null means not determined. A batch has mean, spread and worst value, then each log.
std::string noise_json(const NoiseAnalysis& analysis);
std::string noise_json(const NoiseBatch& batch);

/// Reads the noise of an IMU. Throws Error with file and field if the file is not in the format "imulab.noise/1".
ImuNoise read_noise(const std::string& path);
/// Parses the text of such a file; `file` is its name in messages.
ImuNoise parse_noise(std::string_view text, const std::string& file);

/// Reads a solution with the columns t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg, in any order: s, height above the
/// ellipsoid, velocity [m/s] east, north and up, Euler angles of the body axes. Throws Error with file, line and column as read_recording does, and
/// for a latitude beyond 90 deg.
Solution read_solution(const std::filesystem::path& path);
/// Writes such a file, completely or not at all, with headings from 0 to 360 deg. Throws Error if it cannot be written.
void write_solution(const std::filesystem::path& path, const Solution& solution);

/// Reads the columns t,height_m (s, m), for example from a barometer. Throws Error with file, line and column.
HeightRecord read_heights(const std::filesystem::path& path);

struct AidsReading {
  std::vector<Aid> aids;              ///< aids of the recording, with records on its clock
  std::vector<std::string> warnings;  ///< data that were left out; clocks with an offset to be estimated
};

/// Reads the files of a session's aids for its recording `source`, whose samples are `recording`, in any format of docs/reference/recordings.md,
/// "Aids". Their stamps are converted to the recording's clock, exactly (TimeScale::recording) or except for an offset that must be estimated
/// (TimeScale::own). An aid that already has a record keeps it. Throws Error with file and place for data that are damaged or out of range, swapped
/// latitude and longitude, decreasing stamps, and an aid of another time.
AidsReading read_aids(const Session& session, const RecordingSource& source, const Recording& recording);

/// Returns GPS time (counted from 1970) minus the stamps of `recording` [ns] at the start of an aid. It is absent if no aid determines it because the
/// recording or the aid has an independent clock. Parameters and errors as for read_aids.
std::optional<std::int64_t> gps_time_ahead(const Session& session, const RecordingSource& source, const Recording& recording);

/// Writes `text` to `path`, completely or not at all.
void write_whole(const std::filesystem::path& path, std::string_view text);

}  // namespace imulab
