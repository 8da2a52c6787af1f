// The rests of a recording: declared by the session's steps, or found in the data.
#pragma once

#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/session.hpp"

#include <array>
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
  std::vector<Range> rests;
  std::array<double, 3> gyro_noise{}, accel_noise{};  ///< standard deviation of a sample at rest
  double gyro_factor = 0, accel_factor = 0;           ///< a window is quiet below noise x factor
  std::size_t turning = 0;                            ///< quiet runs rejected because the IMU was turning steadily
  std::size_t moving = 0;                             ///< quiet runs rejected because no sensor at rest changes as much
  std::string motion;                                 ///< how much the longest of them does (rest_or_motion.hpp)
  std::vector<std::string> notes;                     ///< the same in words
};

/// An IMU at rest on both sides of a shorter gap was at rest inside it.
inline constexpr double still_s = 0.25;

/// Quiet stretches, compared with the quietest of the recording, in which means over a second and more change no more than a sensor's noise can. A
/// recording may lack a triad. Throws Error for what `validate` refuses.
RestDetection detect_rests(const Recording& recording, const RestOptions& options = {});
/// As above, for a recording that is known to be valid.
RestDetection detect_rests(const RecordingView& recording, const RestOptions& options = {});

struct Rests {
  std::vector<Range> ranges;
  std::vector<std::string> notes;  ///< their source, and the thresholds used
  std::string motion;              ///< as RestDetection has it
};

/// The holds of the steps that belong to the recording, less a tenth of a second at both ends (a twentieth of short ones, nothing
/// at less than 20 Hz); where it has none, the rests that detect_rests finds, less those inside a turn that the steps
/// declare. Throws Error for steps of machines: a rate table, centrifuge or chamber.
Rests rests_of(const Recording& recording, const Session& session);
/// As above, for a recording that is known to be valid.
Rests rests_of(const RecordingView& recording, const Session& session);

}  // namespace imulab
