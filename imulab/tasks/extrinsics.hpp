// Several IMUs of one body: where they are relative to each other.
#pragma once

#include "imulab/extrinsics.hpp"
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

/// Of one IMU, a prediction.
AnswerOf<Extrinsics> extrinsics_answer(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress);

}  // namespace imulab
