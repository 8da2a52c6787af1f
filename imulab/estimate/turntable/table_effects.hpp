// What a unit on a turntable may do besides the sensor model (model/effects.hpp), as further sources of the readings beside the table's errors.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/rig/table_motion.hpp"

#include <cstddef>
#include <optional>

namespace imulab::turntable {

struct TableEffects {
  kernel::Effects table;                ///< with their priors; by default none
  std::optional<std::size_t> moved_at;  ///< the step before which the unit moved in its mount
  Eigen::MatrixXd truth;                ///< change of the truth, as TableMotion has it, by c = 1 of each: six rows a part
};

/// All that a unit on a table can have, with their functions at the states of a motion: of a hold at its state, of a turn integrated along it.
TableEffects table_effects(const kernel::EffectSizes& sizes, const TableMotion& motion, const TablePlan& plan, const Site& site,
                           std::optional<std::size_t> moved_at = {});
/// The same effects on another motion.
TableEffects on_motion(TableEffects effects, const TableMotion& motion, const TablePlan& plan, const Site& site);

}  // namespace imulab::turntable
