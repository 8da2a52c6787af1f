// Every calibration method: one signature, one result, one table. A new method is a folder beside these and one line in the table.
#pragma once

#include "imulab/core/eigen.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/estimate/turn_path.hpp"
#include "imulab/model/calibration.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/procedure.hpp"

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
  bool second_opinion = false;          ///< compare with another method's estimate from the same data, where the data allow one
  bool effects = true;                  ///< what the sensor model lacks is estimated beside it (docs/effects.md); false: taken as absent

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

/// The rests and turns that inspection has found in a recording.
struct RestEvidence {
  std::size_t rests = 0, turns = 0;
  double determined = 0;   ///< of the nine accelerometer parameters, by the rests' directions
  bool explained = false;  ///< the gyros explain the turns
};
struct MethodSupport {
  bool supported = false;
  std::string why;
};

/// The session that `Method::example` makes. The defaults are a short one.
struct ExampleSize {
  HandHeldOptions by_hand = {.poses = 20};
  TableProcedureOptions on_table = {.rest = 15, .rate_hz = 20};
  DaiUnitOptions on_machines = {.record = 1};
  std::uint64_t seed = 1;
};

/// A row of the table: everything that the rest of the program knows of a method.
struct Method {
  std::string_view name;       ///< "handheld"
  std::string_view summary;    ///< one line
  std::string_view reference;  ///< the paper, as docs/references.md has it
  std::string_view needs;      ///< besides a recording: of steps, site and rig
  int equipment = 0;           ///< by which methods are offered: the least first

  bool takes_accel_alone = false;  ///< recordings without gyros
  bool takes_several = false;      ///< recordings, each on its own; else they are joined to one
  bool takes_full = false, takes_stepwise = false, takes_curves = false;
  bool takes_runs = false;       ///< predictions by Monte Carlo, and the classical ones
  std::string_view second = {};  ///< the method that gives a second opinion on the same data; empty: none

  // Statements of a certificate.
  std::string_view test = {};  ///< by its usual name; empty: those of the session's machines
  std::string_view angle_source = "the angle between the directions of gravity before and after each turn";
  /// The origin of angles and rates: an instrument or none.
  enum class Instrument { none, where_declared, always } instrument = Instrument::none;

  /// Throws Error where declarations contradict each other or the data, Unsupported where nothing can be determined.
  CalibrationResult (*calibrate)(const CalibrationInput& input, const CalibrationOptions& options);
  /// Predicts a procedure; null where the method has no prediction. Throws Error where the procedure lacks what the method needs, and for a
  /// requirement on a coefficient that it does not estimate; TermsError as calibrate does.
  Prediction (*predict)(const Session& procedure, const PredictionOptions& options) = nullptr;
  /// Finds its own procedure; without functions where it cannot.
  PathPlanner plan = {};
  /// Null: a recording alone is not enough.
  MethodSupport (*support)(const RestEvidence& evidence) = nullptr;
  /// A procedure that the method can work on, for tests.
  Session (*example)(const ExampleSize& size) = nullptr;
};

/// All methods, by name.
std::span<const Method> methods();
/// Throws Error that lists the known ones.
const Method& method(std::string_view name, std::span<const Method> table = methods());
/// Null where there is none of this name.
const Method* find_method(std::string_view name, std::span<const Method> table = methods());
/// The least equipment first.
std::vector<Method> methods_by_equipment();
/// The one that plans its own procedure.
const Method& planning_method();
/// The methods with a capability: "hybrid", or several with commas.
std::string names_of_methods(bool Method::*capability);

/// Calibrates, and checks the result in the way that is common to all methods: are scales and axes as declared? Throws as the method does.
CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options = {});
/// By a method's name.
CalibrationResult calibrate(std::string_view method, const CalibrationInput& input, const CalibrationOptions& options = {});

/// Throws Error where the method has no prediction, or neither gravity nor the latitude is known; and as the method does.
Prediction predict(const Method& method, const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab
