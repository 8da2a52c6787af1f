#include "imulab/analysis/navigate.hpp"

#include "imulab/analysis/compensate_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/recording/rests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

// ---- the start

/// Mean raw readings of a range, thermal ones less their reference.
RawSample mean_reading(const SensorModel& model, const Recording& r, const Range& range) {
  const auto mean = [&](const Columns3& columns, double origin) {
    Vector3d out = Vector3d::Zero();
    if (columns[0].empty()) return out;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = range.begin; i < range.end; ++i)
        out[static_cast<Eigen::Index>(k)] += (columns[k][i] - origin) / static_cast<double>(range.size());
    return out;
  };
  RawSample out{mean(r.accel, 0), mean(r.gyro, 0)};
  if (model.accel.temperature) out.accel_tau = mean(r.accel_temperature, model.accel.temperature->reference);
  if (model.gyro.temperature) out.gyro_tau = mean(r.gyro_temperature, model.gyro.temperature->reference);
  return out;
}

/// What the calibration's covariance says of the error at a reading: J P J^T, J by differences (the model is linear in its coefficients but for the
/// thermal ones). At a rest this error is constant: offsets, and whatever scale and misalignment do there.
Eigen::Matrix<double, 6, 6> error_covariance(const Calibration& calibration, const RawSample& raw) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, static_cast<Eigen::Index>(calibration.estimated.size()));
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const int index = calibration.estimated[static_cast<std::size_t>(k)];
    const double step = std::sqrt(calibration.covariance(k, k));
    SensorModel more = calibration.model, less = calibration.model;
    set_coefficient(more, index, coefficient_value(calibration.model, index) + step);
    set_coefficient(less, index, coefficient_value(calibration.model, index) - step);
    const Motion a = compensate(more, raw), b = compensate(less, raw);
    J.col(k).setZero();
    if (step > 0) J.col(k) << (a.rate - b.rate) / (2 * step), (a.force - b.force) / (2 * step);
  }
  return J * calibration.covariance * J.transpose();
}

/// Where the unit rests: [initial], or else [site].
NavigationState place_of(const Session& session, std::vector<std::string>& warnings) {
  NavigationState state;
  if (session.initial) {
    state.latitude = session.initial->latitude;
    state.longitude = session.initial->longitude;
    state.height = session.initial->height;
    return state;
  }
  const Site& site = session.site;
  if (!site.latitude)
    throw Error(session.file + ": neither [initial] nor [site] latitude_deg says where the unit is: alignment finds an attitude, not a place");
  if (!site.longitude) warnings.push_back("[site] has no longitude_deg: longitudes are counted from the start");
  if (!site.height) warnings.push_back("[site] has no height_m: heights are counted from the ellipsoid, gravity is that of height 0");
  state.latitude = *site.latitude;
  state.longitude = site.longitude.value_or(0);
  state.height = site.height.value_or(0);
  return state;
}

void check_heading(const FineAlignment& a) {
  const double sigma = std::sqrt(a.attitude.covariance(2, 2));
  if (sigma <= largest_heading_sigma) return;
  throw Unsupported(
      fmt::format("alignment: the heading cannot be found, its sigma would be {:.3g} deg (limit {:.0f} deg): gyros with {:.2g} "
                  "deg/sqrt(h) and biases known to {:.2g} deg/h do not resolve the Earth's rate in this rest; give a heading "
                  "(--heading) or [initial]",
                  sigma / unit::deg, largest_heading_sigma / unit::deg, a.gyro_noise / unit::deg_per_sqrt_h,
                  std::sqrt(a.gyro_bias_covariance.trace() / 3) / unit::deg_per_h));
}

constexpr double standing = 1e-3;  // m: a base that moves by less is taken to stand

