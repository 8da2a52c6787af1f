// The methods without a rig: rests in many orientations, and the rotations between them.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::rests {

/// Static calibration (docs/theory/handheld.md): Cheng's coarse solution from the rests (Cheng 2014 sec 1.2), refined by maximum likelihood.
/// Accelerometers follow from |f| = g. Gyros that resolve the Earth's rate at a known latitude follow from its size and its angle to gravity.
/// Requires one recording. Throws Unsupported if nothing can be determined, and Error if the declared units contradict the data.
CalibrationResult calibrate_static(const CalibrationInput& input, const CalibrationOptions& options);

/// Handheld calibration (docs/theory/handheld.md): accelerometers from the rests, gyros and their g-sensitivity from the rests and the rotations
/// between them, jointly by maximum likelihood (after Tedaldi 2014). Requires one recording. Throws like calibrate_static.
CalibrationResult calibrate_handheld(const CalibrationInput& input, const CalibrationOptions& options);

/// Returns the turn after `rests` rests, while the data are too few for a fit: the six faces in sequence.
HandTurn opening_turn(std::size_t rests);

/// Predict the standard uncertainties of both methods (docs/theory/strapdown.md) for an ideal IMU with the declared noise. Throw Error if the
/// procedure has several recordings, no hold, or no declared noise.
Prediction predict_static(const Session& procedure, const PredictionOptions& options = {});
Prediction predict_handheld(const Session& procedure, const PredictionOptions& options = {});

/// Return whether a recording supports a method: the rests need enough directions; the handheld method also needs turns that its gyros explain.
MethodSupport support_static(const RestEvidence& evidence);
MethodSupport support_handheld(const RestEvidence& evidence);

}  // namespace imulab::rests
