#include "imulab/navigate.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/inertial_samples.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace imulab::navigation {

/// The start of navigation: a given state, or the alignment on the first rest.
struct Start {
  NavigationState state;
  double time = 0;  // s
  std::optional<AlignedOn> aligned = {};
  std::vector<std::string> warnings = {};
};

namespace {

/// Returns the reading whose compensation is the mean of a range. It differs from the mean raw reading by the effect of noise on nonlinearity.
RawSample mean_reading(const SensorModel& model, const Recording& r, const Range& range) {
  const auto mean = [&](const Columns3& columns, const auto& value) {
    Vector3d out = Vector3d::Zero();
    if (columns[0].empty()) return out;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = range.begin; i < range.end; ++i)
        out[static_cast<Eigen::Index>(k)] += value(columns[k][i]) / static_cast<double>(range.size());
    return out;
  };
  const auto tau = [&](const TriadModel& m, const Columns3& temperature) {
    return m.temperature ? mean(temperature, [&](double t) { return m.temperature->tau(t); }) : Vector3d(Vector3d::Zero());
  };
  const auto as_read = [](double reading) { return reading; };
  return decompensate(model, {.rate = mean(r.gyro, as_read), .force = mean(r.accel, as_read)}, tau(model.gyro, r.gyro_temperature),
                      tau(model.accel, r.accel_temperature));
}

/// Returns the position of the session's initial state, or else of its site.
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
    throw Error((session.file.empty() ? "session" : session.file) +
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
      "alignment: gyros with {2:.2g} deg/sqrt(h) and biases of u = {3:.2g} deg/h do not resolve the Earth's rate in this rest; the sigma of "
      "the heading would be {0:.3g} deg (limit {1:.0f} deg); give the heading (--heading) or an initial state",
      sigma / unit::deg, largest_heading_sigma / unit::deg, a.gyro_noise / unit::deg_per_sqrt_h,
      std::sqrt(a.gyro_bias_covariance.trace() / 3) / unit::deg_per_h));
}

constexpr double at_rest = 1e-3;  // m: a base that moves by less counts as still

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

/// Returns the first declared rest; or the first one found that is long enough, shortened by a window at both ends, where motion may begin or end.
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

/// Returns the constant sensor errors for the alignment: the covariance of the compensated output at the mean reading of the rest.
AlignmentSensors sensors_of(const Calibration& calibration, const ImuDeclaration& imu, const RawSample& raw) {
  const Eigen::Matrix<double, 6, 6> P = output_covariance(calibration, raw);  // rate, then force
  return {P.topLeftCorner<3, 3>(), P.bottomRightCorner<3, 3>(), imu.gyro_noise_density, imu.accel_noise_density};
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

/// Returns the start of a `compensated` recording. Throws like navigate.
Start start_of(const Calibration& calibration, const Session& session, const Recording& compensated, const NavigateOptions& options) {
  const bool align = options.align || options.heading || !session.initial;
  return align ? aligned_start(calibration, session, compensated, options) : given_start(*session.initial);
}

}  // namespace imulab::navigation

