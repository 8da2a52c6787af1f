#include "imulab/core/stated_limit.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

using testing::HasSubstr;

const std::vector<StatedFigure> stated_figures_of_a_test{{"CEP", {{"m", 1}, {"nmi", 1852}}}, {"CEP", {{"nmi/h", 0.5}}}, {"95 %", {{"m", 1}}}};

FoundFigure found_in_test(const char* text) { return find_figure(parse_limits(text, "a limit", "CEP <= 1 m").front(), stated_figures_of_a_test); }

std::string refusal_in_test(const char* text) {
  try {
    found_in_test(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(StatedLimit, AUnitTellsFiguresOfOneName) {
  EXPECT_EQ(found_in_test("CEP <= 2 nmi").index, 0u);
  EXPECT_EQ(found_in_test("CEP <= 2 nmi").limit, 3704);
  EXPECT_EQ(found_in_test("cep <= 2 nmi/h").index, 1u);
  EXPECT_EQ(found_in_test("cep <= 2 nmi/h").limit, 1);
  EXPECT_EQ(found_in_test("95% <= 7 m at 600 s").index, 2u);
}

TEST(StatedLimit, AnotherUnitOfTheDimensionCounts) {
  EXPECT_DOUBLE_EQ(found_in_test("CEP <= 10 ft").limit, 3.048);
  EXPECT_EQ(found_in_test("CEP ≤ 50 cm").limit, 0.5);
  EXPECT_EQ(refusal_in_test("CEP <= 1 deg"), "CEP <= 1 deg: \"deg\" is no unit of CEP; expected one of m, nmi, nmi/h");
  EXPECT_THAT(refusal_in_test("CEP <= 0,5 m"), HasSubstr("CEP <= 0,5 m: has a decimal comma; expected a point"));
  EXPECT_EQ(parse_limits("a <= 3 m/s^2,95 % <= 5 m,b <= 2 m", "", "").size(), 3u) << "a power is no number";
}

TEST(StatedLimit, NamesTheNearestAndAllThatIsPossible) {
  EXPECT_EQ(refusal_in_test("CEPP <= 1 m"), "CEPP: no figure of this result; did you mean CEP?");
  EXPECT_EQ(refusal_in_test("CEP <= 1 nm/h"), "CEP <= 1 nm/h: \"nm/h\" is no unit of CEP; did you mean nmi/h?");
  EXPECT_THAT(refusal_in_test("CEP <= 1"), HasSubstr("no unit after the number; expected one of m, nmi, nmi/h"));
}

}  // namespace
}  // namespace imulab
