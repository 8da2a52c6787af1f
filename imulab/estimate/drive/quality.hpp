// What a drive says of its own calibration: what it did not show, the aids' lever arms, delays and mounting angles, and reasons for doubt.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/session.hpp"

namespace imulab::drive {

/// Correlation of neighboring innovations of one source and component, the largest of those that chance does not explain; 0: all are white.
struct SerialCorrelation {
  std::string source;
  double value = 0;
};
SerialCorrelation serial_correlation(const AidedNavigation& navigation);

/// Fills in the quality but for the verdict; the findings are the reasons for that.
kernel::Findings judged(const AidedNavigation& navigation, const Session& session, Calibration& calibration);

}  // namespace imulab::drive
