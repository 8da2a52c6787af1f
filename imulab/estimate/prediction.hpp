// The prediction that an estimate of ideal readings gives.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/eigen.hpp"
#include "imulab/predict.hpp"

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

/// The prediction that a calibration of ideal readings gives.
Prediction prediction_of(const Calibration& calibration);

}  // namespace imulab
