// What a drive says of its own calibration: what it did not show, the aids' lever arms, delays and mounting angles, and reasons for doubt.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/session.hpp"

#include <string>
#include <vector>

namespace imulab::drive {

/// "second.csv: " if there are several drives.
std::string in_front(const std::vector<Drive>& drives, const Drive& drive);

/// What the drives did not show, with the manoeuvre that would, and the constants of the aids: into quality and findings.
void name_undetermined(const AidedNavigation& navigation, Quality& quality, kernel::Findings& findings);
void add_aids(const AidedNavigation& navigation, Quality& quality);
/// "gnss.lever_arm.up 0.512 m (u = 0.03)"
std::string constant_text(const AidedConstant& constant);

/// Fills in the quality but for the verdict; the findings are the reasons for that.
kernel::Findings judged(const std::vector<Drive>& drives, const Together& all, const Session& session, Calibration& calibration);

}  // namespace imulab::drive
