// The rests of a recording, declared by the session's steps or found in the data.
//
// Example:
//   for (const Range& rest : rests_of(recording, session).ranges)
//     std::printf("%g s to %g s\n", recording.time_s(rest.begin), recording.time_s(rest.end - 1));
//
// A rest is found if the scatter within half a second is close to that of the quietest parts of the recording, and means over 1 s and more do not
// change by more than a sensor's noise can explain. Ranges of samples are half-open and in time order. Functions throw Error if `validate` refuses
// the recording, and for steps of machines that never rest. The time is linear in the number of samples. Safe on any thread.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

struct RestOptions {
  double window_s = 0.5;        ///< length of a window; motion much shorter than a window is not detected
  double shortest_s = 1.0;      ///< a shorter quiet part is not a rest
  double part = INFINITY;       ///< a rest whose thermal reading changes by more than twice as much is divided into parts of it
  double threshold_sigmas = 6;  ///< threshold above the center of the cluster of windows, in robust widths of the cluster
};

/// The rests and the thresholds used (per axis, in units of the recording).
struct RestDetection {
  std::vector<Range> rests = {};
  std::array<double, 3> gyro_noise{}, accel_noise{};  ///< standard deviation of one sample at rest
  double gyro_factor = 0, accel_factor = 0;           ///< a window is quiet if its deviation is below noise x factor
  std::size_t turning = 0;                            ///< number of quiet parts rejected because the IMU turned steadily
  std::size_t moving = 0;                             ///< number of quiet parts rejected because they change more than any sensor at rest
  std::string motion = {};                            ///< amount of that change in the longest of them
  std::vector<std::string> notes = {};                ///< the same as text
};

/// Finds parts that are as quiet as the quietest of the recording and whose means over 1 s and more do not change by more than a sensor's noise can
/// explain. A triad may be missing. Throws Error if `validate` refuses the recording or an option is not finite and above 0.
RestDetection detect_rests(const Recording& recording, const RestOptions& options = {});

struct Rests {
  std::vector<Range> ranges = {};
  std::vector<std::string> notes = {};  ///< source of the rests and thresholds used
  std::string motion = {};              ///< as in RestDetection
};

/// Returns the holds of the steps that belong to the recording, shortened at both ends by 0.1 s, but at most by 1/20, and above 20 Hz only.
/// Without holds, returns the rests of detect_rests except those inside a declared turn. Throws Error for steps of machines: rate table, centrifuge
/// or chamber.
Rests rests_of(const Recording& recording, const Session& session);

}  // namespace imulab
