#include "imulab/results/noise_requirement.hpp"

#include "imulab/error.hpp"
#include "imulab/model/conclusion.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

namespace imulab {
namespace {

using testing::HasSubstr;

/// N of 0.1 deg/sqrt(h), known to 10 %, larger on z; B only bounded.
NoiseAnalysis analysis_with_limits() {
  NoiseAnalysis out;
  out.recording = "night.csv";
  for (const char* name : {"gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"}) {
    const bool gyro = name[0] == 'g';
    const double size = (gyro ? 0.1 * unit::deg_per_sqrt_h : 50 * unit::ug_per_sqrt_hz) * (name[std::strlen(name) - 1] == 'z' ? 1.5 : 1);
    NoiseFit fit;
    fit.N = {size, 0.05 * size, 0.9 * size, 1.1 * size, true};
    fit.B = fit.K = fit.Q = fit.R = undetermined_below(gyro ? 2 * unit::deg_per_h : 30 * unit::ug);
    out.axes.push_back({.name = name, .unit = gyro ? "rad/s" : "m/s^2", .fit = fit});
  }
  return out;
}

RequirementResult noise_result(const char* limit) { return assess(std::vector{analysis_with_limits()}, limit).front(); }

std::string noise_refusal(const char* limit) {
  try {
    expect_noise_limits(limit);
    assess(std::vector{analysis_with_limits()}, limit);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(NoiseRequirement, TheWorstAxisCountsOrTheNamedOne) {
  const RequirementResult all = noise_result("gyro.N <= 0.2 deg/sqrt(h)");
  EXPECT_TRUE(all.met);
  EXPECT_EQ(all.coefficient, "gyro.z.N");
  EXPECT_EQ(reached_text(all), "0.165 deg/sqrt(h)");
  EXPECT_EQ(noise_result("gyro.x.N <= 0.2 deg/sqrt(h)").coefficient, "gyro.x.N");
  EXPECT_TRUE(noise_result("accel.N <= 0.1 mg/sqrt(Hz)").met);
  EXPECT_FALSE(noise_result("accel.N <= 0.1 m/s/sqrt(h)").met == noise_result("accel.N <= 0.01 m/s/sqrt(h)").met);
}

TEST(NoiseRequirement, AnIntervalThatHoldsTheLimitDecidesNothing) {
  const RequirementResult r = noise_result("gyro.x.N <= 0.105 deg/sqrt(h)");  // the value is below, the interval's end above
  EXPECT_FALSE(r.met);
  EXPECT_THAT(r.note, HasSubstr("undecided: 0.1 deg/sqrt(h) with 95 % in 0.09 to 0.11; a longer log decides"));
  EXPECT_THAT(noise_result("gyro.x.N <= 0.05 deg/sqrt(h)").note, testing::Not(HasSubstr("undecided")));
}

TEST(NoiseRequirement, ATermThatIsNotDeterminedIsJudgedByItsBound) {
  EXPECT_TRUE(noise_result("gyro.B <= 3 deg/h").met);
  EXPECT_FALSE(noise_result("gyro.B <= 1 deg/h").met);
  EXPECT_THAT(noise_result("accel.B <= 20 ug").note, HasSubstr("its 95 % bound counts"));
  NoiseAnalysis silent = analysis_with_limits();
  silent.axes[1].fit.reset();
  EXPECT_TRUE(std::isinf(assess(std::vector{silent}, "gyro.N <= 1 deg/sqrt(h)").front().reached));
}

TEST(NoiseRequirement, NamesWhatWasMeant) {
  EXPECT_THAT(noise_refusal("giro.N <= 1 deg/sqrt(h)"), HasSubstr("did you mean gyro.N?"));
  EXPECT_THAT(noise_refusal("gyro.N <= 1 deg/sqr(h)"), HasSubstr("did you mean deg/sqrt(h)?"));
  EXPECT_THAT(noise_refusal("gyro.N <= 1 deg/sqrt(h) at 3 s"), HasSubstr("has no time"));
  EXPECT_EQ(noise_refusal("gyro.N <= 1 deg/sqrt(h), accel.y.K <= 1 ug/sqrt(h)"), "");
}

}  // namespace
}  // namespace imulab
