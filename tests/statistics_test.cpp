// A short acceptance test; ./dev accept runs the full one.
// ctest: long
#include <gtest/gtest.h>

#include "tests/acceptance/acceptance.hpp"

using namespace imulab::acceptance;

namespace {

void expect_accepted(Run (*run)(std::uint64_t), int count) {
  const auto checks = judge(run_all(run, count));
  for (const Check& check : checks) {
    // Efficiency over few runs scatters: its band is widened by 3.3 sigmas of the chi-square of count x m (m about 21) degrees of freedom.
    const double slack = check.name == "efficiency" ? 3.3 * std::sqrt(2.0 / (21.0 * count)) : 0;
    EXPECT_GE(check.value, check.low) << describe(checks);
    EXPECT_LE(check.value, check.high + slack) << describe(checks);
  }
}

}  // namespace

TEST(Statistics, HandheldUncertaintiesHold) { expect_accepted(handheld_run, 40); }
TEST(Statistics, StaticUncertaintiesHold) { expect_accepted(static_run, 20); }
TEST(Statistics, TurntableUncertaintiesHoldOnATableOfTwoArcseconds) { expect_accepted(arcsecond_table_run, 40); }
TEST(Statistics, TurntableUncertaintiesHoldOnATableOfOneArcminute) { expect_accepted(arcminute_table_run, 40); }
TEST(Statistics, HybridUncertaintiesHold) { expect_accepted(short_hybrid_run, 10); }
TEST(Statistics, WholeUnitUncertaintiesHold) { expect_accepted(short_whole_unit_run, 20); }

TEST(Statistics, AFlightNeedsTheWholeUnitsCompensation) {
  const DaiFlights flown = dai_flights(5);
  for (const auto& runs : {flown.with_roll, flown.without_roll})
    for (const Check& check : judge_flights(runs)) {
      // Without the roll the ratio to traditional compensation is 20 over many runs; a median of five is known to about a third.
      const double slack = check.low == 10 ? 0.6 : 0.9;
      EXPECT_GE(check.value, slack * check.low) << describe_flights(runs);
      EXPECT_LE(check.value, check.high / slack) << describe_flights(runs);
    }
}
