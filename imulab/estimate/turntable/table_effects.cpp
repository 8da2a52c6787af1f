#include "imulab/estimate/turntable/table_effects.hpp"

#include "imulab/estimate/kernel/site.hpp"
#include "imulab/rig/table_states.hpp"

#include <algorithm>

namespace imulab::turntable {

using Eigen::Index;

TableEffects on_motion(TableEffects effects, const TableMotion& motion, const TablePlan& plan, const Site& site) {
  const Index size = effects.table.size();
  effects.truth.setZero(static_cast<Index>(6 * motion.parts()), size);
  if (size == 0) return effects;
  auto states = table_states(motion, plan, site.gravity(), effects.change ? std::optional(effects.change->step) : std::nullopt);
  const kernel::SiteChanges changes(site);
  for (std::size_t part = 0; part < motion.parts(); ++part)
    for (auto& [state, weight, C_bn] : states[part]) {
      changes.fill(state, C_bn);
      for (Index column = 0; column < size; ++column) {
        const OutputChange change = effects.table.columns()[static_cast<std::size_t>(column)].at(state);
        auto sum = effects.truth.col(column).segment<6>(static_cast<Index>(6 * part));
        if (motion.is_hold(part)) sum.head<3>() += weight * change.force;  // only gyros measure turns
        sum.tail<3>() += weight * change.rate;
      }
    }
  return effects;
}

TableEffects table_effects(kernel::EffectSizes sizes, const TableMotion& motion, const TablePlan& plan, const Site& site,
                           const std::optional<UnitChange>& change) {
  for (const Effect& e : effects())
    if ((e.needs & Effect::by_change) != 0 && change && change->effect != nullptr && change->effect != &e) sizes.declared[std::string(e.name)] = 0;
  const bool warms = std::any_of(plan.holds.begin(), plan.holds.end(), [](const TablePart& hold) { return hold.warming.has_value(); });
  const EffectSetting setting{.accel = true,
                              .gyro = true,
                              .thermometer = warms,
                              .mount = true,
                              .changed = change.has_value(),
                              .latitude = site.latitude.has_value(),
                              .heading = true};
  return on_motion({kernel::Effects(sizes, setting), change, {}}, motion, plan, site);
}

}  // namespace imulab::turntable
