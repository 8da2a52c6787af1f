// Every calibration method: one signature, one result, one table. A new method is a folder beside these and one line in the table.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The input of a method. Values in SI, or in counts where the recording says so.
struct CalibrationInput {
  const Session& session;                        ///< the declarations: IMU, site, rigs, steps
  std::span<const Recording> recordings;         ///< one for each of the session's, in its order
  std::optional<std::vector<Range>> rests = {};  ///< of the only recording, in time order; absent: the session's holds, or found in the data
};

struct CalibrationOptions {
  std::vector<CoefficientIndex> terms;  ///< to estimate; empty: all of the method's, optional ones where the data show them
  double significance = 0.01;           ///< an optional term is kept if chance explains it with at most this probability
  double outlier_level = 1e-3;          ///< probability of dropping anything from good data

  struct Handheld {
    std::vector<Requirement> requirements = {};  ///< required uncertainties: if they are not met, the result names the missing turns
    std::size_t advised_turns = 3;               ///< at most this number of them
    double rest_s = 4;                           ///< of a future rest
  } handheld;
  struct Turntable {
    bool bias_while_turning = false;  ///< the gyros' bias in turns is a separate unknown, and W0 is that of the holds alone, as Zhang estimates it
  } turntable;
  struct Hybrid {
    double curve_interval = 0;  ///< s between points of the convergence curves; 0: none
  } hybrid;
  struct WholeUnit {
    bool full = false;      ///< all that the data determine, significant or not
    bool stepwise = false;  ///< Dai's three steps instead of the joint estimate
  } whole_unit;

  std::function<void(double)> progress = {};  ///< called with the fraction done, 0 to 1, if the method knows it
};

/// Residual of the coarse solution from the data so far, and its standard uncertainty (hybrid).
struct ConvergenceCurve {
  std::string name;  ///< of the coefficient it corrects
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

/// Predicted standard uncertainties, before any data. SI.
struct Prediction {
  std::vector<CoefficientIndex> coefficients, undetermined;
  Eigen::VectorXd sigma;                          ///< of each of `coefficients`
  Eigen::VectorXd cramer_rao;                     ///< Cramer-Rao bound
  Eigen::VectorXd remaining = {};                 ///< sigma of each of `undetermined`; empty: not known
  std::vector<CoefficientIndex> considered = {};  ///< of `coefficients`: the procedure does not show them; their prior enters the others
  std::vector<std::string> notes = {};            ///< why something is not calibrated
  std::string frame = "accelerometers";           ///< of the calibration to come: that, or "rig"
};

/// Of a calibration of ideal readings.
Prediction prediction_of(const Calibration& calibration);

/// In the order of the requirements: the coefficients that exceed them, each once; sigma is infinite where one is not determined. Those that the
/// accelerometers' frame fixes at zero are left out.
std::vector<Shortfall> shortfalls(const Prediction& prediction, const std::vector<Requirement>& requirements);

struct Method {
  std::string_view name;       ///< "handheld"
  std::string_view summary;    ///< one line
  bool takes_several = false;  ///< recordings; else it throws Error for more than one
  bool takes_full = false, takes_stepwise = false, takes_curves = false;
  /// Throws Error where declarations contradict each other or the data, Unsupported where nothing can be determined.
  CalibrationResult (*calibrate)(const CalibrationInput& input, const CalibrationOptions& options);
  /// Of a procedure with one recording, of a calibration with these CalibrationOptions::terms; null where the method has no prediction. Throws Error
  /// where the procedure lacks what the method needs, TermsError as calibrate does.
  Prediction (*predict)(const Session& procedure, const std::vector<CoefficientIndex>& terms) = nullptr;
};

/// All methods, by name.
std::span<const Method> methods();
/// Throws Error that lists the known ones.
const Method& method(std::string_view name, std::span<const Method> table = methods());

/// Calibrates, and checks the result in the way that is common to all methods: are scales and axes as declared? Throws as the method does.
CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options = {});
/// By a method's name.
CalibrationResult calibrate(std::string_view method, const CalibrationInput& input, const CalibrationOptions& options = {});

}  // namespace imulab
