#include "imulab/estimate/kernel/prior.hpp"

#include "imulab/grade.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <map>

namespace imulab::kernel {
namespace {

TEST(OptionalTerms, TheGradeIsToldByAllThatIsSeen) {
  const auto told = [](const SeenOfUnit& seen) { return likeliest(likely_grades({}, seen)).name; };
  const Grade &mems = grade("mems"), &navigation = grade("navigation");
  EXPECT_EQ(told({.accel_noise = mems.accel_noise.N, .gyro_noise = mems.gyro_noise.N, .accel_offset = mems.accel_bias}), "mems")
      << "gyros set to zero";
  EXPECT_EQ(told({.accel_noise = navigation.accel_noise.N, .gyro_noise = navigation.gyro_noise.N, .accel_offset = navigation.accel_bias}),
            "navigation");
  std::map<std::string, double> log_weight;  // an offset that is small by chance, or was removed, is weak evidence compared with the noise
  for (const LikelyGrade& of : likely_grades({}, {.accel_noise = mems.accel_noise.N, .gyro_noise = mems.gyro_noise.N, .accel_offset = 70 * unit::ug}))
    log_weight[of.name] = of.log_weight;
  EXPECT_GT(log_weight["mems"], log_weight["tactical"] - 2);  // the accelerometer noise of both grades is similar
  EXPECT_GT(log_weight["mems"], log_weight["navigation"] + 1);
  ImuDeclaration declared;
  declared.grade = "tactical";
  EXPECT_EQ(likely_grades(declared, {}).size(), 1u);
  EXPECT_EQ(of_likeliest_grade(declared, {.accel_noise = mems.accel_noise.N}).grade, "tactical");
}

TEST(OptionalTerms, ADeclaredGradeHoldsUnlessTwoQuantitiesContradictIt) {
  const Grade &mems = grade("mems"), &of = grade("tactical");
  ImuDeclaration declared;
  declared.grade = of.name;
  SeenOfUnit seen{.accel_noise = of.accel_noise.N, .gyro_noise = of.gyro_noise.N, .accel_offset = of.accel_bias, .gyro_offset = of.gyro_bias};
  EXPECT_EQ(likely_grades(declared, seen).size(), 1u);
  seen.accel_offset = mems.accel_bias;  // the rest was not at rest
  EXPECT_EQ(likely_grades(declared, seen).size(), 1u);
  seen.gyro_offset = mems.gyro_bias;
  EXPECT_EQ(likeliest(likely_grades(declared, seen)).name, "mems");
}

}  // namespace
}  // namespace imulab::kernel
