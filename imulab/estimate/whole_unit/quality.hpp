// The quality of a whole-unit calibration: residuals, coefficients that are not determined and why, estimated errors of the machines. And faults of a
// session that could be calibrated: machines that are not as declared, a chamber whose points had not settled, hysteresis.
#pragma once

#include "imulab/estimate/whole_unit/joint_estimate.hpp"

#include <string>

namespace imulab::whole_unit {

/// All but the findings of the estimate and the verdict.
Quality quality_of(const Problem& problem, const JointEstimate& estimate);

/// The one error of a machine that explains most of the points' excess scatter, with its consequence; empty where there is none.
std::string wrong_machine(const Problem& problem);

/// Warns of chamber points that had not settled, and of hysteresis.
void check_chamber(kernel::Findings& findings, const Problem& problem);

}  // namespace imulab::whole_unit
