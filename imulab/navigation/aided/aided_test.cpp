#include "imulab/navigation/aided/aided.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/aided_budget.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"
#include "imulab/navigation/budget/specification.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

using ::testing::HasSubstr;

constexpr double sample_interval = 0.02;  // s

/// A drive with its truth and an IMU mounted with errors of several degrees; all errors are random.
struct Drive {
  Session session;
  Recording recording;
  std::vector<Aid> aids;
  motion::Trajectory motion;
  Matrix3d mounted;  // IMU to vehicle
  Vector3d lever;
  double delay;
};

motion::Trajectory city(const RandomStream& draw) {
  using namespace motion;
  std::vector<Segment> parts{rest(10), accelerate(10, 5)};
  for (std::uint64_t k = 0; k < 7; ++k) {
    parts.push_back(turn((draw.uniform(k) < 0.5 ? -90 : 90) * unit::deg, 0.25, 1.5));
    parts.push_back(straight(3 + 5 * draw.uniform(100 + k)));
    parts.push_back(accelerate(k % 2 == 0 ? -5 : 5, 4));
  }
  parts.push_back(straight(8));
  return flight({48 * unit::deg, 0.2, 500, 0, 2 * std::numbers::pi * draw.uniform(50)}, parts, {.banks = false});
}

NavigationState displaced(const motion::Kinematics& k, const Vector3d& by) {
  const LocalEarth earth = local_earth(k.latitude, k.height);
  NavigationState s = motion::navigation_state(k);
  s.longitude += by.x() / (earth.transverse_radius * earth.cos_latitude), s.latitude += by.y() / earth.meridian_radius, s.height += by.z();
  return s;
}

Aid receiver(const Drive& drive, const RandomStream& draw, double true_over_stated) {
  Aid aid;
  aid.scale = TimeScale::recording;
  Vector3d slow;
  std::uint64_t n = 0;
  const auto normal = [&] { return Vector3d(draw.normal(n), draw.normal(n + 1), draw.normal(n + 2)); };
  slow = normal();
  for (double t = 1; t < drive.motion.duration - 1; t += 1, n += 9) {
    const motion::Kinematics k = drive.motion.at(t);
    const double a = std::exp(-1. / 60);
    slow = a * slow + std::sqrt(1 - a * a) * normal();
    n += 3;
    const Matrix3d C = k.C_nb * drive.mounted;
    const Vector3d rate = drive.mounted.transpose() * k.rate_nb_b, noise = normal();
    n += 3;
    const NavigationState at = displaced(k, C * drive.lever + true_over_stated * (slow + 0.5 * noise));
    aid.record.time.push_back(std::llround(1e9 * (t + drive.delay)));
    aid.record.position.emplace_back(at.latitude, at.longitude, at.height);
    aid.record.position_sigma.push_back(Vector3d::Ones());
    aid.record.velocity.push_back(k.velocity + C * rate.cross(drive.lever) + 0.05 * normal());
    aid.record.velocity_sigma.push_back(Vector3d::Constant(0.05));
  }
  return aid;
}

