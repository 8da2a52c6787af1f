// The rests of a recording: declared by the session's steps, or found in the data.
//
// Example:
//   for (const Range& rest : rests_of(recording, session).ranges)
//     std::printf("%g s to %g s\n", recording.time_s(rest.begin), recording.time_s(rest.end - 1));
//
// A rest is found where the scatter of half a second is near that of the recording's quietest stretches, and means over a second and more change no
// more than the noise of a sensor can. Ranges are of samples, half-open, in time order. Throws Error for what `validate` refuses, and for the steps
// of machines that never rest. Time is linear in the number of samples. Safe on any thread.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

struct RestOptions {
  double window_s = 0.5;        ///< length of a window; motion shorter than a fraction of it is not detected
  double shortest_s = 1.0;      ///< a shorter quiet run is not a rest
  double threshold_sigmas = 6;  ///< threshold above the center of the cluster, in its own (robust) widths
};

/// The rests, and the thresholds used (in the recording's units, per axis).
struct RestDetection {
  std::vector<Range> rests = {};
  std::array<double, 3> gyro_noise{}, accel_noise{};  ///< standard deviation of a sample at rest
  double gyro_factor = 0, accel_factor = 0;           ///< a window is quiet below noise x factor
  std::size_t turning = 0;                            ///< quiet runs rejected because the IMU was turning steadily
  std::size_t moving = 0;                             ///< quiet runs rejected because no sensor at rest changes as much
  std::string motion = {};                            ///< how much the longest of them does
  std::vector<std::string> notes = {};                ///< the same in words
};

/// Quiet stretches, compared with the quietest of the recording, in which means over a second and more change no more than a sensor's noise can. A
/// recording may lack a triad. Throws Error for what `validate` refuses, and for options that are not finite and above 0.
RestDetection detect_rests(const Recording& recording, const RestOptions& options = {});

struct Rests {
  std::vector<Range> ranges = {};
  std::vector<std::string> notes = {};  ///< their source, and the thresholds used
  std::string motion = {};              ///< as RestDetection has it
};

/// The holds of the steps that belong to the recording, less a tenth of a second at both ends (a twentieth of short ones, nothing
/// at less than 20 Hz); where it has none, the rests that detect_rests finds, less those inside a turn that the steps
/// declare. Throws Error for steps of machines: a rate table, centrifuge or chamber.
Rests rests_of(const Recording& recording, const Session& session);

}  // namespace imulab
