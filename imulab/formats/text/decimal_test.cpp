#include "imulab/formats/text/decimal.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>
#include <string_view>

namespace imulab::text {
namespace {

using Status = ScaledInteger::Status;

ScaledInteger read(std::string_view text, int exponent = 9) { return scaled_integer(text.data(), text.data() + text.size(), exponent); }

TEST(Decimal, ReadsStampsExactly) {
  const struct {
    std::string_view text;
    int exponent;
    std::int64_t expected;
  } cases[] = {
      {"1700000000.123456789", 9, 1'700'000'000'123'456'789},
      {"1.7e9", 9, 1'700'000'000'000'000'000},
      {"1700000000123456789", 0, 1'700'000'000'123'456'789},
      {"1.700000000123456789E+18", 0, 1'700'000'000'123'456'789},
      {"9223372036854775807", 0, std::numeric_limits<std::int64_t>::max()},
      {"-0.000000001", 9, -1},
      {"+5.", 9, 5'000'000'000},
      {".5", 6, 500'000},
      {"12345678901234567890e-10", 0, 1'234'567'890},      // a 20th digit
      {"1.234567890123456789012345e9", 0, 1'234'567'890},  // more digits than are held
      {"0.4999999999", 0, 0},                              // below one: to the nearest,
      {"0.5", 0, 1},                                       // a half away from zero
      {"-0.5", 0, -1},
      {"1e-40", 9, 0},
      {"0e99999999999", 9, 0},
      {"0000000000000000000000000000001", 0, 1},
      {"1234567890123456789.5", 0, 1'234'567'890'123'456'790},
  };
  for (const auto& c : cases) {
    const ScaledInteger result = read(c.text, c.exponent);
    EXPECT_EQ(result.status, Status::good) << c.text;
    EXPECT_EQ(result.value, c.expected) << c.text;
    EXPECT_EQ(result.end, c.text.data() + c.text.size()) << c.text;
  }
}

TEST(Decimal, RefusesWhatIsNoNumberOrDoesNotFit) {
  for (const std::string_view text : {"", "-", ".", "e5", "abc", "1e", "1e+-5", "nan", "inf", "--1"}) {
    const ScaledInteger result = read(text);
    EXPECT_FALSE(result.status == Status::good && result.end == text.data() + text.size()) << text;
  }
  for (const std::string_view text : {"9223372036.854775808", "1e19", "99999999999999999999999", "1e99999999999"})
    EXPECT_EQ(read(text).status, Status::too_large) << text;
}

TEST(Decimal, PrintsNanosecondsAsSeconds) {
  EXPECT_EQ(seconds_text(0), "0");
  EXPECT_EQ(seconds_text(1'700'000'000'123'456'789), "1700000000.123456789");
  EXPECT_EQ(seconds_text(-500'000'000), "-0.5");
  EXPECT_EQ(seconds_text(10'000'000), "0.01");
  EXPECT_EQ(seconds_text(std::numeric_limits<std::int64_t>::min()), "-9223372036.854775808");
}

RC_GTEST_PROP(Decimal, ReadsBackWhatItPrints, ()) {
  const auto ns = *rc::gen::inRange(-std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::max());
  const std::string text = seconds_text(ns);
  const ScaledInteger back = read(text);
  RC_ASSERT(back.status == Status::good);
  RC_ASSERT(back.value == ns);
  RC_ASSERT(back.end == text.data() + text.size());
}

}  // namespace
}  // namespace imulab::text
