// The start of an aided navigation with a given initial state.
#include "imulab/navigation/aided/start.hpp"

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace imulab::aided {
namespace {

/// A drive without errors, with its state at mid-drive.
struct StartedLate {
  motion::NominalMotion motion;
  Session session;
  std::vector<Aid> aids;
};
StartedLate started_late(std::size_t sample, double rest = 0, double interval = 0.1) {
  StartedLate out;
  std::vector<motion::Segment> segments{motion::accelerate(10, 10), motion::turn(90 * unit::deg, 0.2, 2), motion::straight(30)};
  if (rest > 0) segments.insert(segments.begin(), motion::rest(rest));
  out.motion = motion::nominal_motion(motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, segments, {.banks = false}), interval);
  Aid& aid = out.aids.emplace_back(Aid{.scale = TimeScale::recording, .lever_arm_sigma = 0, .delay_sigma = 0});
  for (std::size_t i = 0; i < out.motion.time.size(); i += 10) {
    const NavigationState& s = out.motion.states[i];
    aid.record.time.push_back(std::llround(1e9 * out.motion.time[i]));
    aid.record.position.emplace_back(s.latitude, s.longitude, s.height);
    aid.record.position_sigma.push_back(Eigen::Vector3d::Constant(0.1));
  }
  const NavigationState& s = out.motion.states[sample];
  const EulerAngles angles = euler_angles(s.q_nb.toRotationMatrix());
  out.session.initial = InitialState{.time = out.motion.time[sample],
                                     .latitude = s.latitude,
                                     .longitude = s.longitude,
                                     .height = s.height,
                                     .velocity_enu = {s.velocity.x(), s.velocity.y(), s.velocity.z()},
                                     .roll = angles.roll,
                                     .pitch = angles.pitch,
                                     .heading = angles.heading};
  return out;
}

TEST(AidedStart, AnInitialStateIsThatOfItsTime) {
  const std::size_t sample = 153;
  StartedLate d = started_late(sample);
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), d.session, ideal_readings(d.motion), d.aids, {});
  ASSERT_NEAR(n.solution.time.front(), d.motion.time[sample], 1e-9);
  ASSERT_EQ(n.solution.size(), d.motion.states.size() - sample);
  const NavigationState &first = n.solution.states.front(), &truth = d.motion.states[sample];
  EXPECT_LT((first.velocity - truth.velocity).norm(), 0.5);  // m/s: fixes of 0.1 m each second
  EXPECT_LT(std::abs(first.latitude - truth.latitude) * 6.4e6, 0.5);
  d.session.initial->time = 1000;
  EXPECT_THAT([&] { navigate_under(sensor_priors({}, {}), d.session, ideal_readings(d.motion), d.aids, {}); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("the initial state is at 1000.000000 s; expected inside the recording")));
}

/// Removes the fixes of the first seconds and adds errors of the stated size.
void fix_late(Aid& aid, double seconds) {
  AidRecord& r = aid.record;
  const auto lost = std::ranges::lower_bound(r.time, std::llround(1e9 * seconds)) - r.time.begin();
  r.time.erase(r.time.begin(), r.time.begin() + lost), r.position.erase(r.position.begin(), r.position.begin() + lost);
  r.position_sigma.erase(r.position_sigma.begin(), r.position_sigma.begin() + lost);
  const RandomStream draw(1, "fixes");
  constexpr double radius = 6.37e6;
  for (std::size_t i = 0; i < r.position.size(); ++i)
    r.position[i] += 0.1 * Vector3d(draw.normal(3 * i) / radius, draw.normal(3 * i + 1) / radius, draw.normal(3 * i + 2));
}

/// Returns the largest error of position and velocity divided by its sigma.
double worst_error(const AidedNavigation& n, const motion::NominalMotion& motion) {
  const std::size_t first = motion.states.size() - n.solution.size();
  double worst = 0;
  for (std::size_t i = 0; i < n.solution.size(); ++i) {
    const auto ratios = minus(n.solution.states[i], motion.states[first + i]).cwiseQuotient(sigmas_at(n, n.solution.time[i]));
    worst = std::max(worst, ratios.tail<6>().cwiseAbs().maxCoeff());
  }
  return worst;
}

