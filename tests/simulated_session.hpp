// For tests of the estimators: a simulated recording with everything that is known about it.
#pragma once

#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"

namespace imulab {

struct SimulatedSession {
  Session session;  ///< with the steps
  Truth truth;
  Recording recording;
  std::vector<Range> rests;  ///< as the data show them

  Site site() const { return session.site; }
};

inline HandHeldOptions short_hand_held() {
  HandHeldOptions options;
  options.poses = 24;
  options.first_rest = 5;
  return options;
}

/// `change` may edit the truth before it is simulated.
template <class Change>
SimulatedSession simulate_session(const HandHeldOptions& options, std::uint64_t seed, Change change) {
  SimulatedSession s;
  s.session = hand_held_procedure(options, seed);
  s.truth = draw_truth(s.session, seed);
  change(s.truth);
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, seed);
  Session without_steps = s.session;
  without_steps.steps.clear();
  s.rests = rests_of(s.recording, without_steps).ranges;
  return s;
}

inline SimulatedSession simulate_session(const HandHeldOptions& options, std::uint64_t seed) {
  return simulate_session(options, seed, [](Truth&) {});
}

}  // namespace imulab
