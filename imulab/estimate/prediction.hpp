// Predictions from an estimate with ideal readings.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/eigen.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/predict.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Throws Error that lists all options out of range: terms and requirements.
void validate(const PredictionOptions& options);

/// Returns the prediction from a calibration with ideal readings. Its degrees of freedom are those of the fit.
Prediction prediction_of(const Calibration& calibration);

/// Adds the sigmas for an IMU with half and twice the expected effects; `of` predicts a procedure.
void add_sizes(Prediction& prediction, const Session& procedure, const std::function<Prediction(const Session&)>& of);

/// Returns the predicted sigma: infinite if the procedure does not determine it, 0 if the frame fixes it.
StatedSigma predicted(const Prediction& prediction, CoefficientIndex index);

}  // namespace imulab
