// A budget with aids: its errors over the time since these were lost.
#pragma once

#include "imulab/formats/text/json.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <string>
#include <utility>
#include <vector>

namespace imulab {

/// One sigma at a time since the loss.
struct ErrorsAfterLoss {
  double seconds = 0;
  double horizontal = 0, vertical = 0, velocity = 0, heading = 0;  // m, m, m/s (horizontal), rad
  std::vector<std::pair<std::string, double>> sources;             // horizontal position [m]
};

/// At 0 s, the last with the aids, at 10, 60 and 600 s as far as the loss lasts, and at its end; linear between the outputs.
std::vector<ErrorsAfterLoss> errors_after_loss(const ErrorBudget& budget);

/// The same for readers of the JSON, who then need no history.
JsonValue after_loss_json(const ErrorBudget& budget);

/// A column each of these times: totals, then the sources, the largest at the end first, with their shares.
std::string after_loss_table(const ErrorBudget& budget);

/// "gnss, barometer"
std::string lost_aids(const AidLoss& loss);

}  // namespace imulab
