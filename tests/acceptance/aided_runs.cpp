// Aided navigation and the calibration from it, on drives and flights whose IMU, receiver and mounting are drawn: what is stated as good holds the
// truth.
#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/drive/coefficients.hpp"
#include "imulab/estimate/drive/drive.hpp"
#include "imulab/estimate/drive/unmodeled.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/simulate/effects.hpp"
#include "imulab/simulate/simulate_aid.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab::acceptance {

namespace {

using motion::Segment;

constexpr double sampling = 0.02;  // s
constexpr std::array carriers{"city with stops", "motorway", "hover", "fixed wing"};
constexpr std::array quantities{"determined coefficients", "coefficients",        "lever arms",        "delays",
                                "mounting angles",         "positions",           "velocities",        "attitudes",
                                "filtered positions",      "filtered velocities", "filtered attitudes"};
enum Quantity : std::size_t {
  determined,
  coefficients,
  lever_arms,
  delays,
  mounting_angles,
  positions,
  velocities,
  attitudes,
  filtered  // positions, velocities and attitudes again
};

/// A drawn number that is spread evenly over seeds in a row.
double either(const RandomStream& draw, std::uint64_t index) { return draw.uniform(index) < 0.5 ? -1 : 1; }

std::vector<Segment> city(const RandomStream& draw) {
  using namespace motion;
  std::vector<Segment> parts{rest(12), accelerate(10, 5)};
  for (std::uint64_t k = 0; k < 8; ++k) {
    parts.push_back(turn(either(draw, k) * 90 * unit::deg, 0.25, 1.5));
    parts.push_back(straight(3 + 5 * draw.uniform(100 + k)));
    if (k % 2 == 0) continue;
    parts.insert(parts.end(), {accelerate(-10, 4), rest(2 + 4 * draw.uniform(200 + k)), accelerate(10, 5)});
  }
  return parts;
}

std::vector<Segment> motorway(const RandomStream& draw) {
  using namespace motion;
  std::vector<Segment> parts{straight(5)};
  for (std::uint64_t k = 0; k < 5; ++k) {
    parts.push_back(s_turn(either(draw, k) * 6 * unit::deg, 0.06, 1));
    parts.push_back(accelerate(k % 2 == 0 ? -10 : 10, 6));
    parts.push_back(straight(3 + 5 * draw.uniform(100 + k)));
    parts.push_back(turn(either(draw, 10 + k) * 60 * unit::deg, 0.08, 2));
  }
  return parts;
}

std::vector<Segment> hover(const RandomStream& draw) {
  using namespace motion;
  const auto hang = [&](std::uint64_t k) {
    return rest(8 + 4 * draw.uniform(k), {.angle = 3 * unit::deg, .angle_frequency = 0.3, .displacement = 0.4, .displacement_frequency = 0.2});
  };
  std::vector<Segment> parts{hang(0)};
  for (std::uint64_t k = 1; k <= 5; ++k) {
    parts.insert(parts.end(), {rotate(Eigen::Vector3d::UnitZ(), either(draw, 100 + k) * 90 * unit::deg, 30 * unit::deg), hang(k), accelerate(4, 3),
                               straight(4), accelerate(-4, 3), hang(50 + k)});
  }
  return parts;
}

std::vector<Segment> fixed_wing(const RandomStream& draw) {
  using namespace motion;
  std::vector<Segment> parts{straight(5)};
  for (std::uint64_t k = 0; k < 5; ++k) {
    parts.push_back(turn(either(draw, k) * (90 + 180 * draw.uniform(100 + k)) * unit::deg, 0.25, 1.5));
    parts.push_back(climb((k % 2 == 0 ? 10 : -10) * unit::deg, 5, 2));
    parts.push_back(accelerate(k % 2 == 0 ? 6 : -6, 4));
    parts.push_back(s_turn(either(draw, 10 + k) * 30 * unit::deg, 0.2, 1.5));
  }
  return parts;
}

motion::Trajectory driven(std::size_t carrier, const RandomStream& draw) {
  motion::FlightStart start{48 * unit::deg, 0.2, 500, 0, 2 * std::numbers::pi * draw.uniform(1000)};
  start.speed = std::array{0., 30., 0., 25.}[carrier];
  const auto parts = std::array{city, motorway, hover, fixed_wing}[carrier](draw);
  return motion::flight(start, parts, {.banks = carrier == 3});
}

/// The same motion in axes that are mounted in the carrier.
motion::Trajectory in_axes(const motion::Trajectory& carrier, const Eigen::Matrix3d& mounted) {
  motion::Trajectory out = carrier;
  out.at = [carrier, mounted](double t) {
    motion::Kinematics k = carrier.at(t);
    k.C_nb = k.C_nb * mounted, k.rate_nb_b = mounted.transpose() * k.rate_nb_b;
    return k;
  };
  return out;
}

struct AidedCase {
  std::size_t carrier = 0;
  Session session;
  Recording recording;
  Truth unit;
  motion::Trajectory motion;
  SimulatedAid receiver;
  double pitch = 0, yaw = 0;  // of the mounting
};

/// Two drives to a flight.
AidedCase drawn_case(std::uint64_t seed, bool effects) {
  const RandomStream draw(seed, "aided");
  AidedCase c;
  c.carrier = seed % 3 == 2 ? 2 + seed / 3 % 2 : seed % 3;
  Session& session = c.session;
  session.site.latitude = 48 * unit::deg, session.site.longitude = 0.2, session.site.height = 500;
  session.imu.grade = draw.uniform(2000) < 0.5 ? "mems" : "tactical";
  session.imu.noise = NoiseTerms::full;
  if (effects) {
    session.imu.simulated_effects.emplace();
    for (const Effect& effect : imulab::effects())
      if (effect.columns(simulate::setting_of(session)) > 0)
        session.imu.simulated_effects->try_emplace(std::string(effect.name), effect_sigma(effect, {}, *session.imu.grade));
  }
  c.unit = draw_truth(session, seed);
  c.unit.accel_noise.turn_on = c.unit.gyro_noise.turn_on = {};  // of one recording: a calibration of it does not separate them from the offsets
  const auto angle = [&](std::uint64_t k) { return 30 * unit::deg * (2 * draw.uniform(2001 + k) - 1); };
  c.pitch = angle(0), c.yaw = angle(1);
  const Eigen::Matrix3d mounted = rotation_about(Eigen::Vector3d::UnitY(), angle(2) / 3) * rotation_about(Eigen::Vector3d::UnitZ(), c.yaw) *
                                  rotation_about(Eigen::Vector3d::UnitX(), c.pitch);
  c.motion = in_axes(driven(c.carrier, draw), mounted);
  Aid aid{.lever_arm_sigma = 0.5, .delay_sigma = 0.05, .position_sigma = 1.5, .velocity_sigma = 0.05, .correlation = 60};
  aid.rate = draw.uniform(2010) < 0.5 ? 1 : 10;
  c.receiver = simulate_aid(aid, 0, c.motion, seed);
  const double stated_over_true = std::pow(3., std::floor(3 * draw.uniform(2011)) - 1);
  AidRecord& record = c.receiver.aid.record;
  for (auto* sigmas : {&record.position_sigma, &record.velocity_sigma})
    for (Eigen::Vector3d& sigma : *sigmas) sigma *= stated_over_true;
  session.aids = {c.receiver.aid};
  if (c.carrier < 2) session.aids.push_back({.kind = AidKind::vehicle});
  c.recording = simulate_motion(motion::ideal_increments(c.motion, sampling), sampling, c.unit, seed);
  return c;
}

/// Counts what was within 1.96 sigma.
struct AidedRun {
  std::size_t carrier = 0;
  bool good = false;
  std::array<double, quantities.size()> inside{}, all{};
  double nees = 0;  // of the position in the middle
  std::string reasons = {};
  void fields(auto&& visit) { visit(carrier, good, inside, all, nees, reasons); }
  void add(std::size_t q, double error, double sigma) { inside[q] += std::abs(error) < 1.959963985 * sigma, all[q] += 1; }
};

void add_constants(const AidedCase& c, const AidedNavigation& n, AidedRun& out) {
  constexpr std::array<const char*, 3> axes{"right", "forward", "up"};
  for (const AidedConstant& k : n.constants) {
    for (std::size_t i = 0; i < 3; ++i)
      if (k.name == fmt::format("gnss.lever_arm.{}", axes[i]))
        out.add(lever_arms, k.value - c.receiver.lever_arm[static_cast<Eigen::Index>(i)], k.sigma);
    if (k.name == "gnss.delay") out.add(delays, k.value - c.receiver.delay, k.sigma);
    if (k.name == "vehicle.mounting.pitch") out.add(mounting_angles, k.value - c.pitch, k.sigma);
    if (k.name == "vehicle.mounting.yaw") out.add(mounting_angles, k.value - c.yaw, k.sigma);
  }
}

void add_states(const AidedCase& c, const AidedNavigation& n, std::size_t first_quantity, AidedRun& out) {
  using budget::ErrorIndex;
  constexpr std::size_t parts = 10;
  for (std::size_t part = 0; part <= parts; ++part) {
    const AidedCovariance& at = n.covariance[part * (n.covariance.size() - 1) / parts];
    const auto i = std::lower_bound(n.solution.time.begin(), n.solution.time.end(), at.time - 1e-6) - n.solution.time.begin();
    const budget::ErrorState error = budget::error_of(n.solution.states[static_cast<std::size_t>(i)], motion::navigation_state(c.motion.at(at.time)));
    for (const auto& [quantity, first] : {std::pair(std::size_t{0}, ErrorIndex::position), {1, ErrorIndex::velocity}, {2, ErrorIndex::attitude}})
      for (Eigen::Index k = first; k < first + 3; ++k) out.add(first_quantity + quantity, error[k], std::sqrt(at.value(k, k)));
    const Eigen::Vector3d position = error.segment<3>(ErrorIndex::position);
    if (part == parts / 2 && first_quantity == positions) out.nees = position.dot(at.value.bottomRightCorner<3, 3>().llt().solve(position));
  }
}

AidedRun aided_run(std::uint64_t seed, bool effects) {
  const AidedCase c = drawn_case(seed, effects);
  AidedRun out{.carrier = c.carrier};
  CalibrationOptions options;
  options.effects = effects;
  const aided::OutputTerms terms = drive::output_terms(c.recording, c.session, drive::shared_by({&c.recording, 1}, c.session));
  const aided::SensorPriors priors = drive::unit_priors(c.session.imu, drive::drive_coefficients());
  const AidedNavigation n = aided::navigate_under(priors, c.session, c.recording, c.session.aids, {}, effects ? &terms : nullptr);
  const Calibration result =
      drive::calibration_result({drive::drive_of(n, c.recording, c.session.imu)}, {c.session, std::span(&c.recording, 1)}, options).calibration;
  out.good = result.quality.verdict == Verdict::good;
  out.reasons = fmt::format("{}", fmt::join(result.quality.findings.reasons(), "; "));
  for (std::size_t k = 0; k < result.estimated.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    const double error = coefficient_value(result.model, result.estimated[k]) - coefficient_value(c.unit.model, result.estimated[k]),
                 sigma = std::sqrt(result.covariance(at, at));
    out.add(coefficients, error, sigma);
    if (std::ranges::find(result.quality.considered, coefficient(result.estimated[k]).name) == result.quality.considered.end())
      out.add(determined, error, sigma);
  }
  add_constants(c, n, out);
  add_states(c, n, positions, out);
  add_states(c, aided::navigate_under(priors, c.session, c.recording, c.session.aids, {.causal = true}), filtered, out);
  return out;
}

}  // namespace