Drive drive_of(std::uint64_t seed, double true_over_stated = 1) {
  const RandomStream draw(seed, "drive"), sensors(seed, "sensors");
  Drive d;
  d.motion = city(draw);
  d.mounted = rotation_exp(Vector3d(5 * unit::deg * draw.normal(60), 0, 5 * unit::deg * draw.normal(61)));
  d.lever = {0.3 * draw.normal(62), 0.5 * draw.normal(63), 0.5 * draw.normal(64)}, d.delay = 0.05 * draw.normal(65);
  d.session.imu.grade = "mems";
  const double gyro_noise = 0.3 * unit::deg_per_sqrt_h, accel_noise = 150 * unit::ug_per_sqrt_hz;
  std::uint64_t n = 100;
  const auto error = [&](double size) { return Vector3d(size * draw.normal(n), size * draw.normal(n + 1), size * draw.normal(n + 2)); };
  const Vector3d bg = error(0.2 * unit::deg);
  n += 3;
  const Vector3d ba = error(0.1), sg = (n += 3, error(0.005)), sa = (n += 3, error(0.005));
  Columns3 gyro, accel;
  std::vector<double> time;
  n = 0;
  for (const Increment& ideal : ideal_increments(d.motion, sample_interval)) {
    time.push_back(sample_interval * static_cast<double>(time.size() + 1));
    const Vector3d w = d.mounted.transpose() * ideal.angle / sample_interval, f = d.mounted.transpose() * ideal.velocity / sample_interval;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto column = static_cast<std::size_t>(k);
      gyro[column].push_back((1 + sg[k]) * w[k] + bg[k] + gyro_noise / std::sqrt(sample_interval) * sensors.normal(n++));
      accel[column].push_back((1 + sa[k]) * f[k] + ba[k] + accel_noise / std::sqrt(sample_interval) * sensors.normal(n++));
    }
  }
  d.recording = make_recording(time, std::move(gyro), std::move(accel));
  d.aids = {receiver(d, RandomStream(seed, "receiver"), true_over_stated), Aid{.kind = AidKind::vehicle}};
  return d;
}

Calibration ideal() {
  Calibration c;
  c.model.gyro.raw_unit = "rad/s", c.model.accel.raw_unit = "m/s^2";
  return c;
}

struct Coverage {
  int inside = 0, all = 0;
  void add(double error, double sigma) { inside += std::abs(error) < 1.96 * sigma, ++all; }
  double part() const { return static_cast<double>(inside) / all; }
};

double value_of(const AidedNavigation& n, const std::string& name, double truth, Coverage& coverage) {
  for (const AidedConstant& c : n.constants)
    if (c.name == name) return coverage.add(c.value - truth, c.sigma), c.value;
  ADD_FAILURE() << name;
  return NAN;
}

// Errors must agree with the stated sigmas: of the position 10 times per drive, and of lever arms, delay and mounting. The receiver's stated sigma is
// wrong by a factor of 1/2 to 2, which must be estimated.
TEST(Aided, StatedSigmasHoldTheErrors) {
  Coverage position, constants;
  double nees = 0;
  constexpr int drives = 10;
  for (int k = 0; k < drives; ++k) {
    const Drive d = drive_of(100 + static_cast<std::uint64_t>(k), std::pow(2., k % 3 - 1));
    const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids);
    EXPECT_FALSE(n.findings.doubtful()) << testing::PrintToString(n.findings.all());
    for (int part = 1; part <= 10; ++part) {
      const auto& at = n.covariance[static_cast<std::size_t>(part) * (n.covariance.size() - 1) / 10];
      const auto i =
          static_cast<std::size_t>(std::lower_bound(n.solution.time.begin(), n.solution.time.end(), at.time - 1e-6) - n.solution.time.begin());
      motion::Kinematics truth = d.motion.at(at.time);
      const Vector3d error = budget::error_of(n.solution.states[i], motion::navigation_state(truth)).segment<3>(budget::ErrorIndex::position);
      for (Eigen::Index j = 0; j < 3; ++j) position.add(error[j], std::sqrt(at.value(6 + j, 6 + j)));
      nees += error.dot(at.value.bottomRightCorner<3, 3>().llt().solve(error)) / (30. * drives);
    }
    value_of(n, "gnss.lever_arm.right", d.lever[0], constants), value_of(n, "gnss.lever_arm.forward", d.lever[1], constants);
    value_of(n, "gnss.lever_arm.up", d.lever[2], constants), value_of(n, "gnss.delay", d.delay, constants);
    const Vector3d forward = d.mounted * Vector3d::UnitY();  // of the IMU in the vehicle's axes
    value_of(n, "vehicle.mounting.yaw", std::atan2(-forward.x(), forward.y()), constants);
  }
  // Errors in a drive of 90 s are one or two values of the slow error: about 3 x 10 independent ones, of which at most 0.85 are within the bound with
  // p = 0.02. The size of the slow error is estimated from as few values, so the NEES is F-like with a mean of n / (n - 2), n of about 10.
  EXPECT_GE(position.part(), 0.85);
  EXPECT_NEAR(nees, 1.2, 0.6);
  EXPECT_GE(constants.part(), 0.84);  // 0.95 of 50 independent ones: 0.84 with p = 0.001
}

/// Returns one row of every kind that measures, in addition to the drive's own aids.
std::vector<Aid> all_kinds(const Drive& d) {
  std::vector<Aid> aids = d.aids;
  for (const AidKind kind : {AidKind::wheels, AidKind::barometer, AidKind::heading, AidKind::zero_velocity}) {
    Aid& aid = aids.emplace_back(Aid{.kind = kind});
    if (!has_record(kind)) continue;
    aid.record.time = {20'000'000'000}, aid.record.value = {1};
    aid.lever_arm = Vector3d(0.2, -0.4, 0.9), aid.correlation = 30;
  }
  return aids;
}

// The rows' derivatives must equal differences of their computed values, for every state.
TEST(Aided, DerivativesAreThoseOfTheRows) {
  using namespace aided;
  const Drive d = drive_of(5);
  SensorPriors priors = sensor_priors(ideal(), d.session.imu);
  priors.gyro_flicker = 1e-4, priors.accel_flicker = 1e-2;  // as in a budget
  // Without the gyros' delay: the change of a noisy reading to the next is not that of the rate (pose_test.cpp has its column).
  const Problem p = make_problem(d.recording, priors, all_kinds(d), d.session, {.gyro_delay_sigma = 0});
  constexpr auto end = static_cast<std::size_t>(20 / sample_interval);  // in a turn
  FullState state{motion::navigation_state(d.motion.at(20)), prior_of(p).mean};
  state.motion.velocity.z() = 0.7;      // the road is level, and a barometer is not sensitive to a delay there
  for (const StateBlock& b : p.blocks)  // within their priors, all nonzero
    for (Eigen::Index k = 0; k < b.size; ++k) state.x[b.first + k] += b.prior[k] * (0.1 + 0.05 * static_cast<double>(k));
  const Instant at = instant_at(p, end, state);
  for (std::size_t channel = 0; channel < p.channels.size(); ++channel) {
    const Channel& c = p.channels[channel];
    const double drift = c.delay >= 0 ? state.x[c.delay + 1] : 0;
    Observation o{.stamp = (at.time + delay_at(p, c, state.x, 0)) / (1 - drift), .channel = channel, .row = c.aid.kind == AidKind::gnss ? 18u : 0u};
    const ObservedRows rows = observe(p, o, at);
    for (Eigen::Index k = 0; k < p.size; ++k) {
      constexpr double h = 1e-5;
      const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(p.size, k);
      const auto residual = [&](double sign) { return observe(p, o, instant_at(p, end, plus(state, sign * step))).residual; };
      const Eigen::VectorXd difference = -(residual(1) - residual(-1)) / (2 * h);
      // The derivatives neglect the curvature of the Earth over the hundred meters to a fix.
      for (Eigen::Index i = 0; i < difference.size(); ++i)
        EXPECT_NEAR(rows.derivative(i, k), difference[i], 5e-5 * (1 + std::abs(difference[i]))) << c.name << ", row " << i << ", state " << k;
    }
  }
}

TEST(Aided, RecordsMadeInMemoryAreChecked) {
  Drive d = drive_of(3);
  d.aids[0].record.velocity.pop_back();
  d.aids[1].record.time = {0, 0};
  try {
    navigate_aided(ideal(), d.session, d.recording, d.aids);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::AllOf(HasSubstr("aid 1 (gnss): a column has"), HasSubstr("aid 2 (vehicle): its stamps do not ascend")));
  }
}

