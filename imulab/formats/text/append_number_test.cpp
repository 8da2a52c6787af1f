#include "imulab/formats/text/append_number.hpp"

#include "imulab/core/random.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace imulab::text {
namespace {

std::string fixed(double value, int decimals) {
  std::string out;
  append_fixed(out, value, decimals);
  return out;
}

std::string four(double value) {
  std::string out;
  append_four_digits(out, value);
  return out;
}

// Every size, ties, what rounds up to another digit, zeros of both signs and what is no number.
TEST(AppendNumber, IsTheTextOfFmt) {
  std::vector<double> values{0.,           -0.,
                             0.5,          2.5,
                             0.125,        1e-13,
                             -1e-13,       9.9995,
                             99.995,       999.95,
                             9999.5,       9998.5,
                             0.00099995,   1e-4,
                             9.9999e-5,    1e4,
                             1e22,         std::numeric_limits<double>::infinity(),
                             std::nan(""), std::numeric_limits<double>::denorm_min()};
  const RandomStream draw(1, "numbers");
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const double size = std::pow(10, 12 * draw.uniform(2 * k) - 6);
    values.push_back(size * draw.normal(2 * k + 1));
    values.push_back(std::round(8 * values.back()) / 8);  // ties
  }
  for (const double value : values) {
    EXPECT_EQ(four(value), fmt::format("{:.4g}", value));
    for (const int decimals : {0, 3, 6, 9, 12}) EXPECT_EQ(fixed(value, decimals), fmt::format("{:.{}f}", value, decimals));
  }
}

}  // namespace
}  // namespace imulab::text