// The receiver needs some time: the solution begins with a rest, an initial state or the first fix, and is not overconfident.
TEST(AidedStart, ALateFixIsNotTheStart) {
  struct Case {
    double rest, first_fix, begin;
    bool initial;
  };
  for (const Case& c : {Case{0, 15, 15, false}, Case{0, 15, 0, true}, Case{25, 12, 0, false}, Case{25, 32, 32, false}, Case{25, 32, 0, true}}) {
    StartedLate d = started_late(0, c.rest, 0.02);
    fix_late(d.aids[0], c.first_fix);
    if (!c.initial) d.session.initial.reset();
    const AidedNavigation n = navigate_under(sensor_priors({}, {}), d.session, ideal_readings(d.motion), d.aids, {});
    EXPECT_NEAR(n.solution.time.front(), c.begin, 0.03) << c.rest << ", " << c.first_fix;
    EXPECT_EQ(std::ranges::count_if(n.findings.all(), [](const std::string& w) { return w.find("begins with the first fix") != std::string::npos; }),
              c.begin > 0);
    EXPECT_LT(worst_error(n, d.motion), 4.5) << c.rest << ", " << c.first_fix;  // sigmas: p = 1e-5
    EXPECT_LT(n.innovation_rms, 1.5) << c.rest << ", " << c.first_fix;
  }
}

TEST(AidedStart, AWithheldFixIsNotTheStart) {
  StartedLate d = started_late(0, 0, 0.02);
  d.session.initial.reset();
  d.aids[0].outages = {{0, 14.5}};
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), d.session, ideal_readings(d.motion), d.aids, {});
  EXPECT_NEAR(n.solution.time.front(), 14.6, 0.03) << "fixes come each 0.2 s";
}

// On a level road, a gyro's offset and its g-sensitivity to gravity form a single number, also at rest.
TEST(AidedStart, ARestDoesNotTellAnOffsetFromGSensitivity) {
  const StartedLate d = started_late(0, 20, 0.02);
  const AidedNavigation n = foresee(sensor_priors({}, {}), {}, d.motion, d.aids, 3);
  EXPECT_EQ(std::ranges::count(n.factors, "zero_velocity.rate", &AidedFactor::name), 1);
  for (const char* name : {"gyro.g_sensitivity.xz", "gyro.g_sensitivity.yz", "gyro.g_sensitivity.zz"})
    EXPECT_TRUE(std::ranges::find(n.constants, name, &AidedConstant::name)->undetermined()) << name;
}

// A calibration determines the reading under gravity, but not offset and scale separately; neither does a level drive.
TEST(AidedStart, WhatACalibrationKnowsTogetherStaysTogether) {
  const StartedLate d = started_late(0, 20, 0.02);
  Calibration c;
  c.estimated = {coefficient_index("accel.offset.z"), coefficient_index("accel.matrix.zz")};
  constexpr double scale = 0.01, offset = 9.8 * scale;
  const auto scale_after = [&](double correlation) {
    c.covariance = (Eigen::Matrix2d() << offset * offset, correlation * offset * scale, correlation * offset * scale, scale * scale).finished();
    const AidedNavigation n = foresee(sensor_priors(c, {}), {}, d.motion, d.aids, 3);
    return std::ranges::find(n.constants, "accel.matrix.zz", &AidedConstant::name)->sigma / scale;
  };
  const double apart = scale_after(0);
  EXPECT_GT(apart, std::sqrt(0.5));  // the drive determines only the sum
  EXPECT_LT(apart, 0.8);             // nearly determined
  EXPECT_NEAR(scale_after(-0.999), 1, 0.02);
}

}  // namespace
}  // namespace imulab::aided
