// Calibration by any method: "handheld", "static", "hybrid", "turntable", "whole-unit" or "drive".
//
// Example:
//   const CalibrationResult result = calibrate("handheld", {session, {&recording, 1}});
//   if (result.calibration.quality.verdict == Verdict::good) write_calibration("calibration.json", result.calibration);
//
// Tedaldi 2014 (handheld), Cheng 2014 (hybrid, static), Zhang 2010 (turntable), Dai 2011 (whole-unit): docs/reference/grades.md, and a page in
// docs/ on each method. Every uncertainty is one sigma of what the data and the declared errors leave open. Throws Error for input that is wrong (an
// unknown method, a session or recording that `validate` refuses, too few rests of a declared kind), Unsupported where the data determine nothing.
// What is wrong with the unit, the rig or the declarations is in `Quality`, as a doubt with its cause. Time is linear in the number of samples.
// Several calibrations may run at a time; `progress` may come from any thread.
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

/// The input of a method. Values in SI, or in counts where the recording says so. It has a copy of the session, but not of the recordings, which can
/// be large: they have to outlive it.
struct CalibrationInput {
  Session session;                               ///< the declarations: IMU, site, rigs, steps; aids with their records
  std::span<const Recording> recordings;         ///< one for each of the session's, in its order; any where the session declares none
  std::optional<std::vector<Range>> rests = {};  ///< of the only recording, in time order; absent: the session's holds, or found in the data
};

struct CalibrationOptions {
  std::vector<CoefficientIndex> terms = {};  ///< to estimate; empty: all of the method's, optional ones where the data show them
  double significance = 0.01;                ///< an optional term is kept if chance explains it with at most this probability
  double outlier_level = 1e-3;               ///< probability of dropping anything from good data
  bool second_opinion = true;  ///< compare with another method's estimate from the same data, where the data allow one; not without effects
  bool effects = true;         ///< what the sensor model lacks is estimated beside it (docs/theory/effects.md); false: taken as absent

  struct Handheld {
    std::vector<Requirement> requirements = {};  ///< required uncertainties: if they are not met, the result names the missing turns
    std::size_t advised_turns = 3;               ///< at most this number of them, up to 100
    double rest_s = 4;                           ///< of a future rest
  } handheld = {};
  struct Turntable {
    bool bias_while_turning = false;  ///< the gyros' bias in turns is a separate unknown, and W0 is that of the holds alone, as Zhang estimates it
  } turntable = {};
  struct Hybrid {
    double curve_interval = 0;  ///< s between points of the convergence curves; 0: none
  } hybrid = {};
  struct WholeUnit {
    bool full = false;      ///< all that the data determine, significant or not
    bool stepwise = false;  ///< Dai's three steps instead of the joint estimate
  } whole_unit = {};

  /// Called with the fraction done, from 0 to 1, which never falls. The number of iterations is not known in advance: between 0 and 1 it is an
  /// estimate.
  std::function<void(double)> progress = {};
  std::stop_token stop = {};  ///< asked between iterations: `calibrate` throws Stopped within about a second of a request (stop.hpp)
};

/// Residual of the coarse solution from the data so far, and its standard uncertainty (hybrid).
struct ConvergenceCurve {
  std::string name = {};  ///< of the coefficient it corrects
  std::vector<double> residual, sigma;
};

/// A turn by hand from one rest to the next: about `axis` (body axes, right-handed) by `angle` [rad], until `up` (body axes) points up.
struct HandTurn {
  Eigen::Vector3d axis, up;
  double angle = 0;
};

struct CalibrationResult {
  Calibration calibration;
  std::optional<SensorModel> coarse = {};  ///< the start of the fit, if that is a result of its own (hybrid: Cheng 2014 table 1)
  std::vector<double> curve_time = {};     ///< s of the recording's clock
  std::vector<ConvergenceCurve> curves = {};
  int iterations = 0;
  std::vector<HandTurn> missing_turns = {};  ///< that would help most, in their order, each with a rest after it (handheld)
};

/// The methods, the one with the least equipment first: "handheld", "static", ... (docs/README.md has a page on each).
std::vector<std::string_view> method_names();

/// Calibrates, and checks the result in the way that is common to all methods: are scales and axes as declared? Throws Error where declarations
/// contradict each other or the data, and for an unknown method, Unsupported where nothing can be determined.
CalibrationResult calibrate(std::string_view method, const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace imulab
