// A session navigated with a calibration: compensated, aligned on a rest or started from a given state, integrated.
#pragma once

#include "imulab/core/units.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/navigation/alignment/alignment.hpp"
#include "imulab/navigation/inertial_samples.hpp"
#include "imulab/navigation/integration/strapdown.hpp"
#include "imulab/recording/session.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

enum class GapTreatment { integrate, refuse };

struct AlignedOn {
  FineAlignment alignment;
  double begin = 0, end = 0;  // of the rest [s]
};

/// The start of a navigation, and its end.
struct NavigationStart {
  const NavigationState& state;
  const std::optional<AlignedOn>& aligned;
  double time, end, interval;  // s; of the samples, nominal
};

struct NavigateOptions {
  VerticalChannel vertical = VerticalChannel::free;
  bool align = false;                        // on the first rest, although the session gives an attitude
  std::optional<GivenHeading> heading = {};  // roll and pitch are aligned, the heading is this one
  GapTreatment gaps = GapTreatment::integrate;
  std::optional<HeightRecord> barometer = {};                                            // for the vertical channels aided and held
  std::function<void(const NavigationStart&)> begin = {};                                // called first
  std::function<void(double time, const NavigationState&)> each = {};                    // called with every state as it is reached, the start's too
  std::function<void(double time, const NavigationState&, const Increment&)> step = {};  // called with the increment to every state but the start's
  bool keep = true;  // every state in the solution; otherwise the first and the last
};

/// A less certain heading is refused (Unsupported): the Earth's rate was not resolved.
inline constexpr double largest_heading_sigma = 10 * unit::deg;  // rad

struct Navigated {
  Solution solution;  // from the start, then at every sample's end; or its first and last state
  VerticalChannel vertical = VerticalChannel::free;
  std::optional<AlignedOn> aligned;    // absent: started from the session's initial state
  std::vector<MissingTime> gaps;       // bridged
  std::size_t saturated = 0;           // samples at a limit among those integrated
  std::vector<NavigationState> track;  // some thousand states along the way, for drawings
  std::vector<std::string> warnings;
  bool doubtful = false;  // for a reason among the warnings: errors that no uncertainty holds
};

/// `recording` is raw. Starts at the session's initial state, or at the end of the first rest, aligned on it, at the position of the initial state or
/// else of the site. Throws Error where the session has no position or the start lies outside the recording, for missing barometer heights, for gaps
/// that are to be refused and for readings far beyond any motion; Unsupported where there is no rest to align on, or where it does not show the
/// heading. A recording that is moved here is compensated in its place.
Navigated navigate(const Calibration& calibration, const Session& session, Recording recording, const NavigateOptions& options = {});

/// One sigma [rad] of roll, pitch and heading, from an attitude's covariance in east-north-up.
Eigen::Vector3d angle_sigmas(const Alignment& alignment);

}  // namespace imulab
