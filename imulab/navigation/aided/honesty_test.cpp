// Results of an aided navigation whose data are less accurate than they claim.
#include "imulab/core/random.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace imulab::aided {
namespace {

/// A drive of an IMU with only white noise, and a receiver of 1.5 m and 0.1 m/s that states given sigmas.
struct Drive {
  motion::NominalMotion motion;
  Recording recording;
  std::vector<Aid> aids;
};
/// `in_turns` multiplies the noise of the gyros in turns; `small` the errors of the receiver.
Drive drive_of(std::uint64_t seed, double stated, double in_turns = 1, double small = 1) {
  Drive out;
  std::vector<motion::Segment> segments{motion::rest(5), motion::accelerate(10, 8)};
  for (int k = 0; k < 5; ++k)
    segments.insert(segments.end(), {motion::turn((k % 2 > 0 ? 90 : -90) * unit::deg, 0.25, 1.5), motion::straight(4), motion::accelerate(-5, 4),
                                     motion::accelerate(5, 4)});
  out.motion = motion::nominal_motion(motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, segments, {.banks = false}), 0.05);
  out.recording = ideal_readings(out.motion);
  const RandomStream draw(seed, "honesty");
  std::uint64_t n = 0;
  constexpr double of_gyro = 5e-4, of_accel = 0.01;  // rad/s, m/s^2
  const auto turns = [&](std::size_t i) { return i > 0 && motion_kind(out.motion.states[i - 1], out.motion.states[i], 0.05) == 2; };
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < out.recording.size(); ++i) {
      out.recording.gyro[k][i] += (turns(i) ? in_turns : 1) * of_gyro * draw.normal(n++);
      out.recording.accel[k][i] += of_accel * draw.normal(n++);
    }
  const auto noise = [&](double size) {
    n += 3;
    return Vector3d(size * draw.normal(n - 3), size * draw.normal(n - 2), size * draw.normal(n - 1));
  };
  Aid& aid = out.aids.emplace_back(Aid{.scale = TimeScale::recording});
  for (std::size_t i = 0; i < out.motion.time.size(); i += 20) {
    Eigen::Matrix<double, 9, 1> error = Eigen::Matrix<double, 9, 1>::Zero();
    error.tail<6>() << noise(0.1 * small), noise(1.5 * small);
    const NavigationState s = plus(out.motion.states[i], error);
    aid.record.time.push_back(std::llround(1e9 * out.motion.time[i]));
    aid.record.position.emplace_back(s.latitude, s.longitude, s.height), aid.record.velocity.push_back(s.velocity);
    aid.record.position_sigma.push_back(Vector3d::Constant(stated)), aid.record.velocity_sigma.push_back(Vector3d::Constant(stated));
  }
  return out;
}

TEST(AidedHonesty, SigmasStatedFarTooSmallAreFound) {
  double squares = 0;
  std::size_t values = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Drive d = drive_of(seed, 1e-4);
    const AidedNavigation n = navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, {});
    EXPECT_FALSE(n.findings.doubtful()) << testing::PrintToString(n.findings.all());
    EXPECT_TRUE(n.converged);
    const double noise = std::sqrt(std::ranges::find(n.factors, "gnss.position", &AidedFactor::name)->factor) * 1e-4;
    EXPECT_NEAR(noise, 1.5, 0.4);  // 200 values: 5 %, minus the part absorbed by a slow error
    for (std::size_t i = 0; i < n.solution.size(); i += 100, values += 6)
      squares += minus(n.solution.states[i], d.motion.states[i]).cwiseQuotient(sigmas_at(n, n.solution.time[i])).tail<6>().squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(values)), 1.5);  // the errors of a drive are a few independent values
}

TEST(AidedHonesty, ResidualsTellInWhichMotionTheNoiseIsLarger) {
  for (const double in_turns : {1., 20.}) {
    std::array<double, 2> squares{}, resolved{};  // of straight and of turning
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const Drive d = drive_of(seed, 0.1, in_turns, 1. / 15);
      for (const MotionResiduals& r : navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, {}).residuals)
        if (r.kind == "straight" || r.kind == "turning") {
          const std::size_t k = r.kind == "turning" ? 1 : 0;
          squares[k] += r.gyro.resolved * r.gyro.rms * r.gyro.rms, resolved[k] += r.gyro.resolved;
        }
    }
    const double ratio = std::sqrt(squares[1] / resolved[1] / (squares[0] / resolved[0]));
    // Equal noise: the ratio of two mean squares of so many values, at four sigmas. Twenty times as much is seen through fixes of every second.
    const double sigma = std::sqrt((1 / resolved[0] + 1 / resolved[1]) / 2);
    if (in_turns == 1)
      EXPECT_NEAR(ratio, 1, 4 * sigma);
    else
      EXPECT_GT(ratio, 1 + 4 * sigma) << resolved[0] << " " << resolved[1];
  }
}

TEST(AidedHonesty, APositionThatNothingTellsIsLost) {
  const Drive d = drive_of(1, 1);
  AidedOptions options{.causal = true, .outages = {{12, 1000}}};
  EXPECT_THAT(navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, options).findings.reasons(),
              testing::Contains(testing::HasSubstr("the position is lost")));
  options.outages = {{12, 22}};
  EXPECT_THAT(navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, options).findings.all(),
              testing::Not(testing::Contains(testing::HasSubstr("the position is lost"))));
}

TEST(AidedHonesty, NoiseThatStillChangesIsDoubtful) {
  const Drive d = drive_of(1, 1e-4);
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, {.passes = 2});
  EXPECT_FALSE(n.converged);
  EXPECT_THAT(n.findings.reasons(), testing::Contains("the estimates of the noise still change after 2 passes"));
}

std::vector<std::string> doubts_of(const Drive& d) { return navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, {}).findings.reasons(); }

TEST(AidedHonesty, ACopyOfAReceiverIsNamed) {
  Drive d = drive_of(1, 1.5);
  d.aids.push_back(d.aids[0]);
  EXPECT_THAT(doubts_of(d), testing::Contains(testing::HasSubstr("gnss2: has the positions of gnss: one receiver")));
  const Drive other = drive_of(2, 1.5);
  d.aids[1] = other.aids[0];
  EXPECT_THAT(doubts_of(d), testing::IsEmpty());
}

TEST(AidedHonesty, AHeadingThatContradictsIsNamed) {
  Drive d = drive_of(1, 1.5);
  Aid& heading = d.aids.emplace_back(Aid{.kind = AidKind::heading, .scale = TimeScale::recording});
  for (std::size_t i = 0; i < d.motion.time.size(); i += 20) {
    heading.record.time.push_back(std::llround(1e9 * d.motion.time[i]));
    heading.record.value.push_back(-euler_angles(d.motion.states[i].q_nb.toRotationMatrix()).heading);  // counted in the opposite direction
  }
  EXPECT_THAT(doubts_of(d), testing::Contains(testing::HasSubstr("heading: its error comes out")));
}

TEST(AidedHonesty, ValuesThatContradictInARowAreNamed) {
  Drive d = drive_of(1, 1.5);
  for (std::size_t i = 20; i < 35; ++i) d.aids[0].record.position[i].z() += 100;
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), {}, d.recording, d.aids, {});
  EXPECT_THAT(n.findings.all(), testing::Contains(testing::HasSubstr("the values of gnss.position from 20 s to 34 s contradict all else")));
}

}  // namespace
}  // namespace imulab::aided
