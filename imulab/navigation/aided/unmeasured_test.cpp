// Values that a receiver did not measure.
#include "imulab/navigation/aided/unmeasured.hpp"

#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace imulab::aided {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Returns a northward motion with a fix each `interval` [s].
Aid northward(double speed, std::size_t fixes = 40, double interval = 1) {
  Aid aid{.file = "g.csv"};
  for (std::size_t i = 0; i < fixes; ++i) {
    const double t = interval * static_cast<double>(i);
    aid.record.time.push_back(std::llround(1e9 * t));
    aid.record.position.emplace_back(48 * unit::deg + speed * t / 6.37e6, 11 * unit::deg, 500);
    aid.record.velocity.emplace_back(0, speed, 0);
  }
  return aid;
}

struct Checked {
  AidRecord record;
  std::vector<std::string> warnings, doubts;
  /// Returns the rows without a position.
  std::set<std::size_t> taken() const {
    std::set<std::size_t> out;
    for (std::size_t i = 0; i < record.position.size(); ++i)
      if (!record.position[i].allFinite()) out.insert(i);
    return out;
  }
};
Checked checked(Aid aid, const Session& session = {}) {
  std::vector<Aid> aids{std::move(aid)};
  const std::vector<double> zero(2);
  const Recording recording = make_recording({0.1, 0.2}, {zero, zero, zero}, {zero, zero, zero});
  AidedNavigation out;
  take_unmeasured(aids, session, recording, out);
  return {aids[0].record, out.findings.all(), out.findings.reasons()};
}

constexpr double far_off = 50e3 / 6.37e6;  // rad

TEST(AidedUnmeasured, TheStartFollowsTheMostFixes) {
  Aid aid = northward(12);
  for (const std::size_t wrong : {0u, 1u, 20u}) aid.record.position[wrong].x() -= far_off;
  const Checked lost = checked(aid);
  EXPECT_THAT(lost.taken(), ElementsAre(0, 1)) << "a wrong fix later is a suspect";
  EXPECT_THAT(lost.warnings, ElementsAre(AllOf(HasSubstr("g.csv: 2 of 40 positions, until 1 s, "), HasSubstr("5e+04 m"))));
  EXPECT_THAT(lost.doubts, IsEmpty());
  for (std::size_t i = 0; i < 15; ++i) aid.record.position[i].x() -= far_off;  // of 40: the correct ones are unknown
  const Checked two = checked(aid);
  EXPECT_THAT(two.taken(), IsEmpty());
  EXPECT_THAT(two.doubts, ElementsAre(HasSubstr("from 15 s on, and 14 from 2 s on: which are right is not known")));
  Aid fast = northward(250);
  fast.record.velocity.clear();
  EXPECT_THAT(checked(fast).taken(), IsEmpty());
  fast.record.position[0].z() = 2e3;
  EXPECT_THAT(checked(fast).taken(), ElementsAre(0));
  Aid slow = northward(1, 400);
  slow.record.position[0].z() = 0;
  EXPECT_THAT(checked(slow).taken(), ElementsAre(0)) << "from there any motion leads to fixes of minutes later";
}

TEST(AidedUnmeasured, ReadingsAtALimitAreDoubtful) {
  const std::vector<double> zero(2);
  Recording recording = make_recording({0.1, 0.2}, {zero, zero, zero}, {zero, zero, zero});
  recording.saturated = {1};
  std::vector<Aid> none;
  AidedNavigation out;
  take_unmeasured(none, {}, recording, out);
  EXPECT_THAT(out.findings.reasons(), ElementsAre(HasSubstr("50 % of the samples are at a limit")));
}

