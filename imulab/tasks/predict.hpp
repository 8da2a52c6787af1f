// Evaluates a procedure before any data: the uncertainty of each coefficient, and what limits it.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/fleet.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

struct PredictOptions : ShowOptions {
  std::string procedure, method = "turntable", terms = "auto", effects = "table", prior;
  std::optional<std::string> require;
  std::uint64_t runs = 20000, seed = 1;
  bool classical = false;
  SharingOptions shared;
};
/// The verb `predict`, which sets these.
Verb& declare(Verb& command, PredictOptions& o);

/// The prediction that these options ask for. Throws OptionError.
PredictionOptions task_of(const PredictOptions& o);

/// What a method predicts from.
struct ReadProcedure {
  Session session;
  std::shared_ptr<const motion::NominalMotion> motion = {};  ///< of a mission
  std::vector<std::string> warnings = {};
};
/// The mission as the procedure of a method with aids.
ReadProcedure procedure_of(const MissionFile& file, const std::string& name);
/// A procedure or session; for a method with aids a mission, whose [errors] declare the IMU. Throws as read_session and read_mission.
ReadProcedure read_procedure(const std::string& file, std::string_view method);

/// Predicts as the method of that name does, and gives `options.sharing` the identity of its work. `name`: of the procedure, on the page. `prior`: of
/// the unit's fleet. Throws OptionError for terms that the method does not know, and as `predict`.
AnswerOf<Prediction> prediction_answer(std::string_view method, const Session& procedure, const std::string& name, PredictionOptions options,
                                       const std::optional<FleetPrior>& prior = {});
/// The worst standard uncertainties, or what is not determined.
std::string prediction_headline(const Prediction& prediction);
/// By its requirements; a prediction that leaves coefficients undetermined is doubtful.
Conclusion conclusion_of(const Prediction& prediction, const std::vector<Requirement>& requirements);
/// `details`: first and second order and the Monte Carlo, with more digits.
std::string prediction_text(const Prediction& prediction, const std::vector<Requirement>& requirements, bool details = false);
/// Why the procedure is not enough. Empty: it is.
std::string shortcomings(const Prediction& prediction);

}  // namespace imulab