// Constants that the motion does not make observable keep their prior and are named.
TEST(Aided, AParkedCarShowsLittle) {
  Drive d = drive_of(7);
  d.motion = motion::flight({48 * unit::deg, 0.2, 500, 0, 1}, {motion::rest(60)}, {.banks = false});
  d.aids = {receiver(d, RandomStream(7, "receiver"), 1)};
  for (Columns3* columns : {&d.recording.gyro, &d.recording.accel})
    for (auto& column : *columns) column.resize(static_cast<std::size_t>(9 / sample_interval));
  d.recording.time_ns.resize(static_cast<std::size_t>(9 / sample_interval));  // at rest throughout
  const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids);
  EXPECT_TRUE(n.findings.doubtful());
  ASSERT_FALSE(n.findings.all().empty());
  EXPECT_THAT(n.findings.all().front(), HasSubstr("does not show the heading"));
  EXPECT_GT(std::sqrt(n.covariance.back().value(2, 2)), 40 * unit::deg);  // any heading is possible: 104 deg for equal likelihoods
  const auto unseen = [](const AidedConstant& c) {
    return c.name == "gnss.delay" || c.name == "gyro.matrix.zz" || c.name == "gnss.lever_arm.forward";
  };
  for (const AidedConstant& c : n.constants) EXPECT_TRUE(!unseen(c) || c.undetermined()) << c.name;
}

TEST(Aided, WithheldTimesAreWithinTheirSigmas) {
  Drive d = drive_of(3);
  const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids, {.outages = {{30, 40}, {55, 65}, {80, 90}}});
  ASSERT_EQ(n.outages.size(), 3u);
  for (const OutageResult& o : n.outages) {
    EXPECT_EQ(o.fixes, 10u);
    EXPECT_LT(o.predicted.ratio, 3);
    EXPECT_LT(o.smoothed.ratio, 2.5);
  }
}

/// Returns the largest position error divided by its sigma.
double worst_ratio(const Drive& d, const AidedNavigation& n) {
  double worst = 0;
  for (std::size_t i = 0; i < n.solution.size(); i += 50) {
    const Eigen::Matrix<double, 9, 1> sigma = sigmas_at(n, n.solution.time[i]);
    const auto error = budget::error_of(n.solution.states[i], motion::navigation_state(d.motion.at(n.solution.time[i])));
    worst = std::max(worst, error.segment<3>(budget::ErrorIndex::position).cwiseAbs().cwiseQuotient(sigma.tail<3>()).maxCoeff());
  }
  return worst;
}

// 4.5 sigmas have p = 1e-5, although the sigma of a slow error with one or two values in a drive is itself uncertain.
constexpr double falsely_sure = 4.5;

TEST(Aided, AReceiverThatHoldsItsLastPositionIsNotBelieved) {
  Drive d = drive_of(3);
  AidRecord& r = d.aids[0].record;
  for (std::size_t i = 40; i < 60; ++i) r.position[i] = r.position[39], r.velocity[i] = r.velocity[39];
  const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids);
  EXPECT_THAT(n.findings.all(), testing::Contains(HasSubstr("20 of ")));
  EXPECT_LT(worst_ratio(d, n), falsely_sure);
}

// In straight motion at constant speed, an IMU without vibration has the same readings as at rest.
TEST(Aided, ASteadyMotionIsNoRest) {
  Drive d = drive_of(3);
  d.aids.push_back({.kind = AidKind::zero_velocity});
  const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids);
  EXPECT_FALSE(n.findings.doubtful()) << testing::PrintToString(n.findings.all());
  EXPECT_LT(worst_ratio(d, n), falsely_sure);
}

TEST(Aided, AnotherDatumHalfwayIsNamed) {
  for (const double by : {30., 8.}) {
    Drive d = drive_of(3);
    AidRecord& r = d.aids[0].record;
    for (std::size_t i = r.position.size() / 2; i < r.position.size(); ++i) r.position[i].z() += by;
    const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids);
    EXPECT_THAT(n.findings.reasons(), testing::Contains(HasSubstr("another datum or geoid"))) << by;
    EXPECT_LT(worst_ratio(d, n), falsely_sure) << by;
  }
}

