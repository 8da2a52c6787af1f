// Predicted uncertainties and tolerances of a procedure, as JSON and as tables.
#pragma once

#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/estimate/turntable/tolerance.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

namespace hybrid {
struct Path;
}

/// The answer for one knob, with the others as declared and with all else perfect.
struct KnobAnswer {
  turntable::Knob knob;
  turntable::Tolerance declared;
  std::optional<turntable::Tolerance> alone;
};

/// Standard uncertainties in SI, the shares of their sources, and the answers to requirements where there are any (docs/predict.md).
std::string prediction_json(const turntable::Prediction& prediction, const std::optional<turntable::MonteCarloResult>& monte_carlo,
                            const std::vector<Shortfall>& shortfalls, const std::vector<KnobAnswer>& answers);
/// Of the other methods; the hybrid method's advice where something is undetermined or not within its requirement.
std::string prediction_json(const Prediction& prediction, const std::vector<Shortfall>& shortfalls, const std::optional<hybrid::Advice>& advice);

/// The worst of each group, then a row a coefficient: its uncertainty in user units, and the share of each source in its variance. With `details`
/// also orders and Monte Carlo with more digits. Empty where no coefficient is determined.
std::string prediction_table(const turntable::Prediction& prediction, const std::optional<turntable::MonteCarloResult>& monte_carlo,
                             bool details = false);
/// The worst of each group, then a row a coefficient: its uncertainty in user units, and beside it what is required, if anything is; then what is not
/// determined.
std::string prediction_table(const Prediction& prediction, const std::vector<Requirement>& requirements);

/// Which requirements the plan does not meet as declared, and what table, timing and unit would meet them all.
std::string tolerance_table(const turntable::Plan& plan, const std::vector<Shortfall>& missed, const std::vector<KnobAnswer>& answers);
/// The worst determined coefficients, and the turns that help most.
std::string advice_text(const hybrid::Advice& advice);
/// The further turns of an advice: "turn by ..., then turn by ..., and rest".
std::string turns_text(const hybrid::Advice& advice);
/// "gyro.matrix.xx has 31.2 ppm where 10 ppm is required" or "gyro.matrix.xx is not determined".
std::string shortfall_text(const Shortfall& shortfall);

/// A fleet's prior, and the shortest path without it (NaN where the time was given).
struct PriorEffect {
  std::string fleet;
  double units = 0, duration_without = 0;  ///< s
};

/// {"requirements", "duration_s", "first_rest_s", "turns": [{"axis", "angle_deg", "rest_s"}]}, "prior" where there is one, and the prediction's own
/// keys.
std::string path_json(const hybrid::Path& path, const std::vector<Requirement>& requirements, const Prediction& prediction,
                      const std::vector<Shortfall>& missed, const std::optional<PriorEffect>& prior = {});
/// "with what 60 units of fleet.db say of it; without: 14 min 05 s"
std::string prior_text(const PriorEffect& prior);
/// First rest, then a row a turn and the rest after it.
std::string path_table(const hybrid::Path& path);

}  // namespace imulab
