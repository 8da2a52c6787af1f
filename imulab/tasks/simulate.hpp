// A procedure carried out by a virtual rig on a virtual IMU: a session with recordings, and the truth that a calibration should find.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"
#include "imulab/tasks/aid_files.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct SimulateOptions : ShowOptions {
  std::string procedure;
  std::optional<std::string> unit, grade;
  std::uint64_t seed = 1;
};
/// The verb `simulate`, which sets these.
Verb& declare(Verb& command, SimulateOptions& o);

struct SimulationTask {
  std::uint64_t seed = 1;
  std::optional<Calibration> unit = {};   ///< the IMU, in place of the procedure's
  std::optional<std::string> grade = {};  ///< a grade by its name, or the file of a noise analysis (.json), in place of the procedure's
};

struct Simulation {
  Session session;                    ///< as a user would have it: without the truth, with the limits of a data sheet, without the steps of a hand
  std::vector<Recording> recordings;  ///< one for each of the session's
  Calibration truth;
  std::vector<RecordedRigErrors> rig;
  std::vector<SimulatedAid> aids;
};

/// In memory. The procedure without a recording gets one at 100 Hz. Throws Error as draw_truth and simulate_recording do, and for a recording that is
/// not named like a file of the session's own folder.
Simulation simulate_session(Session procedure, const SimulationTask& task = {});

/// recordings, files of aids, session.toml and truth.json in a new folder, whole or not at all. Throws Error where it exists or cannot be written.
void write_simulated(const std::filesystem::path& folder, const Simulation& simulated);

/// Simulates, and writes the folder where one is named.
AnswerOf<Simulation> simulation_answer(Session procedure, const SimulationTask& task, const std::string& folder);

}  // namespace imulab
