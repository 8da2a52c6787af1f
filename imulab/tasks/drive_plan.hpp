// Which manoeuvres, added to a drive, meet requirements on its calibration.
#pragma once

#include "imulab/tasks/plan.hpp"
#include "imulab/tasks/predict.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab {

struct PlannedDrive {
  std::vector<Requirement> requirements;
  std::vector<std::string> added;   ///< manoeuvres, in their order
  double before = 0, duration = 0;  ///< s: of the mission as it was, and with them
  std::string mission;              ///< its text, with them
  Prediction prediction;
  double worst = 0;  ///< uncertainty over requirement
};

/// Adds one manoeuvre of a table after the other to a vehicle's mission, each time that which lowers the worst ratio of uncertainty to requirement
/// most in its time, until all requirements are met with the margin, or none helps. Throws OptionError for options of a path of turns, Error as
/// read_mission does and for a mission that is no vehicle's.
AnswerOf<PlannedDrive> drive_plan_answer(const PlanOptions& o, const std::function<void(double)>& progress);

}  // namespace imulab
