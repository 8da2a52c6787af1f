// From one epoch to the next: the strapdown integration of the samples between them, and what it makes of errors and noise.
#pragma once

#include "imulab/navigation/aided/problem.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace imulab::aided {

using Matrix9 = Eigen::Matrix<double, 9, 9>;
using NineRows = Eigen::Matrix<double, 9, Eigen::Dynamic>;

/// The first nine error states at the end are `motion` times those before it and the sensors' errors, and noise of covariance `gyro` + `accel`. The
/// other states follow their own laws: x <- decay x + noise of variance `driven`.
struct Transition {
  NineRows motion;                                          // as many columns as the sensors' last state
  Matrix9 gyro = Matrix9::Zero(), accel = Matrix9::Zero();  // with factors of 1
  Eigen::VectorXd decay, driven;                            // of all states; 1 and 0 for the first nine; with factors of 1
  double interval = 0;                                      // s
};

/// Integrates samples `begin` to `end` (not included) from `start` on; `each`, where given, gets the state after each sample.
struct Integrated {
  NavigationState end;
  Transition transition;
};
Integrated integrate(const Problem& problem, std::size_t begin, std::size_t end, const FullState& start, bool with_transition,
                     std::vector<NavigationState>* each = nullptr);

/// F P F^T + Q.
Eigen::MatrixXd propagated(const Problem& problem, const Transition& transition, const Eigen::MatrixXd& covariance);
/// D X D of a matrix over all states, D their own laws; 1 for the first nine.
void decay_slow(const Transition& transition, Eigen::MatrixXd& both);
/// F x.
Eigen::VectorXd propagated_mean(const Transition& transition, const Eigen::VectorXd& x);
/// Q: the first nine as a matrix, the variances of the others.
Matrix9 motion_noise(const Problem& problem, const Transition& transition);
Eigen::VectorXd slow_noise(const Problem& problem, const Transition& transition);

}  // namespace imulab::aided
