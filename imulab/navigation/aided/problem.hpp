// The states of an aided navigation, its sources of noise and its observations, in one table each.
//
// The error state is what has to be added to the computed state: C_nb = (I + [phi x]) C_hat, v = v_hat + dv, p = p_hat + dp (east-north-up [m]), and
// every other state x = x_hat + dx. The sensors' constants are errors of the calibrated output,
//
//   w = (I + Mg) w_hat + bg + G f_hat,   f = (I + Ma) f_hat + ba
#pragma once

#include "imulab/aid.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/increment_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab::aided {

/// The first nine states.
struct At {
  static constexpr Eigen::Index attitude = 0, velocity = 3, position = 6, sensors = 9;
};

/// What one variance factor multiplies: the white noise of a kind's rows, the driving noise of slow states, or the noise of a triad.
struct NoiseSource {
  std::string name;
  double factor = 1;
  bool estimated = true;
};

/// A group of states with a common law: x' = -x / time + u, u white. Infinite time and no walk: constants.
struct StateBlock {
  std::string name;
  std::vector<std::string> elements = {};  // full names of constants
  Eigen::Index first = -1, size = 0;
  Eigen::VectorXd prior;             // standard deviation at the start
  double time = INFINITY;            // correlation time [s]
  double sigma = 0;                  // stationary, where the time is finite
  Eigen::VectorXd walk;              // growth of the standard deviation [unit/sqrt(s)]; empty: none
  std::optional<std::size_t> noise;  // the source of u
  bool stationary() const { return std::isfinite(time) && noise; }
};

/// An aid and the places of its states; -1: absent. `delay`: that at delay_time [s], and its drift [s/s], as clocks do. `level`: of all its heights.
struct Channel {
  std::string name;
  Aid aid;
  Eigen::Index lever = -1, delay = -1, mount = -1, scale = -1, slow = -1, level = -1;
  std::size_t first_noise = 0, second_noise = 0;  // of position (or value), of velocity
};

/// A row of an aid's record, or a time at which a constraint holds.
struct Observation {
  double stamp = 0;  // s, of the recording's clock, the delay not taken off
  std::size_t channel = 0, row = 0;
  bool withheld = false;
};

/// What else the sensors do, linear in constants about zero: c adds c times a change to rate and force (3 rows each).
struct OutputTerms {
  std::vector<std::string> names;
  Eigen::VectorXd sigma;  // of the constants
  /// Over a sample, which ends at a time [s].
  std::function<void(double time, const TimedIncrement& sample, Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> changes)> at;
};

struct Problem {
  IncrementView samples;             // of the calibrated recording, which has to outlive it
  std::vector<double> time;          // end of each [s]
  double begin = 0;                  // of the first [s]
  double interval = 0;               // nominal [s]
  std::optional<double> gravity;     // m/s^2
  Vector3d gyro_noise, accel_noise;  // densities of each axis, SI
  Vector3d gyro_white, accel_white;  // and with what is fast of their flicker
  std::size_t gyro_source = 0, accel_source = 0;
  std::vector<NoiseSource> sources;
  std::vector<StateBlock> blocks;  // all but the first nine states
  Eigen::Index gyro_offset = 9, accel_offset = 12, gyro_matrix = -1, accel_matrix = -1, g_sensitivity = -1;
  Eigen::Index gyro_flicker = -1, accel_flicker = -1;  // beside the offsets
  const OutputTerms* terms = nullptr;                  // with states from terms_first on
  Eigen::Index terms_first = -1;
  Eigen::Index sensors_end = 15;  // of the states that the sensors' output depends on
  Eigen::Index size = 15;
  Eigen::MatrixXd joint = {};  // covariances at the start of two of them, besides the variances; empty: none
  std::vector<Channel> channels;
  std::vector<Observation> observations;  // by stamp
  /// The end of so many samples [s].
  double time_after(std::size_t count) const { return count > 0 ? time[count - 1] : begin; }
  double middle() const { return (begin + time.back()) / 2; }
  /// At which a delay counts: the middle, of the first ten minutes where it is longer. A drift of unknown size makes a delay of hours ago that of any
  /// time.
  double delay_time() const { return std::min(middle(), begin + 300); }
  double longest_step = 1;  // s: between two epochs
};

/// A navigation state and all other states (the first nine are zero).
struct FullState {
  NavigationState motion;
  Eigen::VectorXd x;
};

/// Where the filter starts: the mean before any data, and one standard deviation of all states.
struct FilterStart {
  FullState mean;
  Eigen::VectorXd sigma;
  std::size_t sample = 0;  // the state is that before it
};

/// The state with an error state added.
FullState plus(const FullState& state, const Eigen::VectorXd& error);
NavigationState plus(const NavigationState& state, const Eigen::Matrix<double, 9, 1>& error);
/// Latitude, longitude, height, and nothing else.
NavigationState at_place(const Vector3d& place);
/// The first nine of the error state that takes `from` to `to`.
Eigen::Matrix<double, 9, 1> minus(const NavigationState& to, const NavigationState& from);

/// The sample with the sensors' errors of `x` taken off.
Increment corrected(const Problem& problem, const TimedIncrement& sample, const Eigen::VectorXd& x);

/// How late an aid's stamps are there [s].
double delay_at(const Problem& problem, const Channel& channel, const Eigen::VectorXd& x, double stamp);

/// "gnss.slow_error" as people read it: "gnss slow error".
std::string in_words(std::string name);

/// Adds a block of states at the end.
Eigen::Index add_block(Problem& problem, StateBlock block);

}  // namespace imulab::aided
