// For tests of what a calibration by hand needs next: a simulated unit that is turned as it is told.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/simulate.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <vector>

namespace imulab {

/// The unit and the place of a handheld procedure, at rest at first, and turned about its own axes from there.
class TurnedUnit {
 public:
  TurnedUnit(const HandHeldOptions& options, std::uint64_t seed)
      : session(hand_held_procedure(options, seed)), rate_hz_(options.rate_hz), seed_(seed) {
    session.steps.clear();
    truth = draw_truth(session, seed);
    rest(options.first_rest);
  }

  void rest(double seconds) { move(Vector3d::Zero(), 0, seconds); }
  /// As a hand does it, in two seconds for half a turn; then at rest for `seconds`.
  void turn(const HandTurn& turn, double seconds) {
    move(turn.axis.normalized(), turn.angle, turn_duration(turn.angle, 2.5, 5));
    rest(seconds);
  }
  Recording recording() const { return simulate_motion(ideal_, 1 / rate_hz_, truth, seed_); }

  Session session;
  Truth truth;

 private:
  void move(const Vector3d& axis, double angle, double seconds) {
    constexpr int parts = 8;  // of a sample: the specific force is the mean of theirs
    const double dt = 1 / rate_hz_;
    const Matrix3d begin = C_nb_;
    const Vector3d earth = earth_rate_enu(*session.site.latitude), up(0, 0, truth.gravity);
    for (int i = 0; i < static_cast<int>(seconds / dt); ++i) {
      Increment sample;
      for (int k = 0; k < parts; ++k) {
        const TurnState state = turn_state(angle, 2.5, 5, (i + (k + 0.5) / parts) * dt);
        const Matrix3d C_bn = (begin * rotation_exp(Vector3d(state.angle * axis))).transpose();
        sample.angle += dt / parts * (state.rate * axis + C_bn * earth);
        sample.velocity += dt / parts * (C_bn * up);
      }
      ideal_.push_back(sample);
    }
    C_nb_ = begin * rotation_exp(Vector3d(angle * axis));
  }

  double rate_hz_;
  std::uint64_t seed_;
  Matrix3d C_nb_ = Matrix3d::Identity();
  std::vector<Increment> ideal_;
};

}  // namespace imulab
