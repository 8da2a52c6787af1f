// Two methods on the same data. The more efficient one's estimate is a, the other's b; the covariance of b - a is P_b - P_a (Hausman 1978), since
// what b adds to a's error is independent of it. Where each of two methods knows some coefficient better, neither is efficient: what they have in
// common is not known, and their errors count as independent. A model that is wrong in one of them, or a rig that is not as declared, sets them
// apart.
#pragma once

#include "imulab/calibration.hpp"

#include <optional>
#include <string_view>

namespace imulab::kernel {

/// The coefficient that differs most in standard deviations of the difference, among those that both determine; in the accelerometers' frame.
/// Variances that hardly differ (by less than a tenth) tell nothing and are left out. None where no coefficient is left.
std::optional<SecondOpinion> second_opinion(const Calibration& estimate, const Calibration& other);

/// Adds it to the result: beyond 3.7 sigma (one in some 200 among 24 coefficients by chance) as a doubt. Where the other method doubts its own
/// estimate it has none; what it doubts of the session holds for any method.
void add_second_opinion(Calibration& calibration, const Calibration& other);

}  // namespace imulab::kernel
