// Evaluates a procedure before any data: the uncertainty of each coefficient, what limits it, and the shortest path that meets requirements.
#pragma once

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/summary.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// As the method predicts, with a checkpoint that names the procedure and the options.
Prediction predicted(std::string_view method, const Session& procedure, PredictionOptions options);
/// `details`: first and second order and the Monte Carlo, with more digits.
std::string prediction_text(const Prediction& prediction, const std::vector<Requirement>& requirements, bool details = false);
/// HTML. `procedure`: its name. `required`: there were requirements.
std::string prediction_page(const Prediction& prediction, const std::string& procedure, bool required);
/// Why the procedure is not enough. Empty: it is.
std::string shortcomings(const Prediction& prediction);

struct PlanTask {
  std::vector<Requirement> requirements;
  std::string grade = "navigation";
  double latitude = 0;                 ///< rad
  std::optional<double> gravity = {};  ///< m/s^2, measured; absent: normal gravity
  std::vector<RigAxis> axes = {RigAxis::outer, RigAxis::middle, RigAxis::inner};
  bool by_hand = false;
  std::optional<double> time = {};            ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest = {};            ///< s, of every rest; absent: chosen
  std::optional<FleetPrior> prior = {};       ///< the prior from a fleet
  std::optional<Checkpoint> checkpoint = {};  ///< of processes that share the search
  std::function<void(double)> progress = {};  ///< 0 to 1
};

struct PlannedProcedure {
  std::vector<Requirement> requirements;
  hybrid::Path path;
  Session procedure;
  Prediction prediction;
  std::optional<PriorEffect> prior;
  bool timed = false;
};

/// Throws Error for requirements of coefficients that the method hybrid does not estimate, and where no turn fits into the time; Unsupported for a
/// requirement that no path can meet.
PlannedProcedure plan(const PlanTask& task);
std::string plan_json(const PlannedProcedure& planned);
std::string plan_text(const PlannedProcedure& planned);
std::string plan_page(const PlannedProcedure& planned);
std::string shortcomings(const PlannedProcedure& planned);

}  // namespace imulab
