// Hand-held calibration (docs/handheld.md): accelerometers from the rests, gyros with their g-sensitivity from the rests and the rotations between
// them, all jointly by maximum likelihood.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab {

struct EstimateOptions {
  std::vector<int> terms;           ///< table indices to estimate; empty: what the method supplies, optional terms by their significance
  double significance = 0.01;       ///< an optional term is kept if chance explains it with at most this probability
  double outlier_level = 1e-3;      ///< probability of dropping anything from good data
};

/// Rests are sample ranges in time order. Throws Unsupported where nothing can be determined, Error where the declared units contradict the data.
Calibration calibrate_handheld(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, const Site& site,
                               const EstimateOptions& options = {});

}  // namespace imulab
