// Results of verbs as values that their JSON gives back, for reports.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/compare.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/noise.hpp"
#include "imulab/plan.hpp"
#include "imulab/predict.hpp"
#include "imulab/results/aided.hpp"
#include "imulab/results/comparison.hpp"
#include "imulab/results/compensation.hpp"
#include "imulab/results/navigation.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/result_comparison.hpp"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace imulab {

/// A coefficient of a prediction. What not every method predicts is optional. SI.
struct PredictedCoefficient {
  CoefficientIndex index{};
  double sigma = 0, cramer_rao = NAN;    ///< the bound: NaN where it is not stated
  double degrees_of_freedom = INFINITY;  ///< effective
  std::optional<double> first_order = {}, second_order = {}, bias = {}, monte_carlo = {};
  std::optional<double> sigma_of_half = {}, sigma_of_twice = {};  ///< as Prediction has them
  std::vector<std::pair<std::string, double>> budget = {};        ///< sigma by source, to first order
};

/// What a plan added to a drive.
struct AddedManoeuvres {
  std::vector<std::string> names;  ///< in their order
  double added = 0, duration = 0;  ///< s: of them, of the drive with them
  double worst = 0;                ///< uncertainty over requirement; infinite: not determined
};

/// The prediction of any method, as its JSON has it.
struct PredictionSummary {
  std::vector<PredictedCoefficient> coefficients = {};
  std::vector<CoefficientIndex> undetermined = {}, considered = {};
  std::vector<std::pair<std::string, double>> priors = {};  ///< of terms that the IMU may have, by name
  std::vector<std::string> notes = {};
  std::vector<RigErrorEstimate> rig_errors = {};                           ///< lever arms, delays and mounting angles of aids
  std::optional<std::uint64_t> runs = {};                                  ///< of the Monte Carlo
  std::optional<std::vector<Shortfall>> missed = {};                       ///< requirements
  std::vector<std::pair<std::string, Tolerances::Answer>> tolerance = {};  ///< by knob; not read back
  std::optional<AddedManoeuvres> added = {};                               ///< of a drive that was planned
  std::optional<Advice> advice = {};                                       ///< from JSON: without its ratios

  std::vector<CoefficientIndex> indices() const;
  Eigen::VectorXd sigma() const;
};

PredictionSummary summary_of(const Prediction& prediction);

struct PlanSummary {
  std::vector<Requirement> requirements;
  TurnPath path;  ///< from JSON: without its worst ratio
  PredictionSummary prediction;
  std::optional<PriorEffect> prior = {};
  double margin = 1;  ///< of the limits, which the path was to reach
};

/// Standard uncertainties in SI, the shares of their sources, and the answers to requirements where there are any (docs/theory/strapdown.md).
std::string prediction_json(const PredictionSummary& prediction);
/// {"requirements", "duration_s", "first_rest_s", "turns": [{"axis", "angle_deg", "rest_s"}]}, "prior" where there is one, and the prediction's own
/// keys.
std::string plan_json(const PlanSummary& plan);

struct BudgetSummary {
  /// From JSON: some of the times, with a diagonal covariance; over time of single sources the horizontal position alone.
  ErrorBudget budget;
  std::optional<ErrorDistribution> monte_carlo;
  std::uint64_t runs = 0;                   ///< of the Monte Carlo
  std::vector<NavigationState> track = {};  ///< of the motion, thinned
  std::string grade = {}, noise = {};       ///< of the sensors, and where their noise comes from; empty: not stated
};

/// The sessions of one command. From JSON: begin and end in `solution.time`, track and errors thinned.
using NavigationSummary = std::vector<NavigatedSession>;

using SavedResult = std::variant<Calibration, ComparisonSummary, PredictionSummary, PlanSummary, NavigationSummary, AidedSummary, BudgetSummary,
                                 CompensationSummary, NoiseAnalysis, NoiseBatch, ResultComparison, Extrinsics>;

struct SavedAnswer {
  SavedResult result;
  Conclusion conclusion;              ///< of a calibration: its own fields have it
  std::vector<std::string> warnings;  ///< as those of the answer; of a calibration: its own fields have them
};

/// Reads calibration.json, noise.json or what `compare`, `predict`, `plan`, `navigate`, `budget` or `compensate` print with --json; the budgets of
/// several grades as their comparison. Throws Error that names the file and what was expected.
SavedAnswer read_answer(const std::filesystem::path& path);
/// Reads the text of such a file; `file` is its name in messages.
SavedAnswer parse_answer(std::string_view text, const std::string& file);
SavedResult parse_result(std::string_view text, const std::string& file);

}  // namespace imulab
