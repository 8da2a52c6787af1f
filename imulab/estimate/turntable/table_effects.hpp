// Effects of a unit on a turntable beyond the sensor model (model/effects.hpp), as sources of the readings in addition to the table's errors.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/rig/table_motion.hpp"

#include <cstddef>
#include <optional>

namespace imulab::turntable {

/// A permanent change of the unit or its mount.
struct UnitChange {
  std::size_t step;                ///< the change came before this step
  const Effect* effect = nullptr;  ///< what changed; null: everything that can change
};

struct TableEffects {
  kernel::Effects table;  ///< includes priors; empty by default
  std::optional<UnitChange> change;
  Eigen::MatrixXd truth;  ///< change of the truth (see TableMotion) for c = 1 of each, six rows per part
};

/// Returns all effects of a unit on a table, with their functions at the states of a motion: at the state of a hold, integrated along a turn.
TableEffects table_effects(kernel::EffectSizes sizes, const TableMotion& motion, const TablePlan& plan, const Site& site,
                           const std::optional<UnitChange>& change = {});
/// Returns the same effects for another motion.
TableEffects on_motion(TableEffects effects, const TableMotion& motion, const TablePlan& plan, const Site& site);

}  // namespace imulab::turntable
