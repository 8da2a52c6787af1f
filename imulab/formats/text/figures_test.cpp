// Digits that the uncertainty supports, and lines that a terminal holds.
#include "imulab/formats/text/figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace imulab::text {
namespace {

TEST(Figures, AnUncertaintyHasTwoDigits) {
  EXPECT_EQ(two_digits(0.0314), "0.031");
  EXPECT_EQ(two_digits(0.0996), "0.10");
  EXPECT_EQ(two_digits(1.04), "1.0");
  EXPECT_EQ(two_digits(9.96), "10");
  EXPECT_EQ(two_digits(113), "110");
  EXPECT_EQ(two_digits(12345), "12000");
  EXPECT_EQ(two_digits(1.23e-7), "1.2e-07");
  EXPECT_EQ(two_digits(0), "0");
  EXPECT_EQ(two_digits(std::numeric_limits<double>::quiet_NaN()), "-");
}

TEST(Figures, AValueEndsWhereItsUncertaintyDoes) {
  EXPECT_EQ(to_digits_of(0.0314, 34.3034), "34.303");
  EXPECT_EQ(to_digits_of(1.4, -3628.33), "-3628.3");
  EXPECT_EQ(to_digits_of(82, -12863.9), "-12864");
  EXPECT_EQ(to_digits_of(113, 206.765), "210");
  EXPECT_EQ(to_digits_of(0.0996, 1.2345), "1.23");
  EXPECT_EQ(to_digits_of(10, -0.2), "0");
  EXPECT_EQ(to_digits_of(0, 1.25), "1.25");
  EXPECT_EQ(to_digits_of(1e-9, 1.5e-8), "1.50e-08");
  EXPECT_EQ(to_digits_of(6.1e-6, -1.309e-5), "-1.31e-05");
  EXPECT_EQ(to_digits_of(5.3e-6, 7.528e-7), "8e-07");
  EXPECT_EQ(to_digits_of(5.3e-6, 7.5e-9), "0");
  EXPECT_EQ(to_digits_of(1e-9, 9.96e-10), "1.0e-09");
  EXPECT_EQ(to_digits_of(2.4e8, -1.234e10), "-1.234e+10");
}

TEST(Figures, NumbersOfEverySize) {
  EXPECT_EQ(number(1364.2), "1360");
  EXPECT_EQ(number(-2151000), "-2150000");
  EXPECT_EQ(number(0.08732), "0.0873");
  EXPECT_EQ(number(3.1244e-6), "3.12e-06");
  EXPECT_EQ(number(2e9), "2e+09");
  EXPECT_EQ(number(0), "0");
}

TEST(Figures, LinesEndBeforeTheWidth) {
  EXPECT_EQ(wrapped("  a: ", "one two three", 12), "  a: one two\n     three\n");
  EXPECT_EQ(wrapped("", "a b c 54 %, d", 8), "a b c\n54 %, d\n");
  EXPECT_EQ(wrapped("", ""), "\n");
  EXPECT_EQ(wrapped("x ", "averyveryverylongword b", 8), "x averyveryverylongword\n  b\n");
  EXPECT_EQ(wrapped("", "\xC3\xA9\xC3\xA9 \xC3\xA9", 4), "\xC3\xA9\xC3\xA9 \xC3\xA9\n");  // four columns, seven bytes
}

}  // namespace
}  // namespace imulab::text