std::vector<Check> aided_runs(int count, bool effects) {
  const auto runs = runs_of<AidedRun>(effects ? "aided-effects" : "aided", count, [&](std::size_t i) { return aided_run(i + 1, effects); });
  std::array<double, carriers.size()> good{}, all{};
  std::array<double, quantities.size()> inside{}, stated{};
  double nees = 0, goods = 0;
  for (std::size_t k = 0; k < runs.size(); ++k)
    if (!runs[k].good && tells()) fmt::print("  seed {} ({}): {}\n", k + 1, carriers[runs[k].carrier], runs[k].reasons);
  for (const AidedRun& r : runs) {
    all[r.carrier] += 1, good[r.carrier] += r.good;
    if (!r.good) continue;
    goods += 1, nees += r.nees;
    for (std::size_t q = 0; q < quantities.size(); ++q) inside[q] += r.inside[q], stated[q] += r.all[q];
  }
  std::vector<Check> checks;
  for (std::size_t k = 0; k < carriers.size(); ++k) checks.push_back({fmt::format("good: {}", carriers[k]), good[k] / all[k], 0, 1});  // shown
  // Values of one run go together: of independent ones there are as many as runs, and chance leaves this band once in a thousand.
  const double low = std::min(0.93, binomial_quantile(0.0005, goods, 0.95) / goods),
               high = std::max(0.97, binomial_quantile(0.9995, goods, 0.95) / goods);
  for (std::size_t q = 0; q < quantities.size(); ++q)
    checks.push_back({fmt::format("coverage of {}", quantities[q]), inside[q] / stated[q], low, high});
  const double values = 3 * goods;
  checks.push_back(
      {"NEES of the middle position", nees / values, chi_square_quantile(0.0005, values) / values, chi_square_quantile(0.9995, values) / values});
  return checks;
}

}  // namespace imulab::acceptance
