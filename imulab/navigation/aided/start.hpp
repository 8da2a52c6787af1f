// The start of an aided navigation: at rest or in motion, with any heading.
#pragma once

#include "imulab/navigation/aided/filter.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>

namespace imulab::aided {

struct FoundStart {
  FilterStart start;
  std::optional<FilterStart> at_fix = {};  // set if the first fix is long after the start: a filter from there remains near the truth
  int candidates = 1;                      // number of headings that were tried
  double seconds = 0;                      // duration of the deciding data
  double spread = 0;                       // rad: spread of the headings that the data allow, weighted by likelihood, about the best one
  double late_by = 0;                      // s: from the start of the recording to the start of navigation at the first fix
};
/// Returns a start near a state before any data: other states follow their prior, the heading is as uncertain as a candidate's.
FilterStart start_near(const Problem& problem, const NavigationState& state);
/// Finds the start. Its time is that of the session's initial state; otherwise the begin of the recording if a fix follows within two seconds or a
/// rest lasts until the first fix; otherwise the first fix. Position and velocity come from the fix at that time, the initial state or the site; the
/// level from the mean force minus the receiver's acceleration; the heading from the initial state or the candidate with the largest likelihood.
/// Throws Error if nothing determines a position, or the initial state is outside the recording.
FoundStart find_start(const Problem& problem, const Session& session);

}  // namespace imulab::aided
