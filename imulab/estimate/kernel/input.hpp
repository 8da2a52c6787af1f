// The input of a method with one recording, and the coefficients that it was asked for.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"

#include <string_view>

namespace imulab::kernel {

/// The only recording, validated. Throws Error that lists them where there are several, or none.
const Recording& only_recording(const CalibrationInput& input, std::string_view method);

/// The source of a procedure's only recording; one that declares nothing where it has none. Throws Error for several.
RecordingSource only_source(const Session& procedure);

/// The rests of that recording: those given, else the session's holds, else those found in the data, with a note of their source.
Rests rests_of(const CalibrationInput& input, const Recording& recording);

/// Throws Unsupported where an axis reads the same in every sample.
void expect_alive(const Recording& recording, Triad triad, std::string_view consequence);

/// Those of `supplied` that are `wanted`, all of them where none is named. Throws TermsError naming one that the method does not estimate.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method);

}  // namespace imulab::kernel
