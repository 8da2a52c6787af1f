#include "imulab/core/histogram.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

namespace imulab {
namespace {

std::vector<float> drawn(std::size_t count, double mean, double sigma) {
  const RandomStream stream(1, "histogram");
  std::vector<float> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(static_cast<float>(mean + sigma * stream.normal(i)));
  return out;
}

Histogram of(const std::vector<float>& values) {
  Histogram h;
  for (const float value : values) h.add(value);
  return h;
}

TEST(Histogram, QuantilesAreThoseOfTheSample) {
  for (const double mean : {0.0, 5.0, -5e9, 1e-12})
    for (const std::size_t count : {1u, 2u, 7u, 100u, 20000u}) {
      const std::vector<float> values = drawn(count, mean, 1);
      const Histogram h = of(values);
      EXPECT_EQ(h.count(), count);
      for (const double p : {0.0, 0.05, 0.5, 0.95, 1.0}) {
        const double exact = quantile({values.begin(), values.end()}, p);
        // The two numbers about a quantile are within the width of their bins; those of a small sample are mostly alone there.
        EXPECT_NEAR(h.quantile(p), exact, Histogram::relative_width * (std::abs(exact) + (count < 100 ? 0 : 1e-3)))
            << mean << " " << count << " " << p;
      }
    }
  const Histogram few = of({-3, 0, 2.5F, 1e30F});
  EXPECT_EQ(few.quantile(0), -3);
  EXPECT_EQ(few.quantile(0.5), 1.25);
  EXPECT_EQ(few.quantile(1), static_cast<double>(1e30F));
  EXPECT_TRUE(std::isnan(Histogram().quantile(0.5)));
}

TEST(Histogram, NumbersOfABinLieEvenlyInIt) {
  for (const double sign : {1.0, -1.0}) {
    std::vector<float> even;
    for (int i = 0; i <= 100000; ++i) even.push_back(static_cast<float>(sign * (1 + i * 1e-5)));
    const Histogram h = of(even);
    for (double p = 0.05; p < 0.99; p += 0.013)  // a bin is 4e-3 wide; its numbers are 1e-5 apart
      EXPECT_NEAR(h.quantile(p), sign > 0 ? 1 + p : p - 2, 3e-5) << p;
  }
}

TEST(Histogram, PartsAddUp) {
  const std::vector<float> values = drawn(5000, 0.5, 1);
  Histogram all = of({values.begin(), values.begin() + 1234});
  std::string bytes;
  of({values.begin() + 1234, values.end()}).write(bytes);
  std::string_view left = bytes;
  Histogram rest;
  rest.read(left);
  EXPECT_TRUE(left.empty());
  all.add(rest);
  for (double p = 0; p <= 1; p += 0.01) EXPECT_NEAR(all.quantile(p), of(values).quantile(p), 1e-12) << p;  // sums in another order
  for (std::size_t size = 0; size < 100; ++size) {
    std::string_view cut = std::string_view(bytes).substr(0, size);
    EXPECT_THROW(rest.read(cut), Error) << size;
  }
}

}  // namespace
}  // namespace imulab
