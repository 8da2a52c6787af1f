// The states of a unit on a turntable, at which effects change its outputs (model/effects.hpp), through the parts of a procedure.
#pragma once

#include "imulab/model/effects.hpp"
#include "imulab/rig/table_motion.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab {

/// A state, with its weight in the reading of a part: 1 in all of a hold, the seconds of a turn; and its attitude.
struct WeightedState {
  EffectState state;
  double weight;
  Matrix3d C_bn;
};

/// The states of each part, as TableMotion numbers them; the unit changes before the step `changed_at`, counted from 0; absent: never. The
/// accelerometers' play follows the steps in their order; between two holds all axes move at once.
std::vector<std::vector<WeightedState>> table_states(const TableMotion& motion, const TablePlan& plan, double gravity,
                                                     std::optional<std::size_t> changed_at = {});

}  // namespace imulab