void warn_of_innovations(const FineAlignment& a, std::vector<std::string>& warnings) {
  const double scatter = 1 / std::sqrt(static_cast<double>(a.updates));
  if (a.base_displacement > standing)
    warnings.push_back(
        fmt::format("alignment: the base moved by {:.2g} m (one sigma), or noise and biases are larger than declared; the stated "
                    "uncertainty takes it for motion, and the solution starts with its velocity",
                    a.base_displacement));
  if (a.base_displacement <= standing && std::abs(a.innovation_correlation) > 5 * scatter)
    warnings.push_back(
        fmt::format("alignment: each innovation follows the one before (correlation {:.2f}): errors that are neither white noise nor "
                    "constant, such as a drift, which the stated uncertainty does not know",
                    a.innovation_correlation));
  if (a.innovation_square > 1 + 5 * scatter)
    warnings.push_back(fmt::format("alignment: the innovations are {:.2g} times as large as the noise says; its uncertainty is understated",
                                   std::sqrt(a.innovation_square)));
  if (a.innovation_square < 1 - 5 * scatter)
    warnings.push_back(fmt::format("alignment: the innovations are only {:.2g} times as large as the noise says; its uncertainty is overstated",
                                   std::sqrt(a.innovation_square)));
}

/// The first as declared; or the first found that is long enough to align on, less a window on either side, in which the motion may have begun.
Range first_rest(const Recording& recording, const Session& session) {
  const std::vector<Range> rests = rests_of(recording, session).ranges;
  if (rests.empty())
    throw Unsupported(recording.name + ": no rest was found to align on; give [initial] with an attitude, or a recording that begins at rest");
  if (!session.steps.empty()) return rests.front();
  const auto inside = [&](const Range& rest) -> Range {
    const auto margin = std::min(static_cast<std::size_t>(RestOptions{}.window_s / recording.interval_s), rest.size() / 4);
    return {rest.begin + margin, rest.end - margin};
  };
  for (const Range& rest : rests)
    if (static_cast<double>(inside(rest).size()) * recording.interval_s >= shortest_alignment + recording.interval_s) return inside(rest);
  return inside(rests.front());
}

struct Start {
  NavigationState state;
  double time = 0;
};

