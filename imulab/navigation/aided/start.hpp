// The start of an aided navigation: at rest or in motion, with any heading.
#pragma once

#include "imulab/navigation/aided/filter.hpp"
#include "imulab/session.hpp"

#include <optional>

namespace imulab::aided {

struct FoundStart {
  FilterStart start;
  int candidates = 1;  // headings that were tried
  double seconds = 0;  // of data that decided
  double spread = 0;   // rad: of the headings that the data leave, by their likelihoods; about the best one
};
/// Before any data, near a state: all else by its prior, the heading as uncertain as a candidate's.
FilterStart start_near(const Problem& problem, const NavigationState& state);
/// Position and velocity from the first fixes of a receiver, or the session's initial state or site; level from the mean force less the receiver's
/// acceleration; the heading from the initial state, whose time is the start, or the candidate with the largest likelihood. Throws Error where
/// nothing gives a position, and for an initial state outside the recording.
FoundStart find_start(const Problem& problem, const Session& session);

}  // namespace imulab::aided
