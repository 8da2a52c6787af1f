#include "imulab/estimate/drive/drive.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/drive/coefficients.hpp"
#include "imulab/estimate/drive/quality.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/navigation/aided/setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::drive {

using Eigen::Index;

namespace {

void expect_aids(const Session& session, const Recording& recording) {
  if (session.aids.empty())
    throw Error(
        fmt::format("{}: has no aids, which the method drive needs; expected [[aid]], as kind = \"gnss\" with a file "
                    "(docs/reference/aids.md)",
                    session.file.empty() ? recording.name : session.file));
  for (const auto& [unit, triad] : {std::pair(recording.gyro_unit, "gyro"), std::pair(recording.accel_unit, "accel")})
    if (unit == "count")
      throw Error(fmt::format("{}: {} in counts, whose size a drive does not tell; expected its unit and counts_per_unit", recording.name, triad));
}

/// The site with the place of the drive where the session has none: gravity follows from it.
Session with_place(Session session, const AidedNavigation& n) {
  if (session.site.given_gravity || session.site.latitude) return session;
  const NavigationState& state = n.solution.states.front();
  session.site.latitude = state.latitude, session.site.longitude = state.longitude, session.site.height = state.height;
  return session;
}

/// Gravity is the same part of all three scales of the accelerometers.
void add_gravity(Calibration& c, const Site& site) {
  Eigen::VectorXd common = Eigen::VectorXd::Zero(std::ssize(c.estimated));
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    if (const Coefficient& row = coefficient(c.estimated[k]); row.triad == Triad::accel && is_scale(row))
      common[static_cast<Index>(k)] = coefficient_value(c.model, c.estimated[k]) * site.gravity_sigma() / site.gravity();
  c.covariance += common * common.transpose();
}

}  // namespace

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Recording& recording = kernel::only_recording(input, "drive");
  expect_aids(input.session, recording);
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(options.terms, drive_coefficients(), "drive");
  constexpr int passes = 10;  // the factors of the noise settle slowly where few values show them
  const AidedNavigation n =
      aided::navigate_under(unit_priors(input.session.imu, chosen), input.session, recording, input.session.aids, {.passes = passes});
  const Session session = with_place(input.session, n);
  CalibrationResult result{.calibration = calibration_of(n)};
  Calibration& calibration = result.calibration;
  calibration.imu = session.imu.name;
  result.iterations = n.passes;
  add_gravity(calibration, session.site);
  add_wander(calibration, recording, session.imu);
  const kernel::Findings findings = judged(n, session, calibration);
  if (options.effects && options.terms.empty()) consider_curvature(calibration, recording, session.imu);
  sort_by_table(calibration);
  kernel::conclude(calibration, findings);
  return result;
}

}  // namespace imulab::drive
