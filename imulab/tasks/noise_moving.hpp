// What `imulab noise --moving` is given beside the log at rest.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/noise.hpp"
#include "imulab/recording.hpp"
#include "imulab/results/aided.hpp"

#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace imulab {

struct MovingCalibration {
  std::string file;
  std::shared_ptr<const Calibration> calibration;
};
struct MovingNavigation {
  std::string file;
  std::vector<AidedMotion> motion;
};
using MovingInput = std::variant<std::shared_ptr<const Recording>, MovingCalibration, MovingNavigation>;
/// What a JSON file contains. Throws Error for another result than a calibration or an aided navigation.
MovingInput moving_input(const std::string& file);

/// Adds `moving` and its warnings to the noise at rest. Throws Error and Unsupported as moving_log and moving_calibration do.
void add_moving(NoiseAnalysis& rest, const std::vector<MovingInput>& inputs);

}  // namespace imulab
