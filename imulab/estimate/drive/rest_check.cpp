#include "imulab/estimate/drive/rest_check.hpp"

#include "imulab/compensate.hpp"
#include "imulab/grade.hpp"
#include "imulab/navigation/aided/aid_motion.hpp"
#include "imulab/recording/agreement_at_rest.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace imulab::drive {

namespace {

constexpr double mg = 1000 * unit::ug;

/// The error of a rest or turn relative to its uncertainty.
struct Excess {
  double begin_s = 0, end_s = 0, error = 0, sigma = 1;
  double sigmas() const { return std::abs(error) / sigma; }
};

/// Returns the largest excess if it is significant among all, else null.
const Excess* improbable(const std::vector<Excess>& all) {
  constexpr double chance = 1e-5;
  const auto worst = std::ranges::max_element(all, {}, &Excess::sigmas);
  // exp(-s^2 / 2) is the tail probability of two orthogonal errors, and bounds that of one
  return worst != all.end() && std::pow(worst->sigmas(), 2) > -2 * std::log(chance / static_cast<double>(all.size())) ? &*worst : nullptr;
}

/// Returns the covariance of the output (rate, then force) at a motion.
Eigen::Matrix<double, 6, 6> covariance_at(const Calibration& calibration, const Motion& motion) {
  return output_covariance(calibration, decompensate(calibration.model, motion));
}

/// Returns an upper bound of the sigma of the rotation over a range [rad]: all errors of the coefficients turn in the same direction.
double rotation_sigma(const Calibration& calibration, const Recording& recording, const Range& range, double random_walk) {
  constexpr std::size_t places = 200;
  if (range.size() == 0) return 0;
  const MotionSamples motion = compensated_samples(calibration.model, recording, range);
  const double duration = recording.time_s(range.end - 1) - recording.time_s(range.begin) + recording.interval_s;
  const std::size_t step = std::max<std::size_t>(1, range.size() / places);
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < range.size(); k += step, ++count) {
    const auto at = [&](const Columns3& columns) { return Vector3d(columns[0][k], columns[1][k], columns[2][k]); };
    sum += std::sqrt(covariance_at(calibration, {at(motion.rate), at(motion.force)}).topLeftCorner<3, 3>().trace());
  }
  return std::hypot(sum / count * duration, random_walk * std::sqrt(2 * duration));
}

}  // namespace

void doubt_at_rest(const Calibration& calibration, const AidedNavigation& navigation, const Recording& recording, const Session& session,
                   const std::string& before, kernel::Findings& findings) {
  constexpr double gravity_by_height = 3.1e-6;  // 1/s^2
  const NoiseModels noise = declared_terms(session.imu);
  const auto [lowest, highest] = std::ranges::minmax_element(navigation.track, {}, &NavigationState::height);
  const double of_place = navigation.track.empty() ? 0 : gravity_by_height * (highest->height - lowest->height);
  const std::vector<GravityAtRest> rests =
      gravity_at_rests(recording, aided::rests_in_place(recording, session), calibration.model, calibration.model);
  std::vector<Excess> sizes, turns;
  std::map<double, double> tilt;  // rad, of the direction that a rest measures, by its begin and by its end
  for (const GravityAtRest& rest : rests) {
    const Matrix3d P = covariance_at(calibration, {Vector3d::Zero(), rest.force}).bottomRightCorner<3, 3>();
    const Vector3d up = rest.force.normalized();
    const double along = up.dot(P * up), mean = std::pow(noise.accel.N, 2) / (rest.end_s - rest.begin_s + recording.interval_s);
    sizes.push_back({rest.begin_s, rest.end_s, rest.after - session.site.gravity(), std::hypot(std::sqrt(along + mean), of_place)});
    tilt[rest.begin_s] = tilt[rest.end_s] = std::sqrt(std::max(0.0, P.trace() - along) + 2 * mean) / rest.after;
  }
  for (const TurnError& turn : turn_errors(recording, rests, calibration.model, calibration.model))
    turns.push_back({turn.begin_s, turn.end_s, turn.after,
                     std::hypot(tilt[turn.begin_s], tilt[turn.end_s],
                                rotation_sigma(calibration, recording, recording.samples_in(turn.begin_s, turn.end_s), noise.gyro.N))});
  if (const Excess* worst = improbable(sizes))
    findings.add<Code::force_at_rest>(before, worst->begin_s, worst->end_s, worst->error / mg, worst->sigma / mg);
  if (const Excess* worst = improbable(turns))
    findings.add<Code::turn_missed>(before, worst->begin_s, worst->end_s, worst->error / unit::deg, worst->sigma / unit::deg);
}

}  // namespace imulab::drive