namespace imulab {

namespace {

/// The integrated increments: those that end after `time`, the first one from there.
struct IntegratedSteps {
  Range range;  // samples with such increments
  double time, tolerance;
  bool at_begin;  // at the begin of the recording
};

IntegratedSteps steps_from(const Recording& r, double time, const NavigateOptions& options, std::vector<MissingTime>& gaps) {
  const double begin = r.time_s(0) - r.interval(0, false), end = r.time_s(r.size() - 1), tolerance = 1e-3 * r.interval_s;
  const bool at_begin = std::abs(time - begin) < r.interval_s / 2;  // the first stamp may be late or early: its sample is whole
  if ((time < begin && !at_begin) || time >= end - tolerance)
    throw Error(fmt::format("{}: navigation starts at {:.6f} s, expected inside the recording, {:.6f} s to {:.6f} s, and before its end", r.name,
                            time, begin, end));
  Range range{0, r.size()};
  while (r.time_s(range.begin) <= time + tolerance) ++range.begin;
  const bool inside_gap = r.time_s(range.begin) - r.interval(range.begin, false) > time + tolerance;
  if (inside_gap && range.begin > 0) --range.begin;  // its end is before the start: bridged from there
  gaps = missing_time(r, range);
  if (options.gaps == GapTreatment::refuse && !gaps.empty())
    throw Error(fmt::format("{}: {:.6f} s are missing after {:.6f} s, and gaps are to be refused", r.name, gaps.front().length, gaps.front().begin));
  return {range, time, tolerance, at_begin};
}

void for_each_step(const Recording& r, const IntegratedSteps& steps, const std::function<void(const TimedIncrement&, double)>& each) {
  bool first = true;
  for_each_increment(r, steps.range, [&](const TimedIncrement& step, double end) {
    if (end <= steps.time + steps.tolerance) return;
    if (!std::exchange(first, false)) return each(step, end);
    const double left = end - steps.time, part = left / step.interval;
    if (steps.at_begin) return each({step.increment, left}, end);
    if (std::abs(left - step.interval) > steps.tolerance) return each({{part * step.increment.angle, part * step.increment.velocity}, left}, end);
    each(step, end);
  });
}

/// Returns the linearly interpolated height.
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
    throw Error(fmt::format("vertical channel {}: no barometer's heights; expected them, or the vertical channel free or fixed",
                            to_string(options.vertical)));
  validate(*options.barometer);
  const auto& time = options.barometer->time;
  if (time.empty() || time.front() > begin + 1 || time.back() < end - 1)
    throw Error(fmt::format("barometer: runs from {:.3f} s to {:.3f} s, expected all of {:.3f} s to {:.3f} s", time.empty() ? 0 : time.front(),
                            time.empty() ? 0 : time.back(), begin, end));
}

/// Warns of an implausible force: it is about g most of the time on the ground and in the air, so half or twice as much means another unit of
/// readings, or a calibration of another IMU.
void warn_of_force(std::vector<double> forces, const std::string& name, std::vector<std::string>& warnings) {
  const double middle = median(std::move(forces));
  if (middle > 0.5 * unit::g && middle < 2 * unit::g) return;
  warnings.push_back(
      fmt::format("{}: the compensated specific force is {:.3g} m/s^2 (median), expected about g: is the calibration that of this unit, "
                  "and are the session's units right? The solution is invalid otherwise",
                  name, middle));
}

void integrate(const navigation::Start& start, const IntegratedSteps& steps, const Session& session, const Recording& recording,
               const NavigateOptions& options, Navigated& out) {
  check_barometer(options, steps.time, recording.time_s(recording.size() - 1));
  Strapdown strapdown(start.state, {.vertical = options.vertical, .gravity = session.site.given_gravity});
  Solution& solution = out.solution;
  const auto add = [&](double time) {
    if (!options.keep && solution.size() == 2) solution.time.pop_back(), solution.states.pop_back();
    solution.time.push_back(time);
    solution.states.push_back(strapdown.state());
    if (options.each) options.each(time, strapdown.state());
  };
  constexpr std::size_t enough = 100'000;
  std::vector<double> forces;  // forces of the steps, or of a sample of them
  const std::size_t every = steps.range.size() / enough + 1;
  if (options.keep) solution.time.reserve(steps.range.size() + 1), solution.states.reserve(steps.range.size() + 1);
  add(start.time);
  std::size_t taken = 0;
  constexpr std::size_t places = 5'000;
  const std::size_t drawn = steps.range.size() / places + 1;
  out.track.push_back(strapdown.state());
  for_each_step(recording, steps, [&](const TimedIncrement& step, double end) {
    if (taken++ % every == 0) forces.push_back(step.increment.velocity.norm() / step.interval);
    std::optional<double> height;
    if (options.barometer) height = height_at(*options.barometer, end);
    if (!(step.increment.angle.norm() < 1e3 && step.increment.velocity.norm() < 1e6))  // far beyond any motion, but still possible to integrate
      throw Error(
          fmt::format("{}: the sample at {:.6f} s has increments of {:.3g} rad and {:.3g} m/s, beyond any motion; expected readings of an IMU",
                      recording.name, end, step.increment.angle.norm(), step.increment.velocity.norm()));
    strapdown.step(step.increment, step.interval, height);
    add(end);
    if (options.step) options.step(end, strapdown.state(), step.increment);
    if (taken % drawn == 0) out.track.push_back(strapdown.state());
  });
  if (taken % drawn != 0) out.track.push_back(strapdown.state());
  warn_of_force(std::move(forces), recording.name, out.warnings);
}

void warn_of_samples(const Recording& r, Navigated& out) {
  if (!out.gaps.empty()) {
    double sum = 0;
    for (const MissingTime& gap : out.gaps) sum += gap.length;
    out.warnings.push_back(
        fmt::format("{}: {} gap{} of {:.6g} s altogether, the first after {:.6f} s: integrated with rate and force linear in time from the "
                    "sample before to the one after; the true motion in between is not known",
                    r.name, out.gaps.size(), out.gaps.size() == 1 ? "" : "s", sum, out.gaps.front().begin));
  }
  const double start = out.solution.time.front();
  std::optional<double> first;
  for (const std::size_t i : r.saturated) {
    if (r.time_s(i) <= start) continue;
    if (!first) first = r.time_s(i);
    ++out.saturated;
  }
  out.doubtful = out.doubtful || first;
  if (first)
    out.warnings.push_back(
        fmt::format("{}: {} saturated sample{} integrated as read, the first at {:.6f} s: the true motion was larger, from "
                    "there on the solution is doubtful",
                    r.name, out.saturated, out.saturated == 1 ? "" : "s", *first));
  const bool rates = !r.gyro_increment || !r.accel_increment;
  if (const double jitter = stamp_jitter(r); jitter > 0.1)
    out.warnings.push_back(fmt::format(
        "{}: the stamps' differences scatter by {:.0f} % of the interval; {}", r.name, 100 * jitter,
        rates ? "rates are integrated over these differences. Where the stamps are late and the sampling is even, every rotation and every "
                "force is wrong by as much: give increments, or even stamps"
              : "increments are taken as they are, gravity by the stamps: each state is as late as its stamp"));
}

/// Warns of height errors, which grow as cosh(k t), where k^2 is the decrease of gravity with height: a hundredfold in 50 min.
void warn_of_height(const std::string& name, double duration, Navigated& out) {
  constexpr double k = 1 / 570.0, tolerable = 100;  // k in 1/s
  if (out.vertical != VerticalChannel::free || std::cosh(k * duration) < tolerable) return;
  out.doubtful = true;
  out.warnings.push_back(
      fmt::format("{}: the vertical channel is free for {:.0f} min, and a height error grows by a factor of e every 9.5 min: in the end height and "
                  "vertical velocity mean nothing, and spoil the rest; expected a fixed vertical channel, or a barometer",
                  name, duration / 60));
}

}  // namespace

