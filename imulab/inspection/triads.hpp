// Which columns are the accelerometers and which the gyros: at rest the former measure gravity, and the latter turn it from one rest to the next.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/inspection/signals.hpp"
#include "imulab/recording.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab::inspection {

/// Indices of three signals: x, y, z.
using SignalTriad = std::array<std::size_t, 3>;

/// Three columns that may belong together, by their names or their places.
std::vector<SignalTriad> possible_triads(const SignalTable& table, const std::vector<std::size_t>& without);

/// The evidence for two triads in the data, if one is taken for the gyros and the other for the accelerometers; or for one of them alone.
struct TriadEvidence {
  SignalTriad gyro{}, accel{};
  bool has_gyro = true, has_accel = true;
  std::vector<Range> rests;
  double norm = 0, norm_least = 0, norm_most = 0;  ///< of the accelerometers' means at rest, their offsets taken out where they are large
  bool offset_taken_out = false;                   ///< the rests' means lie about a center far from zero, as unsigned counts do
  double norm_in_motion = 0;                       ///< spread of the norm while moving, part of the mean: a magnetometer's stays small
  std::vector<Vector3d> up;                        ///< unit vectors at the rests, in the accelerometers' axes
  std::size_t turns = 0;                           ///< between rests, of more than five degrees
  double turned = 0, error = 0;                    ///< RMS of their angles, and of what the gyros leave unexplained [rad]
  std::optional<Matrix3d> gyro_matrix;             ///< readings -> rad/s in the accelerometers' axes, where the turns determine it
  bool filtered = false;                           ///< the accelerometers' norm is alike in every reading: a filter's estimate of gravity
  std::size_t turning = 0;                         ///< quiet parts in which the unit turned steadily: no rests

  /// True if the gyros explain the turns: an error of a quarter is that of no triad, a true one leaves a few percent.
  bool explained() const { return !filtered && gyros_fit(); }
  bool gyros_fit() const { return turns >= 3 && gyro_matrix && error < 0.25 * turned; }
  /// The gyros' scale [rad/s per reading].
  double gyro_scale() const;
};

/// `time_ns`: of the rows. `possible_scales`: of the gyros [rad/s per reading], tried where the turns are about too few axes to determine a matrix.
/// At most the first `most` samples are used.
TriadEvidence evidence_for(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const SignalTriad& gyro, const SignalTriad& accel,
                           const std::vector<double>& possible_scales, std::size_t most = 1'000'000);

}  // namespace imulab::inspection
