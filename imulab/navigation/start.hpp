// The start of navigation: a given state, or the alignment on the first rest.
#pragma once

#include "imulab/navigation/navigate.hpp"

namespace imulab::navigation {

struct Start {
  NavigationState state;
  double time = 0;  // s
  std::optional<AlignedOn> aligned = {};
  std::vector<std::string> warnings = {};
};

/// Of a `compensated` recording. Throws as navigate does.
Start start_of(const Calibration& calibration, const Session& session, const Recording& compensated, const NavigateOptions& options);

}  // namespace imulab::navigation
