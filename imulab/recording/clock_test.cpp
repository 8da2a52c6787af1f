#include "imulab/recording/clock.hpp"

#include <gmock/gmock.h>

#include <tuple>

namespace imulab {
namespace {

using ::testing::Optional;

TEST(Clock, CountsBecomeTheNearestNanosecondHoweverManyTheyAre) {
  using Case = std::tuple<double, std::int64_t, std::int64_t>;
  for (const auto& [per_second, count, time_ns] : {
           Case{1e6, 1'700'000'000'123'457, 1'700'000'000'123'457'000},    // since 1970: more digits than a double has
           Case{32768, 65'006'634'468'403, 1'983'845'046'032'806'396},     // ...396.484
           Case{32768, -138'821'498'070'425, -4'236'495'912'793'731'689},  // ...689.453
           Case{1024, 1, 976'563},
           Case{1024, -1, -976'563},  // a half goes away from zero
           Case{2.5e6, 4'611'686'018'427, 1'844'674'407'370'800},
           Case{0.5, 3, 6'000'000'000},
       }) {
    TimeSource source;
    source.column = "ticks";
    source.unit = "tick";
    source.ticks_per_s = per_second;
    EXPECT_THAT(Clock(source, std::nullopt).next(count), Optional(time_ns)) << count << " / " << per_second;
  }
}

TEST(Clock, TimesTooFarAwayAreNone) {
  TimeSource source;
  source.column = "ticks";
  source.unit = "tick";
  for (const auto& [per_second, count] : {std::pair{1.0, std::int64_t{5'000'000'000}}, {1e-300, std::int64_t{1}}, {1e6, std::int64_t{1} << 62}}) {
    source.ticks_per_s = per_second;
    EXPECT_EQ(Clock(source, std::nullopt).next(count), std::nullopt) << count << " / " << per_second;
  }
}

}  // namespace
}  // namespace imulab
