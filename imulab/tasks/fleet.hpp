// Brings sessions into a fleet store and calibrates each of them once, for `fleet calibrate` and `fleet add` of the command.
#pragma once

#include "imulab/core/part_file.hpp"
#include "imulab/fleet.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// Values for everything that is added in one call; empty: as the session declares.
struct FleetDeclaration {
  std::string station;
  std::string operated_by;  ///< where the session or the calibration does not say
  std::string time;         ///< UTC, "2026-03-31T12:00:00Z"
};

struct FleetCalibrationTask {
  std::string method;
  std::string terms = "auto";
  FleetDeclaration declared = {};
  bool retry = false;  ///< sessions that failed before, too
  std::function<void(double done, double all)> progress = {};
  std::optional<PartNumber> part = {};  ///< of the sessions; its store is joined with those of the others by `fleet merge`
};

struct FleetCalibrationCounts {
  std::int64_t sessions = 0, calibrated = 0, skipped = 0, failed = 0, failed_before = 0;
  std::vector<FleetFailure> failures;  ///< of this run, in the sessions' order
};

/// The session.toml of this folder and of all below it, also behind symbolic links, each once, in the order of their names; a file is itself. Throws
/// Error where there is none.
std::vector<std::filesystem::path> sessions_below(const std::vector<std::filesystem::path>& places);

/// Calibrates every session whose content the store does not have with this method and these terms. Sessions are worked on in parallel, a few in
/// memory at a time; each is in the store when it is done, so that an interrupted run resumes. A session that fails is in the store with its
/// message. Throws Error where the store cannot be written.
FleetCalibrationCounts calibrate_fleet(const std::vector<std::filesystem::path>& sessions, const FleetCalibrationTask& task, FleetStore& store);

/// The session with the hashes of its files; reads them all.
FleetSession fleet_session(const Session& session);

/// When it was measured: the stamps of its first recording where they are of this century, else when the recording's file was written.
FleetOccasion occasion_of(const Session& session, const std::vector<Recording>& recordings, const FleetDeclaration& declared);

/// Adds a session (a folder or its session.toml), a calibration or noise.json; `unit`: of the noise. Returns its kind: "session", "calibration",
/// "noise", with " (known)" where the store had it. Throws Error where it is none of these.
std::string add_to_fleet(const std::filesystem::path& file, const std::string& unit, const FleetDeclaration& declared, FleetStore& store);

}  // namespace imulab
