// Comparison of two methods on the same data. If a is the more efficient estimate and b the other, the covariance of b - a is P_b - P_a (Hausman
// 1978), because the additional error of b is independent of a's. If each method determines some coefficients better, neither is efficient, their
// correlation is unknown, and their errors count as independent. A wrong model in one method, or a rig that is not as declared, makes them differ.
#pragma once

#include "imulab/calibration.hpp"

#include <optional>
#include <string_view>

namespace imulab::kernel {

/// Returns the coefficient with the largest difference in its standard deviations, among those that both determine, in the accelerometers' frame.
/// Variances that differ by less than a tenth contain no information and are skipped; absent if no coefficient remains.
std::optional<SecondOpinion> second_opinion(const Calibration& estimate, const Calibration& other);

/// Adds the opinion to the result, as a doubt beyond 3.7 sigma (p = 0.005 for 24 coefficients). A method that doubts its own estimate gives no
/// opinion, but its doubts about the session apply to any method.
void add_second_opinion(Calibration& calibration, const Calibration& other);

}  // namespace imulab::kernel
