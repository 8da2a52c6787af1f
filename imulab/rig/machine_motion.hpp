// A machine's steps -> the angle of its one axis as a function of time, and the positions of the IMU's accelerometers.
#pragma once

#include "imulab/rig/motion.hpp"

namespace imulab::rig {

/// The motion of these steps (of one recording) on a rate table, centrifuge or chamber, as the outer axis of a table with one axis:
/// - spin: at its rate from its start to its end. Accelerometer i is at the step's radius i along `outward`; the IMU's own lever arms do not count;
/// - hold: at rest at its outer angle, modulo whole turns;
/// - the gap before a step: the rate changes smoothly, without angular acceleration at its ends; the IMU is remounted at its end.
/// The machine begins in the state of its first step if that begins at time 0, else at rest at zero angle. Throws Error where a step is impossible,
/// or has no gap before it that its angle, rate or mount needs.
RigMotion machine_motion(const RigDeclaration& rig, std::span<const Step> steps, const RigErrors& errors = {});

/// The motion of a recording on its rig.
RigMotion recorded_motion(const Session& session, const RecordingSource& source, const RigErrors& errors = {});

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
