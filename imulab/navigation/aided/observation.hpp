// The table of aids: the predicted reading of each kind in a given state, its derivatives by all states, and its noise. No kind occurs in the filter.
//
//   GNSS position   z = p + C l - dt (v + C (w_eb x l))
//   GNSS velocity   z = v + C (w_eb x l) - dt (a + C (w_eb x (w_eb x l) + w_eb' x l))
//   vehicle         (C_vb (C_bn v + w_eb x l))_right,up + slip = 0
//   wheels          z = (1 + s) (C_vb (C_bn v + w_eb x l))_forward - dt (1 + s) (C_vb C_bn a)_forward + e
//   barometer       z = h + (C l)_up - dt v_up + b
//   heading         z = heading of the forward axis + dt (C w_eb)_up + b
//   zero velocity   0 = v,  0 = w_ib - C_bn w_ie
#pragma once

#include "imulab/navigation/aided/problem.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::aided {

/// The computed motion at an epoch, as input of the aids.
struct Instant {
  FullState state;
  double time = 0;               // s
  Vector3d rate_ib;              // corrected, body axes [rad/s], a mean over 2 half_instant
  Vector3d rate_eb;              // relative to the Earth
  Vector3d turning;              // angular acceleration, body axes [rad/s^2], between the means of the halves of that time
  Vector3d acceleration;         // east-north-up [m/s^2]
  Vector3d raw_rate, raw_force;  // including the sensors' errors
  std::size_t sample = 0;        // last sample before it
};

/// Rows of one observation: measured minus computed, derivatives of the computed value by the error state, variances for a factor of 1.
struct ObservedRows {
  Eigen::VectorXd residual;
  Eigen::MatrixXd derivative;
  Eigen::VectorXd variance;
  std::vector<std::size_t> source;  // noise source of each row
};

/// A row of the table.
struct AidLaw {
  AidKind kind;
  std::string_view name;
  double position_sigma, velocity_sigma, value_sigma;  // defaults if neither the aid nor its record states a sigma: m, m/s, or the kind's own unit
  ObservedRows (*observe)(const Problem& problem, const Channel& channel, const Observation& observation, const Instant& instant);
};
const AidLaw& aid_law(AidKind kind);

/// Returns the sigma that the record states, or else the aid's, or else the kind's.
Vector3d position_sigma(const Aid& aid, std::size_t row);
Vector3d velocity_sigma(const Aid& aid, std::size_t row);
double value_sigma(const Aid& aid, std::size_t row);

/// Returns the rotation from body axes to vehicle axes: mounting angles about right and up [rad].
Matrix3d mounting(const Problem& problem, const Channel& channel, const Eigen::VectorXd& x);

/// Returns the instant after sample `end - 1`, with the given state.
Instant instant_at(const Problem& problem, std::size_t end, const FullState& state);

/// Returns the measured rows of an observation by the law of its kind.
ObservedRows observe(const Problem& problem, const Observation& observation, const Instant& instant);

}  // namespace imulab::aided
