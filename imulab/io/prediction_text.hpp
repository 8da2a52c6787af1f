// A prediction as JSON.
#pragma once

#include "imulab/analysis/hybrid_advice.hpp"
#include "imulab/analysis/requirement.hpp"
#include "imulab/analysis/turntable_prediction.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The answer for one knob, alone and with the others as declared.
struct KnobAnswer {
  Knob knob;
  Tolerance declared;
  std::optional<Tolerance> alone;
};

/// Standard uncertainties in SI, the shares of their sources, and the answers to requirements where there are any.
std::string prediction_json(const TurntablePrediction& prediction, const std::optional<MonteCarloResult>& monte_carlo,
                            const std::vector<Shortfall>& shortfalls, const std::vector<KnobAnswer>& answers);

/// Of the hybrid method; the advice where something is undetermined or not within its requirement.
std::string prediction_json(const HybridPrediction& prediction, const std::vector<Shortfall>& shortfalls, const std::optional<HybridAdvice>& advice);

}  // namespace imulab
