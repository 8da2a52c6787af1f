// Checks a drive's calibration without aids: at rest, the force is gravity, and the gyros propagate its direction from one rest to the next.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/session.hpp"

#include <string>

namespace imulab::drive {

/// Doubts a calibration whose rests or turns have errors that its covariance does not explain. The rests are those of `recording`, on which
/// `navigation` is based; `before` is the prefix of the reason.
void doubt_at_rest(const Calibration& calibration, const AidedNavigation& navigation, const Recording& recording, const Session& session,
                   const std::string& before, kernel::Findings& findings);

}  // namespace imulab::drive
