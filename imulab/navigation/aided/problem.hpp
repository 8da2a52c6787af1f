// The states, noise sources and observations of an aided navigation, in one table each.
//
// The error state must be added to the computed state: C_nb = (I + [phi x]) C_hat, v = v_hat + dv, p = p_hat + dp (east-north-up [m]), and x = x_hat
// + dx for every other state. The sensors' constants are errors of the calibrated output,
//
//   w = (I + Mg) w_hat + bg + G f_hat,   f = (I + Ma) f_hat + ba
//
// with w_hat read later than f_hat by the gyros' delay.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/increment_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::aided {

/// Indices of the first nine states, and of the first sensor state.
struct At {
  static constexpr Eigen::Index attitude = 0, velocity = 3, position = 6, sensors = 9;
};

/// Kinds of motion: an aided navigation is at rest below 0.3 m/s, turns above 5 deg/s and accelerates above 0.5 m/s^2.
inline constexpr std::array<const char*, 4> motion_kinds{"at rest", "straight", "turning", "accelerating"};
/// Returns the kind of motion between two states as an index of `motion_kinds`.
std::size_t motion_kind(const NavigationState& a, const NavigationState& b, double seconds);

/// The noise that one variance factor multiplies: white noise of a kind's rows, driving noise of slow states, or noise of a triad.
struct NoiseSource {
  std::string name;
  double factor = 1;
  bool estimated = true;
};

/// A group of states with a common law: x' = -x / time + u, u white. An infinite time without walk means constants.
struct StateBlock {
  std::string name;
  std::vector<std::string> elements = {};  // full names of constants
  Eigen::Index first = -1, size = 0;
  Eigen::VectorXd prior;             // standard deviation at the start
  double time = INFINITY;            // correlation time [s]
  double sigma = 0;                  // stationary standard deviation if the time is finite
  Eigen::VectorXd walk;              // growth of the standard deviation [unit/sqrt(s)]; empty: none
  std::optional<std::size_t> noise;  // source of u
  bool stationary() const { return std::isfinite(time) && noise; }
};

/// An aid and the indices of its states (-1: absent). `delay`: delay at delay_time [s] and its drift [s/s]. `level`: common error of all heights.
struct Channel {
  std::string name;
  Aid aid;
  Eigen::Index lever = -1, delay = -1, mount = -1, scale = -1, slow = -1, level = -1;
  std::size_t first_noise = 0, second_noise = 0;                                   // noise source of position (or value), and of velocity or attitude
  Eigen::Index body = -1, tilt = -1, slow_turn = -1;                               // of poses (pose.hpp)
  Matrix3d body_start = Matrix3d::Identity(), frame_start = Matrix3d::Identity();  // about which these are
  double scale_start = 1;
};

/// A row of an aid's record, or a time at which a constraint applies.
struct Observation {
  double stamp = 0;  // s, on the recording's clock, before removal of the delay
  std::size_t channel = 0, row = 0;
  bool withheld = false;
};

/// Further terms of the sensors, linear in constants about zero: c adds c times a change of rate and force (3 rows each).
struct OutputTerms {
  std::vector<std::string> names;
  Eigen::VectorXd sigma;  // prior sigmas of the constants
  /// Returns the changes over a sample that ends at `time` [s].
  std::function<void(double time, const TimedIncrement& sample, Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> changes)> at;
};

