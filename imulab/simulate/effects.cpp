#include "imulab/simulate/effects.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::simulate {

EffectSetting setting_of(const Session& procedure) {
  EffectSetting setting{.accel = true, .gyro = true, .thermometer = true, .recordings = static_cast<int>(procedure.recordings.size())};
  for (const RigDeclaration& rig : procedure.rigs) setting.mount = setting.mount || rig.kind != RigKind::none;
  return setting;
}

std::string problem_of(const EffectValue& effect, const EffectSetting& setting) {
  const Effect* const row = find_effect(effect.name);
  if (row == nullptr) return fmt::format("\"{}\" is no effect; expected one of docs/theory/effects.md", effect.name);
  const int columns = row->columns(setting);
  if (effect.column < 0 || effect.column >= columns)
    return fmt::format("{}: column {}; expected one of the {} that the session has", effect.name, effect.column, columns);
  if (!std::isfinite(effect.value)) return fmt::format("{}: {} is not finite; expected a finite number", effect.name, effect.value);
  return "";
}

namespace {

Vector3d vector_at(const Columns3& columns, std::size_t k) { return {columns[0][k], columns[1][k], columns[2][k]}; }

double largest(const Columns3& columns) {
  double most = 0;
  for (const auto& column : columns)
    for (const double x : column) most = std::max(most, std::abs(x));
  return most;
}

}  // namespace

std::vector<EffectValue> drawn_effects(const Session& procedure, std::uint64_t seed) {
  std::vector<EffectValue> out;
  const EffectSetting setting = setting_of(procedure);
  const EffectSigmas sizes = procedure.imu.simulated_effects.value_or(EffectSigmas{});
  for (const auto& [name, sigma] : sizes) {
    const Effect& effect = *find_effect(name);
    if (sigma > 0 && effect.columns(setting) == 0)
      throw Error(fmt::format("imu.effects.{}: is not simulated in this session, which lacks what it depends on; expected other effects",
                              effect.simulated()));
    const RandomStream draws(seed, "truth effect " + name);
    for (int k = 0; k < effect.columns(setting); ++k) out.push_back({name, k, sigma * draws.normal(static_cast<std::uint64_t>(k))});
  }
  return out;
}

void add_effects(Recording& motion, std::span<const EffectValue> effects, double gravity, int number,
                 std::span<const TemperatureProfile::State> temperatures) {
  if (effects.empty() || motion.size() == 0) return;
  EffectState state{.gravity = gravity, .recording = number};
  state.full_force = std::max(gravity, largest(motion.accel));
  state.full_rate = std::max(1.0, largest(motion.gyro));
  double mean = 0;
  for (const TemperatureProfile::State& t : temperatures) mean += t.unit / static_cast<double>(temperatures.size());
  std::vector<EffectColumn> columns;
  for (const EffectValue& e : effects) columns.push_back({find_effect(e.name), e.column});
  PlayOperator play(gravity);
  const double last = std::max(motion.time_s(motion.size() - 1), 1e-9);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    state.force = vector_at(motion.accel, k);
    state.rate = vector_at(motion.gyro, k);
    state.time = motion.time_s(k) / last - 0.5;
    state.play = play(state.force);
    if (!temperatures.empty()) state.warming = temperatures[k].unit - mean;
    OutputChange sum;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const OutputChange change = columns[i].at(state);
      sum.force += effects[i].value * change.force, sum.rate += effects[i].value * change.rate;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      motion.accel[axis][k] += sum.force[static_cast<Eigen::Index>(axis)];
      motion.gyro[axis][k] += sum.rate[static_cast<Eigen::Index>(axis)];
    }
  }
}

}  // namespace imulab::simulate

namespace imulab {

std::vector<EffectEstimate> stated_effects(std::span<const EffectValue> effects) {
  std::vector<EffectEstimate> out;
  for (const EffectValue& e : effects) {
    const Effect& effect = *find_effect(e.name);
    if (out.empty() || out.back().name != effect.name) out.push_back({std::string(effect.name), std::string(effect.unit_name), {}, {}, true});
    out.back().values.push_back(e.value / effect.unit);
    out.back().sigma.push_back(0);
  }
  return out;
}

}  // namespace imulab
