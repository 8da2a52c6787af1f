// Calibrates a session: reads its recordings, runs the method, and fills in the origin of the result. Shared by the command and the Python module.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/fleet.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

struct CalibrateOptions : ShowOptions {
  std::string session, method, terms = "auto", effects = "table", recording, curves, prior;
  std::optional<std::string> require, reference, reference_calibration;
  std::vector<std::string> more, declarations, topics;
  bool stepwise = false;
};
/// The verb `calibrate`, which sets these.
Verb& declare(Verb& command, CalibrateOptions& o);

struct CalibrationTask {
  std::string method;
  std::string terms = "auto";  ///< "auto", "full" (whole-unit), or selectors separated by commas
  bool effects = true;         ///< as CalibrationOptions has it
  bool stepwise = false;       ///< whole-unit
  bool curves = false;         ///< hybrid: convergence curves
  std::vector<Requirement> requirements = {};
  std::optional<ReferenceImu> reference = {};  ///< of a method that takes one
  std::optional<FleetPrior> prior = {};        ///< the prior from a fleet: the result is then in the accelerometers' frame
  std::function<void(double)> progress = {};   ///< as CalibrationOptions has it
};

/// The names of all methods, or of those that `offered` accepts.
std::vector<std::string> offered_methods(bool (*offered)(const Method& method) = nullptr);

/// The task that these options ask for; reads the prior. Throws OptionError for what is wrong, or not of the method.
CalibrationTask task_of(const CalibrateOptions& o);
/// The prior of the fleet whose store is in this file; none for an empty name.
std::optional<FleetPrior> read_prior(const std::string& store);

/// The option --effects of a verb.
VerbOption& effects_option(Verb& verb, std::string& effects);

/// The coefficients of selectors separated by commas; none of "auto" and "full". Throws Error for an unknown one.
std::vector<CoefficientIndex> parse_terms(std::string_view terms);

struct SessionRecordings {
  Session session;  ///< with the recordings below alone, and their steps
  std::vector<Recording> recordings;
  std::vector<std::string> warnings;  ///< from reading them
};

/// Reads the recordings of a session that a method uses: all of them, or the one named `chosen`; the only one where it takes one. Throws Error as
/// read_recording does, and where the caller has to choose one. `several_imus`: the recordings may be of several.
SessionRecordings read_recordings(Session session, const std::string& chosen = "", bool several_imus = false);

/// Recordings from memory, one for each of the session's, as declared_session takes them. A session without recordings takes them as they are,
/// temperatures in degC.
SessionRecordings given_recordings(Session session, std::vector<Recording> recordings);

/// Throws Error where the session has neither gravity nor a latitude, unless the method's aids tell the place.
void expect_gravity(const Session& session, const Method& method);

/// Calibrates; reads the aids of a method that takes them. The result has the requirements' answers. Throws Error for a task that the method does
/// not know (TermsError for its terms), and as the method does.
CalibrationResult calibrate(const SessionRecordings& data, const CalibrationTask& task);

/// Recordings of an IMU, and its result.
struct CalibratedImu {
  std::shared_ptr<const SessionRecordings> data;
  CalibrationResult result;
};
/// Calibrates for an answer: the calibration also has its options; `from_files` adds the files' hashes. Throws OptionError for terms that the method
/// does not know.
CalibratedImu calibrated_imu(const std::shared_ptr<const SessionRecordings>& data, const CalibrateOptions& o, const CalibrationTask& task,
                             bool from_files);
/// The warnings of reading are in front of the calibration's own, which are those of the answer.
AnswerOf<CalibrationResult> calibration_answer(CalibratedImu imu);

/// Improves good results of several IMUs, by name, by the motion that they have in common; a note says so, or what is in the way. Returns how many it
/// improved. The results of methods with aids or a rig, whose errors the IMUs share, and of several recordings of an IMU stay as they are.
std::size_t estimate_jointly(const std::vector<std::pair<std::string, CalibratedImu*>>& imus, const std::function<void(double)>& progress = {});

/// Why the result does not meet the request: not converged, coefficients not determined, requirements not reached. Empty: it is.
std::string shortcomings(const CalibrationResult& result);

/// The result as a page (HTML), with pictures from the recordings.
std::string calibration_page(const CalibrationResult& result, const SessionRecordings& data);

}  // namespace imulab
