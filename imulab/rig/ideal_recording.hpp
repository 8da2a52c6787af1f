// The readings of an ideal IMU on a procedure's motion: the exact means of rate and specific force over every sample.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <span>
#include <vector>

namespace imulab {

inline constexpr double default_sample_rate = 100;  ///< Hz, of a recording that declares none

/// The samples of a recording of these steps, by number: sample i covers (i, i + 1) / rate [s]. All from 0 to the end of the last step, or with
/// Extent::steps those whose interval lies inside a step. Ascending, not adjoining. Throws Error for a rate that is not above 0, for steps that last
/// less than a sample, and for more than 1e8 samples.
std::vector<Range> recorded_samples(const RecordingSource& source, std::span<const Step> steps);

/// The recording of an ideal IMU that moves as the procedure's steps say: columns gyro [rad/s] and accel [m/s^2], means over the sample's interval,
/// in body axes; no noise, no temperatures. Stamps are the ends of the intervals, rounded to nanoseconds; with Extent::steps a gap between steps. On
/// a rate table, centrifuge or chamber the steps' radii give the accelerometers' positions, and `surroundings.lever_arm` does not count. `errors`: of
/// the rig; empty for an exact one. Parallel; the result does not depend on the number of threads. Throws Error where a step is impossible
/// (recorded_motion) or recorded_samples does.
Recording ideal_recording(const Session& procedure, const RecordingSource& source, const Surroundings& surroundings, const RigErrors& errors = {});

/// The procedure's only recording, or all steps where it has none, of an ideal IMU at a rate of its own: the lowest of `slowest`, twice that, ... to
/// sixteen times at which no sample turns by more than 0.05 rad. Throws as ideal_recording.
Recording coarse_recording(const Session& procedure, const Surroundings& surroundings, double slowest = 20);

}  // namespace imulab
