// The input of a method with one recording.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/recording/rests.hpp"

#include <string_view>

namespace imulab::kernel {

/// The only recording, validated. Throws Error that lists them where there are several, or none.
const Recording& only_recording(const CalibrationInput& input, std::string_view method);

/// The rests of that recording: those given, else the session's holds, else those found in the data, with a note of their source.
Rests rests_of(const CalibrationInput& input, const Recording& recording);

}  // namespace imulab::kernel
