// The start of an aided navigation: at rest or in motion, with any heading.
#pragma once

#include "imulab/navigation/aided/filter.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>

namespace imulab::aided {

struct FoundStart {
  FilterStart start;
  std::optional<FilterStart> at_fix = {};  // where the first fix is long after the start: a filter from there stays near the truth
  int candidates = 1;                      // headings that were tried
  double seconds = 0;                      // of data that decided
  double spread = 0;                       // rad: of the headings that the data leave, by their likelihoods; about the best one
  double late_by = 0;                      // s: the start after the recording's, at the first fix
};
/// Before any data, near a state: all else by its prior, the heading as uncertain as a candidate's.
FilterStart start_near(const Problem& problem, const NavigationState& state);
/// The start is the time of the session's initial state; without one the recording's begin, where a fix is there within two seconds or a rest lasts
/// until the first one, or else the first fix. Position and velocity are those of the fix of that time, or of the initial state or site; level from
/// the mean force less the receiver's acceleration; the heading from the initial state, or the candidate with the largest likelihood. Throws Error
/// where nothing gives a position, and for an initial state outside the recording.
FoundStart find_start(const Problem& problem, const Session& session);

}  // namespace imulab::aided
