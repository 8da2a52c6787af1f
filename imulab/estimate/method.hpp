// The table of methods. A new method is a folder next to these and one row in the table.
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

/// Throws Error that lists all options out of range: levels that are not probabilities, unknown terms, requirements, times.
void validate(const CalibrationOptions& options);

/// Rests and turns that the inspection of a recording found.
struct RestEvidence {
  std::size_t rests = 0, turns = 0;
  double determined = 0;   ///< number of determined parameters among the nine of the accelerometers, from the directions of the rests
  bool explained = false;  ///< the gyros explain the turns
  bool sweep = false;      ///< one attitude at many temperatures
};
struct MethodSupport {
  bool supported = false;
  std::string why;
};

/// Sizes of the session from `Method::example`; the default is short.
struct ExampleSize {
  HandHeldOptions by_hand = {.poses = 20};
  TableProcedureOptions on_table = {.rest = 15, .rate_hz = 20};
  DaiUnitOptions on_machines = {.record = 1};
  std::uint64_t seed = 1;
};

/// A function of a method. Only `calibrate` and `predict` below call it, after the common checks.
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

/// A row of the table, with all information about a method.
struct Method {
  std::string_view name;       ///< "handheld"
  std::string_view summary;    ///< one line
  std::string_view reference;  ///< paper, as in docs/reference/grades.md
  std::string_view needs;      ///< steps, site and rig, in addition to a recording
  int equipment = 0;           ///< rank in offers of methods: least equipment first

  bool takes_accel_alone = false;  ///< accepts recordings without gyros
  bool takes_several = false;      ///< processes several recordings separately; otherwise they are joined
  bool takes_aids = false;         ///< uses records of the session's aids, which also determine the place
  bool takes_reference = false;    ///< compares with a better IMU on the same body, which also knows gravity
  bool takes_full = false, takes_stepwise = false, takes_curves = false;
  bool takes_runs = false;       ///< predicts by Monte Carlo and by the classical model
  std::string_view second = {};  ///< method for a second opinion on the same data; empty: none

  // Statements for a certificate.
  std::string_view test = {};  ///< usual name; empty: determined by the session's machines
  std::string_view angle_source = "the angle between the directions of gravity before and after each turn";
  /// Whether an instrument is the origin of angles and rates.
  enum class Instrument { none, where_declared, always } instrument = Instrument::none;

  /// Calibrates. Throws Error if declarations contradict each other or the data, and Unsupported if nothing can be determined.
  MethodFunction<CalibrationResult(const CalibrationInput& input, const CalibrationOptions& options)> calibrate;
  /// Predicts a procedure; absent if the method has no prediction. Throws Error if the procedure lacks something that the method needs, or the method
  /// does not estimate a required coefficient; TermsError like calibrate.
  MethodFunction<Prediction(const Session& procedure, const PredictionOptions& options)> predict = {};
  /// Plans its own procedure; without functions if it cannot.
  PathPlanner plan = {};
  /// Returns whether a recording supports the method; null: a recording alone is insufficient.
  MethodSupport (*support)(const RestEvidence& evidence) = nullptr;
  /// Returns a procedure for the method, for tests; null if there is none.
  Session (*example)(const ExampleSize& size) = nullptr;
};

/// Returns all methods, by name.
std::span<const Method> methods();
/// Returns the method with this name; throws Error with the known names.
const Method& method(std::string_view name, std::span<const Method> table = methods());
/// Returns the method with this name, or null.
const Method* find_method(std::string_view name, std::span<const Method> table = methods());
/// Returns the methods, the one with the least equipment first.
std::vector<Method> methods_by_equipment();
/// Returns the method that plans its own procedure.
const Method& planning_method();
/// Returns the names of methods with a capability: "hybrid", or several with commas.
std::string names_of_methods(bool Method::*capability);

/// Calibrates like the command: checks the input (Error with all faults of the session, the options, the rests and the recordings), then the result
/// by the checks common to all methods (scales and axes as declared), and fills in its origin (add_declared_origin). Throws as the method does, and
/// Stopped. Several calibrations may run in different threads; each uses several threads (core/parallel.hpp).
CalibrationResult calibrate(const Method& method, const CalibrationInput& input, const CalibrationOptions& options = {});

/// Predicts. Throws Error with all faults of the procedure and the options, if the method has no prediction, or if neither gravity nor the latitude
/// is known; also as the method does. With restricted terms, a note names absent terms. Throws Stopped.
Prediction predict(const Method& method, const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab
