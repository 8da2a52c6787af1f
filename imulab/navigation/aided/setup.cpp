#include "imulab/navigation/aided/setup.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/model/filter_flicker.hpp"
#include "imulab/navigation/aided/aid_motion.hpp"
#include "imulab/navigation/aided/pose.hpp"
#include "imulab/navigation/inertial_samples.hpp"
#include "imulab/recording/aid_clock.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// One-sigma defaults for undeclared properties of an aid.
constexpr double lever_sigma = 1, scale_sigma = 0.02;  // m, relative
constexpr double delay_sigma = 0.2;                    // s: for an aid on the recording's clock
constexpr double clock_sigma = 300e-6;                 // rate error of a logger's clock relative to the aid's
constexpr double mount_sigma = 20 * unit::deg;
constexpr double unknown_scale = 0.2;                                         // relative: of a first guess by accelerations
constexpr double odometry_position = 0.1, odometry_attitude = 1 * unit::deg;  // m: of slow errors, whose size is estimated
constexpr double flicker_time = 100;                                          // s: time over which an offset's flicker equals its bias instability

double density(const std::optional<double>& declared, const Vector3d* rest, Eigen::Index axis, double of_grade) {
  if (declared) return *declared;
  if (rest && (*rest)[axis] > 0) return (*rest)[axis];
  return of_grade;
}

std::size_t add_source(Problem& p, std::string name) {
  p.sources.push_back({std::move(name)});
  return p.sources.size() - 1;
}

constexpr std::array axes{"x", "y", "z"}, lever_arms{"right", "forward", "up"};
constexpr std::array angles{"pitch", "yaw"}, tilts{"east", "north"};
constexpr std::array components{"east", "north", "up"};
constexpr double body_sigma = 5 * unit::deg, free_tilt = 5 * unit::deg, upright_tilt = 0.5 * unit::deg;  // of a first guess, or declared

/// Constants that have names of their own below that of the block.
StateBlock constants(const std::string& name, const VectorXd& prior, std::span<const char* const> elements) {
  StateBlock block{.name = name, .size = prior.size(), .prior = prior, .walk = {}, .noise = {}};
  for (const char* element : elements) block.elements.push_back(name + "." + element);
  return block;
}

StateBlock constant(const std::string& name, double prior) {
  return {.name = name, .elements = {name}, .size = 1, .prior = VectorXd::Constant(1, prior), .walk = {}, .noise = {}};
}

/// Of a 3 x 3 matrix, column by column.
StateBlock constants(const std::string& name, const Matrix3d& prior) {
  constexpr std::array elements{"xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", "zz"};
  return constants(name, Eigen::Map<const VectorXd>(prior.data(), 9), elements);
}

Index add_markov(Problem& p, const std::string& name, Index size, double sigma, double time) {
  return add_block(
      p,
      {.name = name, .size = size, .prior = VectorXd::Constant(size, sigma), .time = time, .sigma = sigma, .walk = {}, .noise = add_source(p, name)});
}

void add_sensors(Problem& p, const SensorPriors& priors, const SetupOptions& options) {
  p.size = At::sensors;
  p.gyro_source = add_source(p, "gyro"), p.accel_source = add_source(p, "accel");
  const FilterFlicker gyro(priors.gyro_flicker), accel(priors.accel_flicker);
  const auto offset = [&](const std::string& name, const Vector3d& prior, double K, const FilterFlicker& flicker) {
    StateBlock block = constants(name + ".offset", prior, axes);
    block.walk = Vector3d::Constant(std::hypot(K, flicker.walk)), block.noise = add_source(p, name + ".drift");
    return add_block(p, std::move(block));
  };
  const auto process = [&](const std::string& name, const FilterFlicker& flicker) -> Index {
    return flicker.sigma > 0 ? add_markov(p, name + ".flicker", 3, flicker.sigma, FilterFlicker::time) : -1;
  };
  p.gyro_offset = offset("gyro", priors.gyro_offset, priors.gyro_walk, gyro);
  p.accel_offset = offset("accel", priors.accel_offset, priors.accel_walk, accel);
  p.gyro_flicker = process("gyro", gyro), p.accel_flicker = process("accel", accel);
  p.gyro_white = priors.gyro_noise.unaryExpr([&](double N) { return std::hypot(N, gyro.white); });
  p.accel_white = priors.accel_noise.unaryExpr([&](double N) { return std::hypot(N, accel.white); });
  if (options.matrices) {
    p.gyro_matrix = add_block(p, constants("gyro.matrix", priors.gyro_matrix));
    p.accel_matrix = add_block(p, constants("accel.matrix", priors.accel_matrix));
    p.g_sensitivity = add_block(p, constants("gyro.g_sensitivity", priors.g_sensitivity));
  }
  if (options.gyro_delay_sigma > 0) p.gyro_delay = add_block(p, constant("imu.gyro_delay", options.gyro_delay_sigma));
  p.sensors_end = p.size;
  if (priors.covariance.size() == 0) return;
  std::vector<Index> states;
  for (const auto& [first, size] : {std::pair{p.gyro_offset, 3}, {p.accel_offset, 3}, {p.gyro_matrix, 9}, {p.accel_matrix, 9}, {p.g_sensitivity, 9}})
    for (Index k = 0; k < size && first >= 0; ++k) states.push_back(first + k);
  p.joint = Eigen::MatrixXd::Zero(p.sensors_end, p.sensors_end);
  p.joint(states, states) = priors.covariance.topLeftCorner(std::ssize(states), std::ssize(states));
  p.joint.diagonal().setZero();
}

/// Returns the typical sigma of one axis of a receiver's positions.
double typical_position_sigma(const Aid& aid) {
  std::vector<double> all;
  for (std::size_t i = 0; i < aid.record.time.size(); i += 1 + aid.record.time.size() / 1000) all.push_back(position_sigma(aid, i).mean());
  return median(all);
}

/// Removes the common part from stated sigmas of heights that are far larger than the horizontal sigmas: such heights lack a reference, as above an
/// unknown geoid. Returns the common part, or 0.
double take_level(Aid& aid) {
  constexpr double dilution = 4, usual = 2;  // ratio of vertical to horizontal sigma for satellites above the horizon
  std::vector<Vector3d>& rows = aid.record.position_sigma;
  std::vector<double> levels;
  const auto stated = [&](std::size_t row) { return position_sigma(aid, row); };
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (stated(i).z() > dilution * stated(i).head<2>().mean()) levels.push_back(stated(i).z());
  if (2 * levels.size() <= rows.size()) return 0;
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].z() = std::min(stated(i).z(), usual * stated(i).head<2>().mean());
  return median(std::move(levels));
}

Eigen::Index add_slow(Problem& p, Channel& c, const std::string& name, Eigen::Index size, double sigma, double time) {
  return add_markov(p, name, size, sigma, c.aid.correlation.value_or(time));
}

void add_channel(Problem& p, const Aid& aid, const std::string& name) {
  Channel c{.name = name, .aid = aid};
  const auto lever = [&] {
    c.lever = add_block(p, constants(name + ".lever_arm", Vector3d::Constant(aid.lever_arm_sigma.value_or(lever_sigma)), lever_arms));
  };
  const auto delay = [&] {
    const double sigma = aid.delay_sigma.value_or(aid.scale == TimeScale::recording ? delay_sigma : guessed_offset_sigma);
    StateBlock block = constant(name + ".delay", sigma);
    block.elements.push_back(name + ".delay.drift");
    block.size = 2, block.prior = Eigen::Vector2d(sigma, clock_sigma);
    c.delay = add_block(p, std::move(block));
  };
  const auto mount = [&] { c.mount = add_block(p, constants(name + ".mounting", VectorXd::Constant(2, mount_sigma), angles)); };
  switch (aid.kind) {
    case AidKind::gnss: {
      c.first_noise = add_source(p, name + ".position"), c.second_noise = add_source(p, name + ".velocity");
      lever(), delay();
      if (aid.record.position.empty()) break;
      if (const double level = take_level(c.aid); level > 0) c.level = add_block(p, constant(name + ".height_level", level));
      const double sigma = typical_position_sigma(c.aid);
      c.slow = add_slow(p, c, name + ".slow_error", 3, sigma, sigma < 0.1 ? 20 : 60);
      break;
    }
    case AidKind::vehicle:
      c.first_noise = add_source(p, name + ".side"), c.second_noise = add_source(p, name + ".up");
      lever(), mount();
      c.slow = add_slow(p, c, name + ".side_slip", 2, 2 * value_sigma(aid, 0), 2);
      break;
    case AidKind::wheels:
      c.first_noise = add_source(p, name);
      lever(), mount(), delay();
      c.scale = add_block(p, constant(name + ".scale", scale_sigma));
      if (aid.correlation) c.slow = add_slow(p, c, name + ".slow_error", 1, value_sigma(aid, 0), *aid.correlation);
      break;
    case AidKind::barometer:
      c.first_noise = add_source(p, name);
      if (aid.lever_arm || aid.lever_arm_sigma) lever();
      delay();
      c.slow = add_slow(p, c, name + ".slow_error", 1, 20, 3600);
      break;
    case AidKind::heading:
      c.first_noise = add_source(p, name);
      delay();
      c.slow = add_slow(p, c, name + ".slow_error", 1, value_sigma(aid, 0), 60);
      break;
    case AidKind::pose:
    case AidKind::attitude:
    case AidKind::odometry:
      c.first_noise = add_source(p, name + ".position"), c.second_noise = add_source(p, name + ".attitude");
      if (aid.kind != AidKind::attitude) lever();
      delay();
      c.body = add_block(p, constants(name + ".body", VectorXd::Constant(3, body_sigma), axes));
      c.tilt = add_block(p, constants(name + ".tilt", VectorXd::Constant(2, aid.frame == AidFrame::free ? free_tilt : upright_tilt), tilts));
      if (!aid.scale_known) c.scale = add_block(p, constant(name + ".scale", unknown_scale));
      if (aid.kind != AidKind::odometry) break;
      c.slow = add_slow(p, c, name + ".slow_error", 3, odometry_position, 100);
      c.slow_turn = add_slow(p, c, name + ".slow_turn", 3, odometry_attitude, 100);
      break;
    case AidKind::zero_velocity:
      c.first_noise = add_source(p, name + ".velocity"), c.second_noise = add_source(p, name + ".rate");
      break;
  }
  p.channels.push_back(std::move(c));
}

/// Sets the origin of poses, and the Earth's rate in the level axes of their frame if it is not known to point north. Without a latitude all of it is
/// unknown.
void set_level_axes(Problem& p, const std::vector<Aid>& aids, const Site& site) {
  const double latitude = site.latitude.value_or(45 * unit::deg);
  p.half_instant = 0;
  p.place = {latitude, site.longitude.value_or(0), site.height.value_or(0)};
  if (!site.latitude && !p.gravity) site.gravity();  // throws an Error that names both
  if (site.latitude && std::ranges::any_of(aids, [](const Aid& aid) { return has_attitude(aid.kind) && aid.frame == AidFrame::north; })) return;
  const double level = site.latitude ? earth_rate * std::cos(latitude) / std::numbers::sqrt2 : earth_rate / std::numbers::sqrt3;
  if (site.latitude) p.vertical_earth_rate = earth_rate * std::sin(latitude);
  const double up = site.latitude ? earth_rate * site.latitude_sigma.value_or(0.1 * unit::deg) : level;
  p.earth_rate = add_block(p, constants("earth_rate", Vector3d(level, level, up), components));
  p.sensors_end = p.size;
  if (p.joint.size() > 0) p.joint.conservativeResizeLike(Eigen::MatrixXd::Zero(p.size, p.size));
}

bool inside(const std::vector<Outage>& outages, double t) {
  return std::ranges::any_of(outages, [&](const Outage& o) { return t >= o.begin && t < o.end; });
}

void add_observations(Problem& p, std::size_t channel, const Recording& recording, const Session& session, const SetupOptions& options) {
  const Aid& aid = p.channels[channel].aid;
  if (aid.kind == AidKind::vehicle) {
    for (double t = p.begin + options.vehicle_interval; t <= p.time.back(); t += options.vehicle_interval)
      p.observations.push_back({.stamp = t, .channel = channel});
  } else if (aid.kind == AidKind::zero_velocity) {
    constexpr double edge = 0.3;  // s: rests are found in windows of half a second
    for (const Range& rest : rests_of(recording, session).ranges)
      for (double t = recording.time_s(rest.begin) + edge; t <= recording.time_s(rest.end - 1) - edge; t += options.rest_interval)
        p.observations.push_back({.stamp = t, .channel = channel});
  } else {
    for (std::size_t row = 0; row < aid.record.time.size(); ++row) {
      const double t = 1e-9 * static_cast<double>(aid.record.time[row]);
      p.observations.push_back({t, channel, row, inside(aid.outages, t) || inside(options.outages, t)});
    }
  }
}

/// Returns true if all receivers and wheels are at rest until `end` within their sigmas and there are some, or there is an initial state at rest: for
/// an IMU, steady motion resembles a rest.
bool still_by_aids(const Problem& p, const std::optional<InitialState>& initial, double end) {
  constexpr double slow = 0.3;  // m/s
  std::optional<Vector3d> first;
  bool any = initial && initial->time <= end;
  if (any && Vector3d(initial->velocity_enu[0], initial->velocity_enu[1], initial->velocity_enu[2]).norm() > slow) return false;
  return std::ranges::none_of(p.observations,
                              [&](const Observation& o) {
                                const Aid& aid = p.channels[o.channel].aid;
                                if (o.stamp > end || o.withheld) return false;
                                any = any || aid.kind == AidKind::wheels || aid.kind == AidKind::gnss;
                                return shows_motion(aid, o.row, first);
                              }) &&
         any;
}

}  // namespace

double offset_walk(const NoiseModel& n) { return std::hypot(n.K, n.B / std::sqrt(flicker_time)); }

namespace {

/// Indices among the constants of the sensors; matrices are column by column.
enum ConstantPlace : Index {
  gyro_offset_at = 0,
  accel_offset_at = 3,
  gyro_matrix_at = 6,
  accel_matrix_at = 15,
  g_sensitivity_at = 24,
  all_constants = 33
};

/// Returns the derivatives of the constants by the coefficients, one row for each constant.
Eigen::MatrixXd constants_by(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(all_constants, std::ssize(coefficients));
  for (std::size_t a = 0; a < coefficients.size(); ++a) {
    const Coefficient& c = coefficient(coefficients[a]);
    const bool gyro = c.triad == Triad::gyro;
    const TriadModel& m = triad_model(model, c.triad);
    auto by = out.col(static_cast<Index>(a));
    const Matrix3d to_raw = m.matrix.inverse();
    if (c.term == Term::offset) by[(gyro ? gyro_offset_at : accel_offset_at) + c.row] = 1;
    if (c.term == Term::g_sensitivity) by[g_sensitivity_at + 3 * c.column + c.row] = 1;
    if (c.term != Term::matrix) continue;
    by[(gyro ? gyro_offset_at : accel_offset_at) + c.row] = -(to_raw * m.offset)[c.column];  // derivative by the matrix: raw readings at zero output
    for (Index j = 0; j < 3; ++j) by[(gyro ? gyro_matrix_at : accel_matrix_at) + 3 * j + c.row] = to_raw(c.column, j);
  }
  return out;
}

}  // namespace

void take_coefficients(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Eigen::MatrixXd& covariance,
                       SensorPriors& out) {
  const Eigen::MatrixXd by = constants_by(model, coefficients);
  out.covariance = by * covariance * by.transpose();
  const VectorXd sigma = out.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  out.gyro_offset = sigma.segment<3>(gyro_offset_at), out.accel_offset = sigma.segment<3>(accel_offset_at);
  out.gyro_matrix = Eigen::Map<const Matrix3d>(sigma.data() + gyro_matrix_at);
  out.accel_matrix = Eigen::Map<const Matrix3d>(sigma.data() + accel_matrix_at);
  out.g_sensitivity = Eigen::Map<const Matrix3d>(sigma.data() + g_sensitivity_at);
}

void take_noise(const NoiseModel& gyro, const NoiseModel& accel, SensorPriors& out) {
  const auto with = [](const NoiseModel& n, Vector3d& offset, Vector3d& white, double& walk, double& flicker) {
    for (double& sigma : offset) sigma = std::hypot(sigma, FilterFlicker(n.B).start);
    white.setConstant(n.N), walk = n.K, flicker = n.B;
  };
  with(gyro, out.gyro_offset, out.gyro_noise, out.gyro_walk, out.gyro_flicker);
  with(accel, out.accel_offset, out.accel_noise, out.accel_walk, out.accel_flicker);
}

SensorPriors sensor_priors(const Calibration& calibration, const ImuDeclaration& imu) {
  const Grade& g = grade(imu.grade.value_or("mems"));
  const bool known = !calibration.estimated.empty();
  SensorPriors out;
  take_coefficients(calibration.model, calibration.estimated, calibration.covariance, out);
  const auto estimated = [&](Triad triad, Term term, int i, int j) {
    return std::ranges::find(calibration.estimated, coefficient_index(triad, term, i, j)) != calibration.estimated.end();
  };
  const auto matrix_known = [&](Triad triad, int i, int j) {  // also fixed by the frame
    if (estimated(triad, Term::matrix, i, j)) return true;
    const std::string name(coefficient(coefficient_index(triad, Term::matrix, i, j)).name);
    bool any = false;
    for (int k = 0; k < 9; ++k) any = any || estimated(triad, Term::matrix, k / 3, k % 3);
    return any && std::ranges::find(calibration.quality.unobservable, name) == calibration.quality.unobservable.end();
  };
  const NoiseModel gyro = imu.gyro_noise.value_or(g.gyro_noise), accel = imu.accel_noise.value_or(g.accel_noise);
  const RestNoise* rest = calibration.rest_noise ? &*calibration.rest_noise : nullptr;
  for (int i = 0; i < 3; ++i) {
    if (!estimated(Triad::gyro, Term::offset, i, i)) out.gyro_offset[i] = g.gyro_bias;
    if (!estimated(Triad::accel, Term::offset, i, i)) out.accel_offset[i] = g.accel_bias;
    if (known) out.gyro_offset[i] = std::hypot(out.gyro_offset[i], gyro.turn_on.value);
    if (known) out.accel_offset[i] = std::hypot(out.accel_offset[i], accel.turn_on.value);
    for (int j = 0; j < 3; ++j) {
      const bool scale = i == j;
      if (!matrix_known(Triad::gyro, i, j)) out.gyro_matrix(i, j) = scale ? g.gyro_scale : g.gyro_misalignment;
      if (!matrix_known(Triad::accel, i, j)) out.accel_matrix(i, j) = scale ? g.accel_scale : g.accel_misalignment;
      if (!estimated(Triad::gyro, Term::g_sensitivity, i, j)) out.g_sensitivity(i, j) = g.g_sensitivity;
    }
  }
  out.gyro_walk = offset_walk(gyro), out.accel_walk = offset_walk(accel);
  for (int i = 0; i < 3; ++i) {
    out.gyro_noise[i] = density(imu.gyro_noise_density, rest ? &rest->gyro : nullptr, i, gyro.N);
    out.accel_noise[i] = density(imu.accel_noise_density, rest ? &rest->accel : nullptr, i, accel.N);
  }
  return out;
}

