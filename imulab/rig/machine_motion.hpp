// A machine's steps -> the angle of its one axis as a function of time, and where the unit's accelerometers are.
#pragma once

#include "imulab/rig/motion.hpp"

namespace imulab {

/// The motion of these steps (of one recording) on a rate table, centrifuge or chamber, as the outer axis of a table with one axis:
/// - spin: at its rate from its start to its end. Accelerometer i is at the step's radius i along `outward`; the unit's own lever arms do not count;
/// - hold: at rest at its outer angle, modulo whole turns;
/// - the gap before a step: the rate changes smoothly, without angular acceleration at its ends; the unit is mounted anew at its end.
/// The machine begins as its first step has it where that begins at time 0, else at rest at zero angle. Throws Error where a step is impossible, or
/// has no gap before it that its angle, rate or mount needs.
RigMotion machine_motion(const RigDeclaration& rig, std::span<const Step> steps, const RigErrors& errors = {});

/// The motion of a recording on whatever rig it has.
RigMotion recorded_motion(const Session& session, const RecordingSource& source, const RigErrors& errors = {});

}  // namespace imulab
