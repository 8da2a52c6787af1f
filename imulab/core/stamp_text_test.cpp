#include "imulab/core/stamp_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace imulab {
namespace {

TEST(StampText, HasAllDigits) {
  EXPECT_EQ(stamp_text(1700000000.01), "1700000000.01");
  EXPECT_EQ(stamp_text(1700000000.0), "1700000000");
  EXPECT_EQ(stamp_text(100.0), "100");
  EXPECT_EQ(stamp_text(-0.5), "-0.5");
  EXPECT_EQ(stamp_text(-1e-9), "0");
  EXPECT_EQ(stamp_text(1e300), "1e+300");
  EXPECT_EQ(stamp_text(std::nan("")), "nan");
  EXPECT_EQ(stamp_text(std::int64_t{1'700'000'000'000'000'001}), "1700000000.000000001");
  EXPECT_EQ(stamp_text(std::int64_t{0}), "0");
  EXPECT_EQ(stamp_text(std::numeric_limits<std::int64_t>::min()), "-9223372036.854775808");
}

}  // namespace
}  // namespace imulab
