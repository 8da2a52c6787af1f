// Evaluates a procedure before any data: the uncertainty of each coefficient, what limits it, and the shortest path that meets requirements.
#pragma once

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/summary.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct PredictionTask {
  std::string method = "turntable";
  std::vector<CoefficientIndex> terms = {};  ///< as CalibrationOptions has them
  std::vector<Requirement> requirements = {};
  std::uint64_t runs = 20000;  ///< of the Monte Carlo (turntable); 0: none
  std::uint64_t seed = 1;
  bool classical = false;                     ///< turntable: as turntable::Plan has it
  std::function<void(double)> progress = {};  ///< told about which part is done, 0 to 1; from any thread
  std::optional<Checkpoint> checkpoint = {};  ///< of the Monte Carlo
};

struct PredictedProcedure {
  Prediction prediction;
  std::vector<Shortfall> missed;         ///< requirements
  std::optional<hybrid::Advice> advice;  ///< hybrid: the turns that help most, where something is missed
  /// Further results of the method turntable.
  struct OnTurntable {
    turntable::Plan plan;
    turntable::Prediction prediction;
    std::optional<turntable::MonteCarloResult> monte_carlo;
    std::vector<KnobAnswer> answers;  ///< to the requirements
  };
  std::optional<OnTurntable> on_turntable;
  std::uint64_t runs = 0;
  bool required = false;
};

/// Throws Error as the method's prediction does, and where a requirement is of a coefficient that the method does not
/// estimate.
PredictedProcedure predict(const Session& procedure, const PredictionTask& task);
std::string prediction_json(const PredictedProcedure& predicted);
std::string prediction_text(const PredictedProcedure& predicted, const std::vector<Requirement>& requirements, bool details = false);
/// HTML. `procedure`: its name.
std::string prediction_page(const PredictedProcedure& predicted, const std::string& procedure);
/// Why the procedure is not enough. Empty: it is.
std::string shortcomings(const PredictedProcedure& predicted);

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
  std::vector<Shortfall> missed;
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
