// The offset of a receiver's clock from turns and speed changes: at the other scale or anywhere; and cases without a clear answer.
#include "imulab/navigation/aided/clock_search.hpp"

#include "imulab/error.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

namespace imulab::aided {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

struct Clocked {
  Recording recording;
  Aid aid;
  std::vector<std::int64_t> truth;  // stamps on the recording's clock
};

/// Returns velocities of this motion at 5 Hz, with stamps too small by `late` [s].
Clocked clocked(const std::vector<motion::Segment>& segments, double late, double other_scale = 0, double speed = 0) {
  const motion::NominalMotion m = motion::nominal_motion(motion::flight({48 * unit::deg, 0.2, 500, speed, 0}, segments, {.banks = false}), 0.05);
  Clocked out{.recording = ideal_readings(m), .aid = {.file = "gnss.pos", .scale = TimeScale::own, .other_scale_s = other_scale}, .truth = {}};
  for (std::size_t i = 0; i < m.time.size(); i += 4) {
    out.truth.push_back(std::llround(1e9 * m.time[i]));
    out.aid.record.time.push_back(out.truth.back() - std::llround(1e9 * late));
    out.aid.record.velocity.push_back(m.states[i].velocity);
  }
  return out;
}

std::vector<motion::Segment> drive() {
  using namespace motion;
  return {rest(8),
          accelerate(10, 6),
          turn(90 * unit::deg, 0.3, 2),
          straight(11),
          turn(-60 * unit::deg, 0.2, 2),
          straight(7),
          accelerate(5, 5),
          straight(9),
          turn(200 * unit::deg, 0.2, 2),
          straight(5),
          accelerate(14, 8),
          straight(13),
          turn(-120 * unit::deg, 0.13, 2),
          straight(6)};
}

/// The difference of the first stamp from the truth after the search [s], and the findings.
struct Searched {
  double off = 0;
  std::vector<std::string> said;
};
Searched searched(Clocked c) {
  std::vector<Aid> aids{c.aid};
  AidedNavigation out;
  find_clocks(aids, c.recording, {}, out);
  return {1e-9 * static_cast<double>(aids[0].record.time[0] - c.truth[0]), out.findings.all()};
}

// A GPS clock without its scale counts as UTC: the receiver's stamps are 18 s too small. The remainder is a delay and is not shifted.
TEST(ClockSearch, FindsTheScaleThatNobodyDeclared) {
  const Searched of_gps = searched(clocked(drive(), 18 - 0.2, 18));
  EXPECT_NEAR(of_gps.off, 0.2, 1e-6);
  ASSERT_EQ(of_gps.said.size(), 1u);
  EXPECT_THAT(of_gps.said[0], HasSubstr("moved by 18.00 s: turns and changes of speed fit there alone; the recording then counts GPS time"));
  const Searched of_utc = searched(clocked(drive(), 0.3, 18));
  EXPECT_NEAR(of_utc.off, -0.3, 1e-6);
  EXPECT_THAT(of_utc.said, IsEmpty());
}

// Without dates any offset is possible: it is found to a fraction of the half-second interval.
TEST(ClockSearch, FindsAnyOffsetWithoutDates) {
  for (const double late : {37.4, -21.3}) EXPECT_NEAR(searched(clocked(drive(), late)).off, 0, 0.25) << late;
}

TEST(ClockSearch, WhereTwoOffsetsCompeteThatIsTheQuestion) {
  std::vector<motion::Segment> slalom;
  for (int k = 0; k < 12; ++k)
    for (const double side : {1., -1.}) slalom.push_back(motion::turn(side * 60 * unit::deg, 0.3, 2)), slalom.push_back(motion::straight(2));
  EXPECT_THAT([&] { searched(clocked(slalom, 0, 0, 10)); },
              testing::ThrowsMessage<Unsupported>(testing::AllOf(HasSubstr("gnss.pos: its clock"), HasSubstr("declare the scale of the clock"))));
  Clocked declared = clocked(slalom, 0, 0, 10);
  declared.aid.delay_sigma = 1;
  EXPECT_NEAR(searched(declared).off, 0, 1e-9) << "who declares the delay is not asked";
}

TEST(ClockSearch, ARestTellsNothing) {
  const Searched rest = searched(clocked({motion::rest(60)}, 3));
  EXPECT_NEAR(rest.off, -3, 1e-9);
  EXPECT_THAT(rest.said, IsEmpty());
}

}  // namespace
}  // namespace imulab::aided