Start aligned_start(const Calibration& calibration, const Session& session, const Recording& raw, const Recording& recording,
                    const NavigateOptions& options, Navigated& out) {
  Start start{place_of(session, out.warnings)};
  const Range range = first_rest(recording, session);
  const InertialSamples rest = inertial_samples(recording, range);
  const Eigen::Matrix<double, 6, 6> P = error_covariance(calibration, mean_reading(calibration.model, raw, range));
  const AlignmentSensors sensors{P.topLeftCorner<3, 3>(), P.bottomRightCorner<3, 3>(), session.imu.gyro_noise_density,
                                 session.imu.accel_noise_density};
  const double gravity = session.site.given_gravity.value_or(local_earth(start.state.latitude, start.state.height).gravity.norm());
  out.aligned = {fine_alignment(rest.steps, {start.state.latitude, gravity}, sensors, options.heading), rest.begin, rest.time.back()};
  check_heading(out.aligned->alignment);
  warn_of_innovations(out.aligned->alignment, out.warnings);
  const FineAlignment& a = out.aligned->alignment;
  start.state.q_nb = Eigen::Quaterniond(a.attitude.C_nb);
  if (a.base_displacement > standing) start.state.velocity.head<2>() = a.base_velocity;
  start.time = rest.time.back();
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

// ---- the way

/// The samples after `time`, the first one from there on.
InertialSamples samples_from(const Recording& r, double time, const NavigateOptions& options) {
  const double begin = r.time_s(0) - r.interval(0, false), end = r.time_s(r.size() - 1), tolerance = 1e-3 * r.interval_s;
  const bool at_begin = std::abs(time - begin) < r.interval_s / 2;  // the first stamp may be late or early: its sample is whole
  if ((time < begin && !at_begin) || time >= end - tolerance)
    throw Error(fmt::format("{}: navigation starts at {:.6f} s, expected inside the recording, {:.6f} s to {:.6f} s, and before its end", r.name,
                            time, begin, end));
  Range range{0, r.size()};
  while (r.time_s(range.begin) <= time + tolerance) ++range.begin;
  const bool inside_gap = r.time_s(range.begin) - r.interval(range.begin, false) > time + tolerance;
  if (inside_gap && range.begin > 0) --range.begin;  // whose end is before the start: bridged from there
  if (const auto gaps = missing_time(r, range); options.gaps == GapTreatment::refuse && !gaps.empty())
    throw Error(fmt::format("{}: {:.6f} s are missing after {:.6f} s, and gaps are to be refused", r.name, gaps.front().length, gaps.front().begin));
  InertialSamples samples = inertial_samples(r, range);
  const auto first = static_cast<std::ptrdiff_t>(std::upper_bound(samples.time.begin(), samples.time.end(), time + tolerance) - samples.time.begin());
  samples.steps.erase(samples.steps.begin(), samples.steps.begin() + first);
  samples.time.erase(samples.time.begin(), samples.time.begin() + first);
  TimedIncrement& step = samples.steps.front();
  const double left = samples.time.front() - time, part = left / step.interval;
  if (at_begin) step.interval = left;
  else if (std::abs(left - step.interval) > tolerance) step = {{part * step.increment.angle, part * step.increment.velocity}, left};
  samples.begin = time;
  return samples;
}

/// Straight between the record's heights.
double height_at(const HeightRecord& record, double time) {
  const auto after = std::upper_bound(record.time.begin(), record.time.end(), time);
  if (after == record.time.begin()) return record.height.front();
  if (after == record.time.end()) return record.height.back();
  const auto i = static_cast<std::size_t>(after - record.time.begin());
  const double part = (time - record.time[i - 1]) / (record.time[i] - record.time[i - 1]);
  return (1 - part) * record.height[i - 1] + part * record.height[i];
}

void check_barometer(const NavigateOptions& options, double begin, double end) {
  const bool needed = options.vertical == VerticalChannel::aided || options.vertical == VerticalChannel::held;
  if (!needed) return;
  if (!options.barometer)
    throw Error(
        fmt::format("vertical channel {}: needs a barometer's heights (--barometer FILE with columns t,height_m); expected them, or the "
                    "vertical channel free or fixed",
                    to_string(options.vertical)));
  const auto& time = options.barometer->time;
  if (time.empty() || time.front() > begin + 1 || time.back() < end - 1)
    throw Error(fmt::format("barometer: runs from {:.3f} s to {:.3f} s, expected all of {:.3f} s to {:.3f} s", time.empty() ? 0 : time.front(),
                            time.empty() ? 0 : time.back(), begin, end));
}

/// On the ground and in the air the specific force is about g most of the time; half of it or twice is another unit, or a calibration of another one.
void warn_of_force(const InertialSamples& samples, const std::string& name, std::vector<std::string>& warnings) {
  std::vector<double> forces;
  forces.reserve(samples.steps.size());
  for (const TimedIncrement& step : samples.steps) forces.push_back(step.increment.velocity.norm() / step.interval);
  const double middle = median(std::move(forces));
  if (middle > 0.5 * unit::g && middle < 2 * unit::g) return;
  warnings.push_back(fmt::format("{}: the compensated specific force is {:.3g} m/s^2 (median), expected about g: is the calibration that of this unit, "
                                 "and are the session's units right? The solution is worth nothing otherwise",
                                 name, middle));
}

void integrate(const Start& start, const InertialSamples& samples, const Session& session, const Recording& recording, const NavigateOptions& options,
               Navigated& out) {
  check_barometer(options, samples.begin, samples.time.back());
  warn_of_force(samples, recording.name, out.warnings);
  Strapdown strapdown(start.state, {.vertical = options.vertical, .gravity = session.site.given_gravity});
  out.solution.time.push_back(start.time);
  out.solution.states.push_back(strapdown.state());
  for (std::size_t i = 0; i < samples.steps.size(); ++i) {
    const TimedIncrement& step = samples.steps[i];
    std::optional<double> height;
    if (options.barometer) height = height_at(*options.barometer, samples.time[i]);
    if (!(step.increment.angle.norm() < 1e3 && step.increment.velocity.norm() < 1e6))  // far beyond any motion, and still to be integrated
      throw Error(fmt::format("{}: the sample at {:.6f} s turns by {:.3g} rad and pushes by {:.3g} m/s, which no motion does: expected readings of a unit",
                              recording.name, samples.time[i], step.increment.angle.norm(), step.increment.velocity.norm()));
    strapdown.step(step.increment, step.interval, height);
    out.solution.time.push_back(samples.time[i]);
    out.solution.states.push_back(strapdown.state());
  }
}

void warn_of_samples(const Recording& r, Navigated& out) {
  if (!out.gaps.empty()) {
    double sum = 0;
    for (const MissingTime& gap : out.gaps) sum += gap.length;
    out.warnings.push_back(
        fmt::format("{}: {} gap{} of {:.6g} s altogether, the first after {:.6f} s: integrated with rate and force straight from the "
                    "sample before to the one after; what the unit did in between is not known",
                    r.name, out.gaps.size(), out.gaps.size() == 1 ? "" : "s", sum, out.gaps.front().begin));
  }
  const double start = out.solution.time.front();
  std::optional<double> first;
  for (const std::size_t i : r.saturated) {
    if (r.time_s(i) <= start) continue;
    if (!first) first = r.time_s(i);
    ++out.saturated;
  }
  if (first)
    out.warnings.push_back(
        fmt::format("{}: {} saturated sample{} integrated as read, the first at {:.6f} s: the true motion was larger, from "
                    "there on the solution is doubtful",
                    r.name, out.saturated, out.saturated == 1 ? "" : "s", *first));
  const bool rates = !r.gyro_increment || !r.accel_increment;
  if (const double jitter = stamp_jitter(r); jitter > 0.1)
    out.warnings.push_back(
        fmt::format("{}: the stamps' differences scatter by {:.0f} % of the interval; {}", r.name, 100 * jitter,
                    rates ? "rates are taken to last as long as they say. Where the stamps are late and the sampling is even, every turn and "
                            "every force is integrated wrongly by as much: declare output = \"increment\", or even stamps"
                          : "increments are taken as they are, gravity by the stamps: each state is as late as its stamp"));
}

}  // namespace

