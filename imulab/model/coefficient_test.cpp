#include "imulab/coefficient.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace imulab {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> names(const std::vector<CoefficientIndex>& indices) {
  std::vector<std::string> out;
  for (const CoefficientIndex i : indices) out.emplace_back(coefficient(i).name);
  return out;
}

TEST(CoefficientTable, HoldsThe57IndependentCoefficientsLeverArmsAndMoreThermalTerms) {
  const auto table = coefficient_table();
  ASSERT_EQ(table.size(), static_cast<std::size_t>(coefficient_count));
  const auto lever_arms = std::count_if(table.begin(), table.end(), [](const Coefficient& c) { return c.term == Term::lever_arm; });
  EXPECT_EQ(lever_arms, 9);
  EXPECT_EQ(std::count_if(table.begin(), table.end(), is_extended), 6 + 36);  // c3; M1, M2
  EXPECT_EQ(std::ssize(table) - lever_arms - 42, 63 - 6);                     // Dai's 63 minus c0, d0
  std::set<std::string_view> unique;
  for (const auto& c : table) unique.insert(c.name);
  EXPECT_EQ(unique.size(), table.size());
}

TEST(CoefficientTable, NamesAreThoseOfTheFiles) {
  for (const char* name : {"accel.offset.x", "accel.matrix.yx", "accel.quadratic.x", "accel.cubic.z", "accel.thermal.x1", "accel.lever_arm.xy",
                           "gyro.offset.x", "gyro.matrix.xy", "gyro.quadratic.y", "gyro.cubic.x", "gyro.thermal.z2", "gyro.g_sensitivity.zx"})
    EXPECT_EQ(coefficient(coefficient_index(name)).name, name);
  EXPECT_EQ(coefficient_table()[0].name, "accel.offset.x");
  EXPECT_EQ(coefficient_table()[4].name, "accel.matrix.xy");
  EXPECT_EQ(coefficient_table()[107].name, "gyro.g_sensitivity.zz");
  EXPECT_EQ(coefficient(coefficient_index("gyro.matrix.xy")).unit, "(rad/s)/raw");
}

TEST(CoefficientTable, NameAndPlaceFindTheSameRow) {
  for (const CoefficientIndex i : coefficient_indices()) {
    const Coefficient& c = coefficient(i);
    EXPECT_EQ(coefficient_index(c.name), i);
    EXPECT_EQ(coefficient_index(c.triad, c.term, c.row, c.column), i);
  }
}

TEST(CoefficientTable, EveryRowIsAnElementOfItsOwn) {
  SensorModel model;
  for (const CoefficientIndex i : coefficient_indices()) set_coefficient(model, i, 100 + i);
  for (const CoefficientIndex i : coefficient_indices()) EXPECT_EQ(coefficient_value(model, i), 100 + i);
}

TEST(CoefficientTable, ElementsSitWhereTheModelHasThem) {
  SensorModel model;
  set_coefficient(model, coefficient_index("accel.matrix.yx"), 1);
  set_coefficient(model, coefficient_index("gyro.g_sensitivity.zx"), 2);
  set_coefficient(model, coefficient_index("accel.lever_arm.xy"), 3);
  set_coefficient(model, coefficient_index("gyro.thermal.y2"), 4);
  set_coefficient(model, coefficient_index("gyro.offset.z"), 5);
  EXPECT_EQ(model.accel.matrix(1, 0), 1);
  EXPECT_EQ(model.g_sensitivity(2, 0), 2);
  EXPECT_EQ(model.lever_arm(0, 1), 3);
  EXPECT_EQ(model.gyro.thermal(1, 2), 4);
  EXPECT_EQ(model.gyro.offset(2), 5);
}

TEST(SelectCoefficients, TakesNamesTermsAndGroups) {
  EXPECT_THAT(names(select_coefficients("gyro.matrix.xy")), ElementsAre("gyro.matrix.xy"));
  EXPECT_THAT(names(select_coefficients("accel.offset")), ElementsAre("accel.offset.x", "accel.offset.y", "accel.offset.z"));
  EXPECT_THAT(names(select_coefficients("gyro.matrix.diagonal")), ElementsAre("gyro.matrix.xx", "gyro.matrix.yy", "gyro.matrix.zz"));
  EXPECT_EQ(select_coefficients("gyro.matrix.off_diagonal").size(), 6u);
  EXPECT_EQ(select_coefficients("accel.thermal").size(), 9u);
  EXPECT_EQ(select_coefficients("gyro.matrix_thermal1.diagonal").size(), 3u);
}

TEST(SelectCoefficients, RefusesWhatTheTableDoesNotHold) {
  for (const char* wrong : {"", "gyro", "gyro.matirx.xy", "accel.g_sensitivity.xx", "gyro.lever_arm", "accel.offset.diagonal", "accel.thermal.x0",
                            "gyro.matrix.", "gyro.matrix.xy "}) {
    try {
      select_coefficients(wrong);
      ADD_FAILURE() << "accepted \"" << wrong << '"';
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("unknown coefficient \"" + std::string(wrong) + '"'));
    }
    EXPECT_THROW(coefficient_index(wrong), Error);
  }
}

}  // namespace
}  // namespace imulab