struct Problem {
  IncrementView samples;             // samples of the calibrated recording, which must outlive the problem
  std::vector<double> time;          // end of each sample [s]
  double begin = 0;                  // begin of the first sample [s]
  double interval = 0;               // nominal [s]
  std::optional<double> gravity;     // m/s^2
  Vector3d gyro_noise, accel_noise;  // densities of each axis, SI
  Vector3d gyro_white, accel_white;  // densities that include the fast part of flicker
  std::size_t gyro_source = 0, accel_source = 0;
  std::vector<NoiseSource> sources;
  std::vector<StateBlock> blocks;  // all states except the first nine
  Eigen::Index gyro_offset = 9, accel_offset = 12, gyro_matrix = -1, accel_matrix = -1, g_sensitivity = -1;
  Eigen::Index gyro_delay = -1;                        // of the gyros against the accelerometers [s]
  Eigen::Index gyro_flicker = -1, accel_flicker = -1;  // in addition to the offsets
  Eigen::Index earth_rate = -1;                        // of the Earth's rate in the level axes of poses, whose north is unknown
  const OutputTerms* terms = nullptr;                  // their states begin at terms_first
  Eigen::Index terms_first = -1;
  Eigen::Index sensors_end = 15;  // end of the states on which the sensors' output depends
  Eigen::Index size = 15;
  Eigen::MatrixXd joint = {};  // covariances between states at the start, in addition to the variances; empty: none
  std::vector<Channel> channels;
  std::vector<Observation> observations;  // sorted by stamp
  /// Returns the end of the first `count` samples [s].
  double time_after(std::size_t count) const { return count > 0 ? time[count - 1] : begin; }
  double middle() const { return (begin + time.back()) / 2; }
  /// Returns the time to which a delay refers: the middle of the recording, or of its first ten minutes if it is longer. With an unknown drift, a
  /// delay hours earlier is uninformative.
  double delay_time() const { return std::min(middle(), begin + 300); }
  double longest_step = 1;  // s: between two epochs
  /// s: half of the time over which an Instant is a mean. Shorter means have more noise of the sensors; poses resolve the change of fast turns.
  double half_instant = 0.05;
  Vector3d place = Vector3d::Zero();  // origin of poses: latitude, longitude [rad], height [m]
  double vertical_earth_rate = 0;     // before the data, rad/s
};

/// A navigation state and all other states (the first nine are zero).
struct FullState {
  NavigationState motion;
  Eigen::VectorXd x;
};

/// The start of the filter: the mean before any data, and one standard deviation of all states.
struct FilterStart {
  FullState mean;
  Eigen::VectorXd sigma;
  std::size_t sample = 0;  // the state precedes this sample
};

/// Returns the state with an error state added.
FullState plus(const FullState& state, const Eigen::VectorXd& error);
NavigationState plus(const NavigationState& state, const Eigen::Matrix<double, 9, 1>& error);
/// Returns a state with only latitude, longitude and height.
NavigationState at_place(const Vector3d& place);
/// Returns the first nine elements of the error state that takes `from` to `to`.
Eigen::Matrix<double, 9, 1> minus(const NavigationState& to, const NavigationState& from);

/// A sample whose angle is later than its velocity.
struct DelayedSample {
  TimedIncrement sample;
  Vector3d angle_slope = Vector3d::Zero();  // change of the angle by the delay [rad/s]
};
/// Returns sample i with the angle later by the gyros' delay in `x`, as if their rate were constant in each interval.
DelayedSample delayed_sample(const Problem& problem, std::size_t i, const Eigen::VectorXd& x);

/// Returns a delayed sample after removal of the other errors of the sensors in `x`.
Increment corrected(const Problem& problem, const TimedIncrement& sample, const Eigen::VectorXd& x);

/// Returns the delay of an aid's stamps at `stamp` [s].
double delay_at(const Problem& problem, const Channel& channel, const Eigen::VectorXd& x, double stamp);

/// Returns the Earth's rate in the level axes.
Vector3d earth_rate_at(const Problem& problem, const FullState& state);

/// Returns a name in words: "gnss.slow_error" becomes "gnss slow error".
std::string in_words(std::string name);

/// Returns true for constants that are results: not for nuisances.
bool is_result(const Problem& problem, const StateBlock& block);

/// Appends a block of states.
Eigen::Index add_block(Problem& problem, StateBlock block);

}  // namespace imulab::aided
