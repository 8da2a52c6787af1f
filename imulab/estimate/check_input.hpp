// What every method needs checked before it begins, in one place.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

#include <string>

namespace imulab {

/// The input with a session that declares its recordings (recording/validate.hpp). Throws Error that lists all that is wrong with the session, the
/// options, the rests and the recordings.
CalibrationInput checked_input(const Method& method, const CalibrationInput& input, const CalibrationOptions& options);

/// Throws Error that lists all that is wrong with the procedure and the options.
void expect_valid(const Session& procedure, const PredictionOptions& options);

/// What a prediction with restricted terms takes as absent: the terms of the whole one that it does not have. Empty: nothing.
std::string note_of_absent(const Prediction& restricted, const Prediction& whole);

}  // namespace imulab
