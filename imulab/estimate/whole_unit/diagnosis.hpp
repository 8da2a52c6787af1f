// Faults of a whole-unit session that could be calibrated: machines that are not as declared, a chamber whose points had not settled,
// hysteresis.
#pragma once

#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <string>

namespace imulab::whole_unit {

/// The one error of a machine that explains most of the points' excess scatter, with its consequence; empty where there is none.
std::string wrong_machine(const Problem& problem);

/// Warns of chamber points that had not settled, and of hysteresis.
void check_chamber(kernel::Findings& findings, const Problem& problem);

}  // namespace imulab::whole_unit
