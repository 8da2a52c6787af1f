// The methods that need no rig: rests in many orientations, and the rotations between them.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"

namespace imulab::rests {

/// Static calibration (docs/theory/handheld.md): Cheng's coarse solution from the rests alone (Cheng 2014 sec 1.2), then its maximum-likelihood
/// refinement. Accelerometers from |f| = g. Gyros, where they resolve Earth's rate at a known latitude, from the angle between Earth's rate and
/// gravity and from its size. One recording. Throws Unsupported where nothing can be determined, Error where the declared units contradict the data.
CalibrationResult calibrate_static(const CalibrationInput& input, const CalibrationOptions& options);

/// Handheld calibration (docs/theory/handheld.md): accelerometers from the rests, gyros with their g-sensitivity from the rests and the rotations
/// between them, all jointly by maximum likelihood (after Tedaldi 2014). One recording. Throws as calibrate_static does.
CalibrationResult calibrate_handheld(const CalibrationInput& input, const CalibrationOptions& options);

/// The turn after that many rests, while the data are too few for a fit: the six faces in turn.
HandTurn opening_turn(std::size_t rests);

/// Standard uncertainties that they will state of a procedure (docs/theory/strapdown.md), of an ideal IMU with the declared noise.
/// Throws Error for a procedure of several recordings, without a hold, or whose noise is not declared.
Prediction predict_static(const Session& procedure, const PredictionOptions& options = {});
Prediction predict_handheld(const Session& procedure, const PredictionOptions& options = {});

/// A recording supports the methods if its rests have enough directions; the handheld method also needs turns that its gyros explain.
MethodSupport support_static(const RestEvidence& evidence);
MethodSupport support_handheld(const RestEvidence& evidence);

}  // namespace imulab::rests
