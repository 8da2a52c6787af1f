// Finds the shortest path of turns and rests with which a method meets requirements.
#pragma once

#include "imulab/fleet.hpp"
#include "imulab/plan.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct PlanOptions : ShowOptions {
  std::string require, grade = "navigation", axes = "3", effects = "table", prior;
  std::optional<std::string> noise;  ///< file of an analysis, in place of the grade's terms
  double latitude_deg = 45, margin = 0.8;
  std::optional<double> gravity, within, rest;
  std::optional<std::string> mission;  ///< of a drive, in place of a path: drive_plan.hpp
  SharingOptions shared;
};
/// The verb `plan`, which sets these.
Verb& declare(Verb& command, PlanOptions& o);

struct PlanTask {
  std::vector<Requirement> requirements;
  std::string grade = "navigation";
  std::optional<std::string> noise = {};  ///< file of an analysis, in place of the grade's terms
  double margin = 1;                      ///< the path is to reach this part of each limit
  double latitude = 0;                    ///< rad
  std::optional<double> gravity = {};     ///< m/s^2, measured; absent: normal gravity
  std::vector<RigAxis> axes = {RigAxis::outer, RigAxis::middle, RigAxis::inner};
  bool by_hand = false;
  std::optional<double> time = {};            ///< s in all; absent: as short as the requirements allow
  std::optional<double> rest = {};            ///< s, of every rest; absent: chosen
  bool effects = true;                        ///< in the prediction of the path that was found; the search would take too long with them
  std::optional<FleetPrior> prior = {};       ///< the prior from a fleet
  std::optional<Sharing> sharing = {};        ///< of the first search; the others follow from it
  std::function<void(double)> progress = {};  ///< 0 to 1
};

struct PlannedProcedure {
  std::vector<Requirement> requirements;
  TurnPath path;
  Session procedure;
  Prediction prediction;
  std::optional<PriorEffect> prior;
  double margin = 1;        ///< of the limits that was asked for
  bool by_effects = false;  ///< without effects the requirements would be met
};

/// Throws Error for requirements of coefficients that the method does not estimate, and where no turn fits into the time; Unsupported for a
/// requirement that no path can meet.
PlannedProcedure plan(const PlanTask& task);
/// Adds the prior to a prediction, to each coefficient by itself.
void add_prior(Prediction& prediction, const FleetPrior& prior);
/// With the margin that is left.
Conclusion conclusion_of(const PlannedProcedure& planned);
/// Why the requirements are not met. Empty: they are.
std::string shortcomings(const PlannedProcedure& planned);

/// The task that these options ask for; reads the prior. Throws OptionError.
PlanTask task_of(const PlanOptions& o);
AnswerOf<PlannedProcedure> plan_answer(const PlanTask& task, const std::string& written = "");

}  // namespace imulab
