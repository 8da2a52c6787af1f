// Columns, keys and sizes of effects, and the play of hysteresis.
#include "imulab/grade.hpp"
#include "imulab/model/effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace imulab {

namespace {

constexpr std::array<std::string_view, 4> graded{"strategic", "navigation", "tactical", "mems"};

/// Returns the index of a grade among those of the priors; mems-30g is mems.
std::size_t place_of(std::string_view name) {
  const auto at = std::find(graded.begin(), graded.end(), name);
  return std::min<std::size_t>(static_cast<std::size_t>(at - graded.begin()), graded.size() - 1);
}

/// Returns keys by name: effect name, `between`, and unit, as in gyro_g_squared, _sigma_, deg_per_h_per_g2.
std::map<std::string_view, std::string> keys_of_effects(std::string_view between) {
  std::map<std::string_view, std::string> out;
  for (const Effect& effect : effects()) {
    std::string& key = out[effect.name];
    for (const char c : effect.name) key += c == '.' ? '_' : c;
    key += between;
    for (const char c : effect.unit_name) key += c == '/' ? "_per_" : c == '^' ? "" : std::string(1, c);
  }
  return out;
}

}  // namespace

int Effect::columns(const EffectSetting& setting) const {
  const unsigned has = (setting.accel ? of_accel : 0u) | (setting.gyro ? of_gyro : 0u) | (setting.thermometer ? by_thermometer : 0u) |
                       (setting.recordings > 1 ? by_recordings : 0u) | (setting.mount ? by_mount : 0u) | (setting.centrifuge ? by_centrifuge : 0u) |
                       (setting.latitude ? by_latitude : 0u) | (setting.changed ? by_change : 0u) | (setting.heading ? by_north : 0u) |
                       (setting.thermal ? by_thermal : 0u) | (setting.sweep ? by_sweep : 0u);
  constexpr unsigned triads = of_accel | of_gyro;
  if ((needs & triads & has) == 0 || (needs & ~triads & ~has) != 0) return 0;
  if ((needs & by_recordings) != 0) return basis * (setting.recordings - 1);
  return basis * (each == Each::recording ? setting.recordings : each == Each::machine ? setting.machines : 1);
}

std::string_view Effect::declared() const {
  static const std::map<std::string_view, std::string> keys = keys_of_effects("_sigma_");
  return keys.at(name);
}

std::string_view Effect::simulated() const {
  static const std::map<std::string_view, std::string> keys = keys_of_effects("_");
  return keys.at(name);
}

std::span<const std::string_view> graded_names() { return graded; }

const Effect* find_effect(std::string_view name) {
  const auto at = std::ranges::find(effects(), name, &Effect::name);
  return at == effects().end() ? nullptr : &*at;
}

double effect_sigma(const Effect& effect, const EffectSigmas& declared, std::string_view grade_name) {
  if (const auto at = declared.find(effect.name); at != declared.end()) return at->second;
  return effect.prior[place_of(grade_name)] * effect.unit;
}

Vector3d PlayOperator::operator()(const Vector3d& force) {
  if (!middle_) middle_ = force;
  middle_ = middle_->cwiseMax(force - Vector3d::Constant(half_)).cwiseMin(force + Vector3d::Constant(half_));
  return (force - *middle_) / half_;
}

}  // namespace imulab
