// The input of a method with one recording, and the requested coefficients.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"

#include <string_view>

namespace imulab::kernel {

/// Returns the only recording, validated. Throws Error if there is none, or with a list if there are several.
const Recording& only_recording(const CalibrationInput& input, std::string_view method);

/// Returns the source of a procedure's only recording, or an empty one if it has none. Throws Error for several.
RecordingSource only_source(const Session& procedure);

/// Returns the given rests, else the session's holds, else rests found in the data, with a note of their source.
Rests rests_of(const CalibrationInput& input, const Recording& recording);

/// Throws Unsupported if an axis has the same reading in every sample.
void expect_alive(const Recording& recording, Triad triad, std::string_view consequence);

/// Returns the `supplied` coefficients that are `wanted`, or all if none is wanted. Throws TermsError with a name that the method does not estimate.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method);

}  // namespace imulab::kernel
