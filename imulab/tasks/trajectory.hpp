// Flies a mission: the truth, and the readings of an IMU on it.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"
#include "imulab/tasks/aid_files.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace imulab {

struct TrajectoryOptions : ShowOptions {
  std::string mission;
  std::optional<std::string> unit;
  bool errors = false;
  std::uint64_t seed = 1;
};
/// The verb `trajectory`, which sets these.
Verb& declare(Verb& command, TrajectoryOptions& o);

struct TrajectoryTask {
  std::string mission;                        ///< its file: for messages, and beside it the files that it names
  bool errors = false;                        ///< the IMU has the errors of the mission's [errors]; else it is ideal, or:
  std::optional<Calibration> unit = {};       ///< gives the raw readings of this one, with the noise of [errors]
  std::uint64_t seed = 1;                     ///< of errors and noise
  std::function<void(double)> progress = {};  ///< called with the fraction done, 0 to 1
};

struct FlownMission {
  Session session;                           ///< the recording, the exact start, the truth
  Recording recording;                       ///< recording.csv
  Solution truth;                            ///< truth.csv
  std::optional<HeightRecord> heights = {};  ///< barometer.csv, where the mission's vertical channel uses one
  std::vector<SimulatedAid> aids = {};       ///< gnss_1.csv and the like
  std::vector<std::string> warnings;
};

/// Throws Error as trajectory_of does, where [errors] are asked for that the mission lacks, and as simulate_motion.
FlownMission fly(const MissionFile& file, const TrajectoryTask& task);

/// The IMU that the mission's [errors] describe, as a session declares it: its grade and noise.
ImuDeclaration declared_imu(const MissionFile& file, const std::string& mission, std::vector<std::string>& warnings);

/// recording.csv, truth.csv, session.toml, barometer.csv where there is one, and the files of aids, in a new folder, whole or not at all. Throws
/// Error where it exists or cannot be written.
void write_flown(const std::filesystem::path& folder, const FlownMission& flown);

/// Flies the mission, and writes the folder where one is named.
AnswerOf<FlownMission> flight_answer(const MissionFile& file, const TrajectoryTask& task, const std::string& folder);

}  // namespace imulab