Problem make_problem(const Recording& recording, const SensorPriors& priors, const std::vector<Aid>& aids, const Session& session,
                     const SetupOptions& options) {
  Problem p;
  p.samples = IncrementView(recording);
  p.time.reserve(p.samples.size());
  for_each_increment(recording, {0, recording.size()}, [&](const TimedIncrement&, double end) { p.time.push_back(end); });
  p.begin = recording.time_s(0) - recording.interval(0, false), p.interval = recording.interval_s;
  p.gravity = session.site.given_gravity;
  p.gyro_noise = priors.gyro_noise, p.accel_noise = priors.accel_noise;
  add_sensors(p, priors, options);
  if (std::ranges::any_of(aids, [](const Aid& aid) { return has_attitude(aid.kind); })) set_level_axes(p, aids, session.site);
  for (const Aid& aid : aids) {
    const std::string kind(aid_law(aid.kind).name);
    const auto same = std::ranges::count(aids.begin(), aids.begin() + (&aid - aids.data()), aid.kind, &Aid::kind);
    add_channel(p, aid, same > 0 ? fmt::format("{}{}", kind, same + 1) : kind);
    add_observations(p, p.channels.size() - 1, recording, session, options);
  }
  std::ranges::stable_sort(p.observations, {}, &Observation::stamp);
  std::erase_if(p.observations, [&](const Observation& o) { return o.stamp < p.begin - 1 || o.stamp > p.time.back() + 1; });
  align_channels(p, recording);
  if (p.observations.empty()) throw Error(recording.name + ": no aid has an observation during the recording; expected times that overlap");
  return p;
}

void add_first_rest(Problem& p, const Recording& recording, const Session& session) {
  constexpr double shortest = 15;  // s
  if (std::ranges::any_of(p.channels, [](const Channel& c) { return c.aid.kind == AidKind::zero_velocity; })) return;
  const std::vector<Range> rests = rests_of(recording, session).ranges;
  if (rests.empty() || recording.time_s(rests.front().begin) > p.begin + 1) return;
  const double end = recording.time_s(rests.front().end - 1);
  if (end - p.begin < shortest || !still_by_aids(p, session.initial, end)) return;
  add_channel(p, {.kind = AidKind::zero_velocity}, std::string(aid_law(AidKind::zero_velocity).name));
  const std::size_t own = p.channels.size() - 1;
  add_observations(p, own, recording, session, {});
  std::erase_if(p.observations, [&](const Observation& o) { return o.channel == own && o.stamp > end; });
  std::ranges::stable_sort(p.observations, {}, &Observation::stamp);
}

Prior prior_of(const Problem& p) {
  Prior out{VectorXd::Zero(p.size), VectorXd::Zero(p.size)};
  for (const StateBlock& b : p.blocks) out.sigma.segment(b.first, b.size) = b.prior.cwiseMax(1e-12);
  for (const Channel& c : p.channels) {
    if (c.lever >= 0 && c.aid.lever_arm) out.mean.segment<3>(c.lever) = *c.aid.lever_arm;
    if (c.delay >= 0) out.mean[c.delay] = c.aid.delay.value_or(0);
  }
  if (p.earth_rate >= 0) out.mean[p.earth_rate + 2] = p.vertical_earth_rate;
  return out;
}

}  // namespace imulab::aided
