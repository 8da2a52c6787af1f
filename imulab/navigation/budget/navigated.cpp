#include "imulab/navigation/budget/navigated.hpp"

#include <algorithm>

namespace imulab {

std::optional<ErrorBudget> navigated_budget(const Calibration& calibration, const Session& session, const Navigated& navigated, int outputs) {
  const motion::NominalMotion& motion = navigated.motion;
  if (calibration.estimated.empty() || motion.increments.empty()) return {};
  ErrorSources sources = error_sources(calibration);
  if (navigated.aligned) {
    sources.start.aligned_over = navigated.aligned->end - navigated.aligned->begin;
    sources.gyro_noise.N = navigated.aligned->alignment.gyro_noise;
    sources.accel_noise.N = navigated.aligned->alignment.accel_noise;
  }
  const double interval = (motion.time.back() - motion.time.front()) / std::max(1, outputs);
  return error_budget(
      motion, sources,
      {.strapdown = {.vertical = navigated.vertical, .gravity = session.site.given_gravity}, .output_interval = interval, .algorithm = false});
}

}  // namespace imulab