Navigated navigate(const Calibration& calibration, const Session& session, Recording raw, const NavigateOptions& options) {
  standard_uncertainty(calibration, coefficient_indices().front());  // checks the size of the covariance
  validate(session), validate(raw);
  if (options.heading) validate(*options.heading);
  Navigated out;
  out.vertical = options.vertical;
  constexpr double in_place = 1.4, with_states = 3.2;  // relative to the recording; a state takes 88 bytes
  expect_memory((options.keep ? with_states : in_place) * static_cast<double>(raw.bytes()),
                raw.name + (options.keep ? ": a navigation with a state for each sample" : ": a navigation"));
  CompensatedRecording compensated = compensate(calibration.model, std::move(raw));
  Recording& recording = compensated.recording;
  if (const std::size_t count = compensated.out_of_range.size(); count > 0)
    out.warnings.push_back(
        fmt::format("{}: {} of {} samples are outside the temperatures the calibration saw", recording.name, count, recording.size()));
  if (!calibration.model.lever_arm.isZero(0)) remove_lever_arms(recording, calibration.model.lever_arm);
  const navigation::Start start = navigation::start_of(calibration, session, recording, options);
  out.aligned = start.aligned;
  out.warnings.insert(out.warnings.end(), start.warnings.begin(), start.warnings.end());
  const IntegratedSteps steps = steps_from(recording, start.time, options, out.gaps);
  if (options.begin) options.begin({start.state, out.aligned, start.time, recording.time_s(recording.size() - 1), recording.interval_s});
  integrate(start, steps, session, recording, options, out);
  warn_of_samples(recording, out);
  warn_of_height(recording.name, recording.time_s(recording.size() - 1) - start.time, out);
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