Navigated navigate(const Calibration& calibration, const Session& session, const Recording& raw, const NavigateOptions& options) {
  Navigated out;
  out.vertical = options.vertical;
  CompensatedRecording compensated = compensate(calibration.model, raw);
  Recording& recording = compensated.recording;
  if (const std::size_t count = compensated.out_of_range.size(); count > 0)
    out.warnings.push_back(fmt::format("{}: {} of {} samples are outside the temperatures the calibration saw", raw.name, count, raw.size()));
  if (!calibration.model.lever_arm.isZero(0)) remove_lever_arms(recording, calibration.model.lever_arm);
  const bool align = options.align || options.heading || !session.initial;
  const Start start = align ? aligned_start(calibration, session, raw, recording, options, out) : given_start(*session.initial);
  const InertialSamples samples = samples_from(recording, start.time, options);
  out.gaps = samples.gaps;
  integrate(start, samples, session, recording, options, out);
  warn_of_samples(recording, out);
  return out;
}

Eigen::Vector3d angle_sigmas(const Alignment& a) {
  const double step = 1e-6;
  const auto angles = [&](int axis, double phi) {
    const EulerAngles e = euler_angles(rotation_exp(phi * Vector3d::Unit(axis)) * a.C_nb);
    return Vector3d(e.roll, e.pitch, e.heading);
  };
  Matrix3d jacobian;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 3; ++k) jacobian(k, axis) = std::remainder(angles(axis, step)[k] - angles(axis, -step)[k], 2 * std::numbers::pi) / (2 * step);
  return (jacobian * a.covariance * jacobian.transpose()).diagonal().cwiseSqrt();
}

}  // namespace imulab