TEST(Aided, SwappedCoordinatesShowInTheVelocities) {
  Drive d = drive_of(3);
  for (Vector3d& place : d.aids[0].record.position) std::swap(place.x(), place.y());
  try {
    navigate_aided(ideal(), d.session, d.recording, d.aids);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("latitude and longitude swapped"));
  }
}

// The budget is the filter without data: with the estimated noise sizes, it predicts the sigma at the end of an outage. It does not include the
// mounting, the true noise of the first seconds, and the influence of the factors on the start.
TEST(Aided, TheBudgetForeseesItsSigma) {
  Drive d = drive_of(3);
  const Outage lost{55, 80};
  d.aids.pop_back();
  const AidedNavigation n = navigate_aided(ideal(), d.session, d.recording, d.aids, {.causal = true, .outages = {lost}});
  const auto times = [&](const std::string& name) { return std::sqrt(std::ranges::find(n.factors, name, &AidedFactor::name)->factor); };
  ErrorSpecification of_grade;
  of_grade.grade = "mems";
  ErrorSources sources = error_sources(of_grade);
  for (auto* noise : {&sources.gyro_noise, &sources.accel_noise}) {
    const std::string triad = noise == &sources.gyro_noise ? "gyro" : "accel";
    noise->N *= times(triad), noise->K = aided::offset_walk(*noise) * times(triad + ".drift");
    noise->B = 0, noise->turn_on = {}, noise->R = {}, noise->Q = 0;
  }
  sources.start.attitude = {Spread{5 * unit::deg}, Spread{5 * unit::deg}, Spread{30 * unit::deg}};
  sources.start.velocity = {Spread{2}, Spread{2}, Spread{2}}, sources.start.position = {Spread{30}, Spread{30}, Spread{30}};
  Aid& aid = d.aids[0];
  aid.correlation = 60, aid.outages = {lost};
  for (Vector3d& sigma : aid.record.position_sigma) sigma *= std::hypot(times("gnss.position"), times("gnss.slow_error"));
  for (Vector3d& sigma : aid.record.velocity_sigma) sigma *= times("gnss.velocity");
  const ErrorBudget b = aided_budget(motion::nominal_motion(d.motion, sample_interval), sources, d.aids);
  const auto horizontal = [](const auto& position) { return std::sqrt(position.template topLeftCorner<2, 2>().trace()); };
  double stated = 0;  // before the first fix after the outage
  for (const AidedCovariance& c : n.covariance)
    if (c.time > lost.begin && c.time < lost.end + 1) stated = std::max(stated, horizontal(c.value.bottomRightCorner<3, 3>()));
  const double foreseen = horizontal(b.covariance.back());
  EXPECT_NEAR(foreseen / stated, 1, 0.2);
  EXPECT_GT(stated, 5);  // m: it grew in the outage
  // The sigma grows until the receiver returns and decreases at that time, not in the second before.
  const AidedCovariance& worst = *std::ranges::max_element(n.covariance, {}, [](const AidedCovariance& c) { return c.value(6, 6); });
  EXPECT_GT(sigmas_at(n, worst.time - sample_interval)[6], 0.95 * std::sqrt(worst.value(6, 6)));
  EXPECT_LT(sigmas_at(n, worst.time)[6], 0.5 * std::sqrt(worst.value(6, 6)));
}

TEST(Aided, WithoutObservationsItSaysWhy) {
  Drive d = drive_of(3);
  for (std::int64_t& t : d.aids[0].record.time) t += 1'000'000'000'000;
  d.aids.pop_back();
  try {
    navigate_aided(ideal(), d.session, d.recording, d.aids);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("no aid has an observation during the recording"));
  }
}

}  // namespace
}  // namespace imulab
