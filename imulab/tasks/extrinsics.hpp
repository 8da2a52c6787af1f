// Several IMUs of one body: where they are relative to each other.
#pragma once

#include "imulab/extrinsics.hpp"
#include "imulab/session.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct ExtrinsicsOptions : ShowOptions {
  std::vector<std::string> recordings, declarations, calibrations;
  std::optional<std::string> grade;
};
/// The verb `extrinsics`, which sets these.
Verb& declare(Verb& command, ExtrinsicsOptions& o);

/// The IMU of a session's recording: its name, its readings, and the grade of the options, else of the session. `tell` gets the warnings of reading.
BodyImu body_imu(const Session& session, const RecordingSource& source, std::string name, const ExtrinsicsOptions& o, const Tell& tell);
/// Gives the calibrations of the options to the IMUs: one each in their order, or "none". Throws OptionError for another number of them.
void take_calibrations(std::vector<BodyImu>& imus, const ExtrinsicsOptions& o);

AnswerOf<Extrinsics> extrinsics_answer(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress);

}  // namespace imulab
