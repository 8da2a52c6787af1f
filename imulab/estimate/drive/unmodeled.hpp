// What the sensors do besides offsets, matrices and g-sensitivity, as constants of their output under priors: quadratic and cubic terms, and the
// effects of the table (docs/theory/effects.md).
//
// Not among them: drifts of the offsets and their turn-ons, which are the navigation's own states and changes; rectification of vibration.
#pragma once

#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <span>
#include <string>
#include <string_view>

namespace imulab::drive {

/// In front of the names of effects: "effect.gyro.asymmetry.0".
inline constexpr std::string_view effect_prefix = "effect.";
/// Of the unit, or of each drive.
bool is_effect(const std::string& constant);
bool is_effect_of_unit(const std::string& constant);
/// "gyro.asymmetry" of an effect, else the constant's name.
std::string shown_name(const std::string& constant);

/// What all drives of a unit share: temperatures in K, the largest force and rate.
struct Shared {
  bool thermometer = true;
  double full_force = 0, full_rate = 0;
};
Shared shared_by(std::span<const Recording> recordings, const Session& session);

/// The terms of a drive, whose recording must outlive them. It has SI readings that hardly differ from the motion.
aided::OutputTerms output_terms(const Recording& recording, const Session& session, const Shared& shared);

/// The effects that are among the constants, with their values.
kernel::Effects found_effects(const AidedNavigation& navigation, const Session& session);

}  // namespace imulab::drive
