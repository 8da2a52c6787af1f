#include "imulab/navigation/start.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/recording/rests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::navigation {
namespace {

/// The reading whose compensation is the mean of a range. From the mean of raw readings it differs by what noise makes of nonlinearity.
RawSample mean_reading(const SensorModel& model, const Recording& r, const Range& range) {
  const auto mean = [&](const Columns3& columns, double origin) {
    Vector3d out = Vector3d::Zero();
    if (columns[0].empty()) return out;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = range.begin; i < range.end; ++i)
        out[static_cast<Eigen::Index>(k)] += (columns[k][i] - origin) / static_cast<double>(range.size());
    return out;
  };
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();
  if (model.accel.temperature) accel_tau = mean(r.accel_temperature, model.accel.temperature->reference);
  if (model.gyro.temperature) gyro_tau = mean(r.gyro_temperature, model.gyro.temperature->reference);
  return decompensate(model, {mean(r.accel, 0), mean(r.gyro, 0)}, accel_tau, gyro_tau);
}

/// The position of the session's initial state, or else of its site.
NavigationState position_of(const Session& session, std::vector<std::string>& warnings) {
  NavigationState state;
  if (session.initial) {
    state.latitude = session.initial->latitude;
    state.longitude = session.initial->longitude;
    state.height = session.initial->height;
    return state;
  }
  const Site& site = session.site;
  if (!site.latitude)
    throw Error(session.file +
                ": the position is not known; expected an initial state, or the latitude of the site: alignment finds an attitude alone");
  if (!site.longitude) warnings.push_back("the site has no longitude; longitudes are counted from the start");
  if (!site.height) warnings.push_back("the site has no height; heights are counted from the ellipsoid, and gravity is that of height 0");
  state.latitude = *site.latitude;
  state.longitude = site.longitude.value_or(0);
  state.height = site.height.value_or(0);
  return state;
}

void check_heading(const FineAlignment& a) {
  const double sigma = std::sqrt(a.attitude.covariance(2, 2));
  if (sigma <= largest_heading_sigma) return;
  throw Unsupported(fmt::format(
      "alignment: gyros with {2:.2g} deg/sqrt(h) and biases known to {3:.2g} deg/h do not resolve the Earth's rate in this rest; the sigma of "
      "the heading would be {0:.3g} deg (limit {1:.0f} deg); give a heading or an initial state",
      sigma / unit::deg, largest_heading_sigma / unit::deg, a.gyro_noise / unit::deg_per_sqrt_h,
      std::sqrt(a.gyro_bias_covariance.trace() / 3) / unit::deg_per_h));
}

constexpr double at_rest = 1e-3;  // m: a base that moves by less counts as unmoved

void warn_of_innovations(const FineAlignment& a, std::vector<std::string>& warnings) {
  const double scatter = 1 / std::sqrt(static_cast<double>(a.updates));
  if (a.base_displacement > at_rest)
    warnings.push_back(fmt::format(
        "alignment: the base moved by {:.2g} m (one sigma), or noise and biases are larger than declared; the stated uncertainty counts it as "
        "motion, and the solution starts with its velocity",
        a.base_displacement));
  if (a.base_displacement <= at_rest && std::abs(a.innovation_correlation) > 5 * scatter)
    warnings.push_back(fmt::format(
        "alignment: the innovations are correlated ({:.2f}); there are errors that are neither white noise nor constant, such as a drift, which the "
        "stated uncertainty does not count",
        a.innovation_correlation));
  if (a.innovation_square > 1 + 5 * scatter)
    warnings.push_back(
        fmt::format("alignment: the innovations are {:.2g} times as large as the stated noise explains; its uncertainty is understated",
                    std::sqrt(a.innovation_square)));
  if (a.innovation_square < 1 - 5 * scatter)
    warnings.push_back(
        fmt::format("alignment: the innovations are only {:.2g} times as large as the stated noise explains; its uncertainty is overstated",
                    std::sqrt(a.innovation_square)));
}

/// The first one declared; or the first one found that is long enough to align on, less a window on either side, in which motion may begin or end.
Range first_rest(const Recording& recording, const Session& session) {
  const std::vector<Range> rests = rests_of(recording, session).ranges;
  if (rests.empty())
    throw Unsupported(recording.name + ": no rest was found to align on; give an initial state with an attitude, or a recording that begins at rest");
  if (!session.steps.empty()) return rests.front();
  const auto inside = [&](const Range& rest) -> Range {
    const auto margin = std::min(static_cast<std::size_t>(RestOptions{}.window_s / recording.interval_s), rest.size() / 4);
    return {rest.begin + margin, rest.end - margin};
  };
  for (const Range& rest : rests)
    if (static_cast<double>(inside(rest).size()) * recording.interval_s >= shortest_alignment + recording.interval_s) return inside(rest);
  return inside(rests.front());
}

/// Covariance of the compensated output at the mean reading of the rest, from the calibration: constant errors of the alignment's sensors.
AlignmentSensors sensors_of(const Calibration& calibration, const ImuDeclaration& imu, const RawSample& raw) {
  const Eigen::Matrix<double, 6, 6> P = output_covariance(calibration, raw);  // force, then rate
  return {P.bottomRightCorner<3, 3>(), P.topLeftCorner<3, 3>(), imu.gyro_noise_density, imu.accel_noise_density};
}

Start aligned_start(const Calibration& calibration, const Session& session, const Recording& compensated, const NavigateOptions& options) {
  Start start;
  start.state = position_of(session, start.warnings);
  const Range range = first_rest(compensated, session);
  const InertialSamples rest = inertial_samples(compensated, range);
  const AlignmentSensors sensors = sensors_of(calibration, session.imu, mean_reading(calibration.model, compensated, range));
  const double gravity = session.site.given_gravity.value_or(local_earth(start.state.latitude, start.state.height).gravity.norm());
  const FineAlignment a = fine_alignment(rest.steps, {start.state.latitude, gravity}, sensors, options.heading);
  check_heading(a);
  warn_of_innovations(a, start.warnings);
  start.state.q_nb = Eigen::Quaterniond(a.attitude.C_nb);
  if (a.base_displacement > at_rest) start.state.velocity.head<2>() = a.base_velocity;
  start.time = rest.time.back();
  start.aligned = {a, rest.begin, rest.time.back()};
  return start;
}

Start given_start(const InitialState& initial) {
  NavigationState state;
  state.latitude = initial.latitude;
  state.longitude = initial.longitude;
  state.height = initial.height;
  state.velocity = {initial.velocity_enu[0], initial.velocity_enu[1], initial.velocity_enu[2]};
  state.q_nb = Eigen::Quaterniond(attitude_matrix({initial.roll, initial.pitch, initial.heading}));
  return {state, initial.time};
}

}  // namespace

Start start_of(const Calibration& calibration, const Session& session, const Recording& compensated, const NavigateOptions& options) {
  const bool align = options.align || options.heading || !session.initial;
  return align ? aligned_start(calibration, session, compensated, options) : given_start(*session.initial);
}

}  // namespace imulab::navigation
