#include "imulab/tasks/noise_moving.hpp"

#include "imulab/error.hpp"
#include "imulab/noise/moving.hpp"
#include "imulab/results/summary.hpp"

#include <fmt/format.h>

#include <optional>
#include <utility>

namespace imulab {
namespace {

/// What a navigation shows of one triad. Fixes of every second resolve too little of the noise for a factor of each kind of motion.
std::string residuals_in_words(const MovingNavigation& navigation, std::optional<AidedResiduals> AidedMotion::*triad) {
  std::string residuals, innovations;
  for (const AidedMotion& m : navigation.motion) {
    if (m.*triad) residuals += fmt::format("{}{} {:.2g} ({:.0f})", residuals.empty() ? "" : ", ", m.kind, (m.*triad)->rms, (m.*triad)->resolved);
    if (m.innovations > 0) innovations += fmt::format("{}{} {:.2g}", innovations.empty() ? "" : ", ", m.kind, m.rms);
  }
  if (residuals.empty()) residuals = "too few to tell";
  return "residuals of the smoothed solution in sigmas of the noise that the filter found: " + residuals +
         "; innovations in stated sigmas, which contain the errors of the aids: " + innovations;
}

MovingEvidence navigation_evidence(const NoiseAnalysis& rest, const MovingNavigation& navigation) {
  MovingEvidence out{.file = navigation.file + ": aided navigation", .axes = {}};
  for (const NoiseAxis& axis : rest.axes) {
    const std::string reason = residuals_in_words(navigation, axis.name.starts_with("gyro.") ? &AidedMotion::gyro : &AidedMotion::accel);
    if (axis.fit)
      out.axes.push_back(
          {.name = axis.name, .unit = axis.unit, .causes = {{.name = "motion", .parameter = "N", .file = navigation.file, .reason = reason}}});
  }
  return out;
}

MovingEvidence moving_evidence(const NoiseAnalysis& rest, const MovingInput& input) {
  if (const auto* const log = std::get_if<std::shared_ptr<const Recording>>(&input)) return moving_log(rest, **log);
  if (const auto* const c = std::get_if<MovingCalibration>(&input)) return moving_calibration(rest, *c->calibration, c->file);
  return navigation_evidence(rest, std::get<MovingNavigation>(input));
}

}  // namespace

MovingInput moving_input(const std::string& file) {
  SavedResult result = read_answer(file).result;
  if (Calibration* const calibration = std::get_if<Calibration>(&result))
    return MovingCalibration{file, std::make_shared<const Calibration>(std::move(*calibration))};
  const AidedSummary* const aided = std::get_if<AidedSummary>(&result);
  if (aided == nullptr || aided->motion.empty())
    throw Error(file + ": expected a log, calibration.json, or what imulab navigate --aided --json prints, after --moving");
  return MovingNavigation{file, aided->motion};
}

void add_moving(NoiseAnalysis& rest, const std::vector<MovingInput>& inputs) {
  if (inputs.empty()) return;
  std::vector<MovingEvidence> evidence;
  for (const MovingInput& input : inputs) {
    evidence.push_back(moving_evidence(rest, input));
    rest.warnings.insert(rest.warnings.end(), evidence.back().warnings.begin(), evidence.back().warnings.end());
  }
  rest.moving = moving_noise(rest, evidence);
  raise_bounds(rest, evidence);
}

}  // namespace imulab
