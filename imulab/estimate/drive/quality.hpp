// The quality of a drive's calibration: undetermined coefficients, the aids' lever arms, delays and mounting angles, and reasons for doubt.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab::drive {

/// Returns the prefix "second.csv: " if there are several drives.
std::string in_front(const std::vector<Drive>& drives, const Drive& drive);

/// Add to quality and findings: undetermined coefficients with maneuvers that make them observable; and the constants of the aids.
void name_undetermined(const AidedNavigation& navigation, Quality& quality, kernel::Findings& findings);
void add_aids(const AidedNavigation& navigation, Quality& quality);
/// Returns "gnss.lever_arm.up 0.512 m (u = 0.03)".
std::string constant_text(const AidedConstant& constant);

/// Fills in the quality except for the verdict; returns the findings that determine it.
kernel::Findings judged(const std::vector<Drive>& drives, const Together& all, const Session& session, Calibration& calibration);

}  // namespace imulab::drive
