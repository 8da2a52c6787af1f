// Effects of a simulated IMU (model/effects.hpp): drawn once, and added to its true motion.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/recording.hpp"
#include "imulab/rig/temperature.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab::simulate {

/// What a simulation has of what effects depend on.
EffectSetting setting_of(const Session& procedure);

/// What is wrong with an effect's value; empty: nothing.
std::string problem_of(const EffectValue& effect, const EffectSetting& setting);

/// One draw a column, of the sizes that [imu.effects] states.
std::vector<EffectValue> drawn_effects(const Session& procedure, std::uint64_t seed);

/// Adds them to the true motion of a recording, sample by sample. `number`: of the recording in its session; `temperatures`: of the samples, empty
/// where the temperature stays.
void add_effects(Recording& motion, std::span<const EffectValue> effects, double gravity, int number,
                 std::span<const TemperatureProfile::State> temperatures);

}  // namespace imulab::simulate

namespace imulab {

/// As a result states them: exactly.
std::vector<EffectEstimate> stated_effects(std::span<const EffectValue> effects);

}  // namespace imulab