TEST(AidedUnmeasured, ZerosAreNoFixes) {
  Aid aid = northward(12);
  for (std::size_t i = 0; i < 3; ++i) aid.record.position[i].setZero(), aid.record.velocity[i].setZero();
  aid.record.position[7] = Vector3d(0, 0, 500);
  const Checked nulls = checked(aid);
  EXPECT_THAT(nulls.taken(), ElementsAre(0, 1, 2, 7));
  EXPECT_FALSE(nulls.record.velocity[0].allFinite());
  EXPECT_TRUE(nulls.record.velocity[7].allFinite()) << "a velocity that is there is measured";
  EXPECT_THAT(nulls.warnings, ElementsAre(HasSubstr("g.csv: 4 of 40 positions are at latitude 0 and longitude 0")));
  EXPECT_THAT(nulls.doubts, IsEmpty());
  for (Vector3d& place : aid.record.position) place.setZero();
  EXPECT_THAT(checked(aid).doubts, ElementsAre(HasSubstr("40 of 40 positions are zeros, or held while it moves")));
}

TEST(AidedUnmeasured, MostlyHeldPositionsAreDoubtful) {
  Aid aid = northward(12);
  for (std::size_t i = 0; i < 30; ++i) aid.record.position[i] = aid.record.position[0];
  EXPECT_THAT(checked(aid).doubts, ElementsAre(HasSubstr("29 of 40 positions are zeros, or held while it moves")));
  for (std::size_t i = 0; i < 30; ++i) aid.record.velocity[i].setZero();  // parked
  EXPECT_THAT(checked(aid).doubts, IsEmpty());
  Aid logged = northward(12, 400, 0.1);  // ten rows for each fix
  for (std::size_t i = 0; i < 400; ++i) logged.record.position[i] = logged.record.position[i / 10 * 10];
  const Checked kept = checked(logged);
  EXPECT_EQ(kept.taken().size(), 360u);
  EXPECT_THAT(kept.doubts, IsEmpty());
}

TEST(AidedUnmeasured, AnAidElsewhereIsNamed) {
  Session session;
  session.site.latitude = 20 * unit::deg;
  EXPECT_THAT(checked(northward(12), session).doubts, ElementsAre(HasSubstr("its positions are 3113 km and more from [site], latitude 20 deg;")));
  session.initial = InitialState{.latitude = 48 * unit::deg, .longitude = 12 * unit::deg};
  EXPECT_THAT(checked(northward(12), session).doubts, IsEmpty());
}

TEST(AidedUnmeasured, ConstraintsAloneMeasureNoPosition) {
  const motion::NominalMotion motion =
      motion::nominal_motion(motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, {motion::rest(5), motion::accelerate(10, 10)}, {.banks = false}), 0.1);
  Session session;
  session.site.latitude = 48 * unit::deg;
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), session, ideal_readings(motion), {Aid{.kind = AidKind::vehicle}}, {});
  EXPECT_THAT(n.findings.reasons(), testing::Contains(HasSubstr("no aid measures the position; expected an [[aid]]")));
}

// Heights are above an unknown geoid, 45 m too large: other results are as accurate as without this error.
TEST(AidedUnmeasured, ALevelOfAllHeightsStaysUncertain) {
  const motion::NominalMotion motion = motion::nominal_motion(
      motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, {motion::accelerate(10, 10), motion::turn(90 * unit::deg, 0.2, 2), motion::straight(20)},
                     {.banks = false}),
      0.1);
  Aid aid{.scale = TimeScale::recording, .lever_arm_sigma = 0, .delay_sigma = 0};
  for (std::size_t i = 0; i < motion.time.size(); i += 10) {
    const NavigationState& s = motion.states[i];
    aid.record.time.push_back(std::llround(1e9 * motion.time[i]));
    aid.record.position.emplace_back(s.latitude, s.longitude, s.height - 45);
    aid.record.position_sigma.emplace_back(0.1, 0.1, 30);
  }
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), {}, ideal_readings(motion), {aid}, {});
  const Eigen::Matrix<double, 9, 1> sigma = sigmas_at(n, motion.time.back());
  EXPECT_NEAR(sigma[At::position + 2], 30, 1);
  EXPECT_LT(sigma.segment<2>(At::position).maxCoeff(), 0.5);
  EXPECT_TRUE(std::ranges::find(n.constants, "gnss.height_level", &AidedConstant::name)->undetermined());
}

}  // namespace
}  // namespace imulab::aided
