// Whole-unit calibration (docs/whole-unit.md): thermal chamber, rate table and centrifuge -> up to 57 independent coefficients (Dai 2011 section 3
// counts 63 with the thermal constants, which the gauge c0 = d0 = 0 at T0 fixes), jointly by weighted least squares or in Dai's three steps.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <string>
#include <vector>

namespace imulab {

struct WholeUnitOptions {
  std::vector<int> terms{};     ///< table indices to estimate; empty: all, of which the orders that the data do not show are left out
  bool full = false;            ///< all that the data determine, significant or not
  bool stepwise = false;        ///< Dai's three steps instead of the joint estimate
  double outlier_level = 1e-3;  ///< probability that a good point is dropped in a good session
};

/// One recording for each of the session's, in its order. Machines may be missing: what they would have determined keeps its starting value and is
/// listed. Throws Unsupported where nothing can be determined, Error where a mount, a unit or a direction contradicts the data.
Calibration calibrate_whole_unit(const std::vector<Recording>& recordings, const Session& session, const WholeUnitOptions& options = {});

}  // namespace imulab
