// The checks of the input that are common to all methods.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

#include <string>

namespace imulab {

/// Returns the input with a session that declares its recordings (recording/validate.hpp). Throws Error with all faults of the session, the options,
/// the rests and the recordings.
CalibrationInput checked_input(const Method& method, const CalibrationInput& input, const CalibrationOptions& options);

/// Throws Error with all faults of the procedure and the options.
void expect_valid(const Session& procedure, const PredictionOptions& options);

/// Names the terms that a prediction with restricted terms assumes to be absent, compared with the whole one; empty if there are none.
std::string note_of_absent(const Prediction& restricted, const Prediction& whole);

}  // namespace imulab
