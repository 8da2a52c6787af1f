// The table of methods. A new method is a folder beside these and one line in the table.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/estimate/turn_path.hpp"
#include "imulab/predict.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Throws Error that lists all options out of range: levels that are no probabilities, terms that are not in the table, requirements, times.
void validate(const CalibrationOptions& options);

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

/// A function of a method. Only `calibrate` and `predict` below call it: they check first what is common to all methods.
template <class Function>
class MethodFunction;
template <class Result, class... Arguments>
class MethodFunction<Result(Arguments...)> {
 public:
  constexpr MethodFunction() = default;
  constexpr MethodFunction(Result (*function)(Arguments...)) : function_(function) {}  // a row names a plain function
  constexpr explicit operator bool() const { return function_ != nullptr; }

 private:
  friend struct CheckedMethod;
  Result (*function_)(Arguments...) = nullptr;
};

/// A row of the table: everything that the rest of the program knows of a method.
struct Method {
  std::string_view name;       ///< "handheld"
  std::string_view summary;    ///< one line
  std::string_view reference;  ///< the paper, as docs/reference/grades.md has it
  std::string_view needs;      ///< besides a recording: of steps, site and rig
  int equipment = 0;           ///< by which methods are offered: the least first

  bool takes_accel_alone = false;  ///< recordings without gyros
  bool takes_several = false;      ///< recordings, each on its own; else they are joined to one
  bool takes_aids = false;         ///< records of the session's aids, which also tell the place
  bool takes_full = false, takes_stepwise = false, takes_curves = false;
  bool takes_runs = false;       ///< predictions by Monte Carlo, and the classical ones
  std::string_view second = {};  ///< the method that gives a second opinion on the same data; empty: none

  // Statements of a certificate.
  std::string_view test = {};  ///< by its usual name; empty: those of the session's machines
  std::string_view angle_source = "the angle between the directions of gravity before and after each turn";
  /// The origin of angles and rates: an instrument or none.
  enum class Instrument { none, where_declared, always } instrument = Instrument::none;

  /// Throws Error where declarations contradict each other or the data, Unsupported where nothing can be determined.
  MethodFunction<CalibrationResult(const CalibrationInput& input, const CalibrationOptions& options)> calibrate;
  /// Predicts a procedure; none where the method has no prediction. Throws Error where the procedure lacks what the method needs, and for a
  /// requirement on a coefficient that it does not estimate; TermsError as calibrate does.
  MethodFunction<Prediction(const Session& procedure, const PredictionOptions& options)> predict = {};
  /// Finds its own procedure; without functions where it cannot.
  PathPlanner plan = {};
  /// Null: a recording alone is not enough.
  MethodSupport (*support)(const RestEvidence& evidence) = nullptr;
  /// A procedure that the method can work on, for tests; null where no session is one.
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

/// Calibrates as the command does: checks the input (Error that lists all that is wrong with the session, the options, the rests and the recordings),
/// then the result in the way that is common to all methods (are scales and axes as declared?), and fills in its origin (add_declared_origin). Throws
/// as the method does, and Stopped. Several calibrations may run at the same time in different threads; each uses several (core/parallel.hpp).
CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options = {});

/// Throws Error that lists all that is wrong with the procedure and the options, where the method has no prediction, or neither gravity nor the
/// latitude is known; and as the method does. With restricted terms a note says what is taken as absent. Throws Stopped.
Prediction predict(const Method& method, const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab
