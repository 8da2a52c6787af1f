// The transition between epochs: strapdown integration of the samples, and propagation of errors and noise.
#pragma once

#include "imulab/navigation/aided/problem.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace imulab::aided {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using NineRows = Eigen::Matrix<double, 9, Eigen::Dynamic>;

/// The first nine error states at the end are `motion` times those before it and the sensors' errors, plus noise of covariance `gyro` + `accel`.
/// Other states follow their own laws: x <- decay x + noise of variance `driven`.
struct Transition {
  NineRows motion;                                          // columns up to the sensors' last state
  Matrix9 gyro = Matrix9::Zero(), accel = Matrix9::Zero();  // for factors of 1
  Eigen::VectorXd decay, driven;                            // decay and driven variance of all states; 1 and 0 for the first nine; for factors of 1
  double interval = 0;                                      // s
  std::size_t motion_kind = 0;                              // index of motion_kinds
};

/// Integrates samples `begin` to `end` (exclusive) from `start`; `each`, if given, receives the state after each sample.
struct Integrated {
  NavigationState end;
  Transition transition;
};
Integrated integrate(const Problem& problem, std::size_t begin, std::size_t end, const FullState& start, bool with_transition,
                     std::vector<NavigationState>* each = nullptr);

/// Returns F P F^T + Q.
Eigen::MatrixXd propagated(const Problem& problem, const Transition& transition, const Eigen::MatrixXd& covariance);
/// Replaces a matrix X over all states by D X D, with D their own laws (1 for the first nine).
void decay_slow(const Transition& transition, Eigen::MatrixXd& both);
/// Returns F x.
Eigen::VectorXd propagated_mean(const Transition& transition, const Eigen::VectorXd& x);
/// Return Q: a matrix for the first nine states, variances of the others.
Matrix9 motion_noise(const Problem& problem, const Transition& transition);
Eigen::VectorXd slow_noise(const Problem& problem, const Transition& transition);

}  // namespace imulab::aided
