// Calibrates an IMU by one of the methods "handheld", "static", "hybrid", "turntable", "whole-unit" and "drive".
//
// Example:
//   const CalibrationResult result = calibrate("handheld", {session, {&recording, 1}});
//   if (result.calibration.quality.verdict == Verdict::good) write_calibration("calibration.json", result.calibration);
//
// Methods: Tedaldi 2014 (handheld), Cheng 2014 (hybrid, static), Zhang 2010 (turntable), Dai 2011 (whole-unit); docs/reference/grades.md lists
// the papers, and docs/ has a page on each method. Every uncertainty is one sigma and covers the data and the declared errors. Calibration throws
// Error if the input is wrong (unknown method, invalid session or recording, too few rests of a declared kind) and Unsupported if the data determine
// no coefficient. `Quality` lists faults of the unit, the rig or the declarations as doubts with their cause. The time is linear in the number of
// samples. Several calibrations may run at the same time; `progress` may be called from any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The input of a method. Readings are in SI units, or in counts if the recording states so. The session is copied. The recordings, which can be
/// large, are not: they must outlive the input.
struct CalibrationInput {
  Session session;                        ///< declarations of IMU, site, rigs and steps; aids with their records
  std::span<const Recording> recordings;  ///< one for each recording of the session, in its order; any number if the session declares none
  /// The rests of the only recording, in time order; absent: the holds of the session, or rests found in the data.
  std::optional<std::vector<Range>> rests = {};
};

/// The better IMU of the method reference, whose recording is among those of the input.
struct ReferenceImu {
  std::string imu;                           ///< name in the session's recordings
  std::optional<Calibration> calibration{};  ///< its calibration, with the covariance that it is used with
  std::string grade = "navigation";          ///< sizes of its errors without a calibration
};

struct CalibrationOptions {
  /// Coefficients to estimate; empty: all coefficients of the method, the optional ones if they are significant.
  std::vector<CoefficientIndex> terms = {};
  double significance = 0.01;   ///< an optional term is kept if its p-value is at most this level
  double outlier_level = 1e-3;  ///< probability of rejecting any part of good data
  /// Compares the result with another method's estimate from the same data if they support one; requires `effects`.
  bool second_opinion = true;
  /// Estimates effects beyond the sensor model jointly with the coefficients (docs/theory/effects.md); false: assumes that there are none.
  bool effects = true;

  struct Handheld {
    std::vector<Requirement> requirements = {};  ///< required uncertainties; if they are not met, the result lists further turns
    std::size_t advised_turns = 3;               ///< largest number of such turns, at most 100
    double rest_s = 4;                           ///< duration of a future rest [s]
  } handheld = {};
  struct Turntable {
    /// The gyro bias during turns becomes a separate unknown, and W0 is the bias in the holds only, as in Zhang 2010.
    bool bias_while_turning = false;
  } turntable = {};
  struct Hybrid {
    double curve_interval = 0;  ///< interval between points of the convergence curves [s]; 0: no curves
  } hybrid = {};
  struct WholeUnit {
    bool full = false;      ///< estimates all coefficients that the data determine, significant or not
    bool stepwise = false;  ///< uses Dai's three steps instead of the joint estimate
  } whole_unit = {};

  std::optional<ReferenceImu> reference = {};  ///< of the method reference

  /// Called with the fraction done, from 0 to 1, which never decreases. Values in between are estimates because the number of iterations is unknown.
  std::function<void(double)> progress = {};
  std::stop_token stop = {};  ///< checked between iterations: `calibrate` throws Stopped within about 1 s of a request (stop.hpp)
};

/// Hybrid method: residual error of the coarse solution, estimated from the data up to each time, and its standard uncertainty. Method reference:
/// what an offset in a window of time departs from that of the result.
struct ConvergenceCurve {
  std::string name = {};  ///< name of the corrected coefficient
  std::vector<double> residual, sigma;
};

/// A turn by hand from one rest to the next about `axis` (body axes, right-handed) by `angle` [rad]; afterwards `up` (body axes) points up.
struct HandTurn {
  Eigen::Vector3d axis, up;
  double angle = 0;
};

struct CalibrationResult {
  Calibration calibration;
  std::optional<SensorModel> coarse = {};  ///< start of the fit, if it is a result of its own (hybrid: Cheng 2014 table 1)
  std::vector<double> curve_time = {};     ///< times of the curves' points [s], on the recording's clock
  std::vector<ConvergenceCurve> curves = {};
  int iterations = 0;
  std::vector<HandTurn> missing_turns = {};  ///< handheld: most useful further turns in order, each followed by a rest
};

/// Returns the names of the methods, the one that needs the least equipment first (docs/README.md lists a page on each).
std::vector<std::string_view> method_names();

/// Calibrates by `method` (one of `method_names`) and checks whether scales and axes are as declared. `input`: session with declarations, recordings,
/// and optionally rests; `options`: terms, levels and settings of the methods. Throws Error if the method is unknown or declarations contradict each
/// other or the data, and Unsupported if the data determine nothing.
CalibrationResult calibrate(std::string_view method, const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace imulab
