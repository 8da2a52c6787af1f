#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/recording/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace imulab {
namespace {

Recording stamped(const std::function<double(std::size_t)>& stamp_s) {
  Recording r;
  r.interval_s = 0.01;
  for (std::size_t i = 0; i < 5000; ++i) r.time_ns.push_back(std::llround(1e9 * stamp_s(i)));
  return r;
}

/// Most samples a little late, some by two intervals, as a serial line delivers them.
double lateness(std::size_t i) {
  const RandomStream random(1, "lateness");
  const double u = random.uniform(i);
  return u > 0.95 ? 0.02 * random.uniform(100000 + i) : 0.004 * u;
}

TEST(EvenStamps, OfASerialLineAreItsSensorsClock) {
  Recording r = stamped([](std::size_t i) { return 3 + 0.01001 * static_cast<double>(i) + lateness(i); });
  const auto clock = replacing_clock(r, Stamps::automatic);
  ASSERT_TRUE(clock);
  r = with_even_stamps(r, *clock);
  EXPECT_NEAR(r.interval_s, 0.01001, 1e-8);  // the earliest of fifty are late by 0.1 ms at most, over 50 s: 2e-9 of slope for each
  for (std::size_t i = 0; i < r.size(); i += 100) EXPECT_NEAR(r.time_s(i), 3 + 0.01001 * static_cast<double>(i), 3e-4) << i;
}

TEST(EvenStamps, ThatAreEvenStay) {
  const Recording r = stamped([](std::size_t i) { return 0.01 * static_cast<double>(i); });
  EXPECT_FALSE(replacing_clock(r, Stamps::automatic));
}

TEST(EvenStamps, StayWhereSamplesAreMissingOrTheClockWanders) {
  for (const auto& stamp :
       {std::function<double(std::size_t)>([](std::size_t i) { return 0.01 * static_cast<double>(i + (i > 2500)) + lateness(i); }),
        std::function<double(std::size_t)>([](std::size_t i) {
          const double t = 0.01 * static_cast<double>(i);
          return t + 0.005 * std::sin(0.2 * t) + lateness(i);
        })}) {
    Recording r = stamped(stamp);
    EXPECT_FALSE(replacing_clock(r, Stamps::automatic));
    EXPECT_THROW(replacing_clock(r, Stamps::uniform), Error);
  }
}

TEST(EvenStamps, StayWhereThatIsWanted) {
  Recording r = stamped([](std::size_t i) { return 0.01 * static_cast<double>(i) + lateness(i); });
  EXPECT_FALSE(replacing_clock(r, Stamps::recorded));
}

}  // namespace
}  // namespace imulab
