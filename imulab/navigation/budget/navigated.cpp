#include "imulab/navigation/budget/navigated.hpp"

#include "imulab/recording/compensate_recording.hpp"

#include <algorithm>

namespace imulab {

namespace {

/// The states, and the samples between them.
motion::NominalMotion navigated_motion(const Calibration& calibration, const Recording& raw, const Solution& solution) {
  Recording recording = compensate(calibration.model, raw).recording;
  if (!calibration.model.lever_arm.isZero(0)) remove_lever_arms(recording, calibration.model.lever_arm);
  const InertialSamples samples = inertial_samples(recording, {0, recording.size()});
  motion::NominalMotion out{solution.time, solution.states, {}};
  const auto first = samples.steps.size() - std::min(samples.steps.size(), solution.size() - 1);
  for (std::size_t i = first; i < samples.steps.size(); ++i) out.increments.push_back(samples.steps[i].increment);
  return out;
}

}  // namespace

std::optional<ErrorBudget> navigated_budget(const Calibration& calibration, const Session& session, const Recording& raw, const Navigated& navigated,
                                            int outputs) {
  const Solution& solution = navigated.solution;
  if (calibration.estimated.empty() || solution.states.size() < 2) return {};
  const motion::NominalMotion motion = navigated_motion(calibration, raw, solution);
  if (motion.increments.size() + 1 != motion.states.size()) return {};
  ErrorSources sources = error_sources(calibration);
  if (navigated.aligned) {
    sources.start.aligned_over = navigated.aligned->end - navigated.aligned->begin;
    sources.gyro_noise.N = navigated.aligned->alignment.gyro_noise;
    sources.accel_noise.N = navigated.aligned->alignment.accel_noise;
  }
  const double interval = (solution.time.back() - solution.time.front()) / std::max(1, outputs);
  return error_budget(motion, sources,
                      {.strapdown = {.vertical = navigated.vertical, .gravity = session.site.given_gravity}, .output_interval = interval});
}

}  // namespace imulab
