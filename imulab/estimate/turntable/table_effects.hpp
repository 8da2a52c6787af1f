// What a unit on a turntable may do besides the sensor model (model/effects.hpp), as further sources of the readings beside the table's errors.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/rig/table_motion.hpp"

#include <cstddef>
#include <optional>

namespace imulab::turntable {

/// A change of the unit or its mount, which lasts.
struct UnitChange {
  std::size_t step;                ///< before which it came
  const Effect* effect = nullptr;  ///< what changed; null: all that can
};

struct TableEffects {
  kernel::Effects table;  ///< with their priors; by default none
  std::optional<UnitChange> change;
  Eigen::MatrixXd truth;  ///< change of the truth, as TableMotion has it, by c = 1 of each: six rows a part
};

/// All that a unit on a table can have, with their functions at the states of a motion: of a hold at its state, of a turn integrated along it.
TableEffects table_effects(kernel::EffectSizes sizes, const TableMotion& motion, const TablePlan& plan, const Site& site,
                           const std::optional<UnitChange>& change = {});
/// The same effects on another motion.
TableEffects on_motion(TableEffects effects, const TableMotion& motion, const TablePlan& plan, const Site& site);

}  // namespace imulab::turntable
