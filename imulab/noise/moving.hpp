// Where the factor between the noise of a log at rest and that of a filter in motion comes from: causes, each with an equation.
//
// N, B, K and the density Q(f) are those at rest, S(f) is the density of the moving log (two-sided), T the sampling interval, m the bias instability
// (the minimum of the Allan deviation). F multiplies the parameter in parentheses; the quiet log's K is its bound if it is not determined.
//
//   white (N)           F_w^2 = mean of S / Q in the bands without lines and resonances                                                    (1)
//   vibration (N)       F_v^2 = 1 + T V / (F_w N)^2,  V = 2 integral (S - F_w^2 Q) df above f_v: the variance of a reading                 (2)
//   below 1 Hz (N)      F_l^2 = mean of S / Q below 1 Hz, which accumulates in angle and velocity                                          (3)
//   stamps (N)          F_s^2 = 1 + T s^2 D / (F_w N)^2,  s: RMS of the stamps about an even clock,
//                       D = 2 integral (2 pi f)^2 (S - F_w^2 Q) df: the mean square of the derivative of the readings                      (4)
//   rectification (bias) F_r^2 = 1 + (d^2 - u^2) / m^2,  d: change of the mean at the same attitude, u: its standard uncertainty           (5)
//   drift (K)           F_d^2 = max(1, (c^2 - w^2 - b B^2) / (a K^2)),  c: change over the log, w^2: its variance by white noise           (6)
//   all (N)             F^2 = F_w^2 (F_v^2 + F_s^2 - 1), or the square of the factor of motion if that is larger                           (7)
//   motion (N)          F_m^2 = r^2 / (2 N^2 t + 4 n^2 / (g^2 R)),  r: RMS tilt by which the gyros miss gravity after a rotation, t: mean length of a
//                       rotation, n: N of the accelerometers, R: mean length of a rest                                                     (8)
//
// f_v is 1 Hz at rest. In motion it is 10 Hz, or a quarter of the rate: below, motion and vibration cannot be separated. At rest c is the slope of a
// line through the log times its length L: w^2 = 12 (F_w N)^2 / L, b = 9 / pi, a = 6 L / 5. In motion it is the difference between the means of the
// first and the last rest, of lengths L1 and L2, at a distance a: w^2 = N^2 / L1 + N^2 / L2, b = 4 ln 2 / pi.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/noise.hpp"
#include "imulab/recording.hpp"

#include <map>
#include <string>
#include <vector>

namespace imulab {

/// What one log or result contributes: causes of each axis that it has in common with the log at rest.
struct MovingEvidence {
  std::string file;              ///< with what it is
  std::vector<MovingAxis> axes;  ///< without totals
  std::vector<std::string> warnings = {};
  /// Of a log: the densities that it and the log at rest permit, of each axis whose bound it raises.
  std::map<std::string, std::vector<UpperDensity>> upper = {};
};

/// Evidence of a log with vibration at the place of the log at rest, or in motion. Throws Unsupported if it has less than 30 s without a gap, or
/// scatters less than the log at rest; throws Error for another rate, other units or no triad in common.
MovingEvidence moving_log(const NoiseAnalysis& rest, Recording recording);

/// Evidence of a calibration by hand: its rotations from rest to rest, each predicted without it, against the white noise at rest (8). Throws
/// Unsupported if it has none, Error for noise in counts.
MovingEvidence moving_calibration(const NoiseAnalysis& rest, const Calibration& calibration, const std::string& file);

/// Of each cause the largest factor, and what the filter should use (7).
MovingNoise moving_noise(const NoiseAnalysis& rest, const std::vector<MovingEvidence>& evidence);

/// Makes each axis's bound one above the densities of the logs in motion, too.
void raise_bounds(NoiseAnalysis& rest, const std::vector<MovingEvidence>& evidence);

}  // namespace imulab
