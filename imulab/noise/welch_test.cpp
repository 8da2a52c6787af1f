#include "imulab/error.hpp"
#include "imulab/noise/spectrum.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace imulab {
namespace {

/// Half of the one-sided result of SciPy 1.10.1's signal.welch(y, fs=10, nperseg=64, window="hann", detrend="constant") for the 1000 points of NBS14.
TEST(Welch, EqualsScipy) {
  std::vector<double> rate;
  std::uint64_t n = 1234567890;
  for (int i = 0; i < 1000; ++i) {
    rate.push_back(static_cast<double>(n) / 2147483647);
    n = n * 16807 % 2147483647;
  }
  const WelchSpectrum found = welch_spectrum(rate, 0.1, 64);
  EXPECT_EQ(found.pieces, 30u);
  EXPECT_EQ(found.density.size(), 31u);
  EXPECT_DOUBLE_EQ(found.spacing_hz, 0.15625);
  EXPECT_NEAR(found.density[0], 0.0044069073934009, 1e-14);
  EXPECT_NEAR(found.density[1], 0.0072785124290174, 1e-14);
  EXPECT_NEAR(found.density[9], 0.0073481319697931, 1e-14);
  EXPECT_NEAR(found.density[30], 0.011060013831049, 1e-14);
}

TEST(Welch, RefusesPiecesThatDoNotFit) {
  const std::vector<double> rate(100, 1.0);
  EXPECT_THROW(welch_spectrum(rate, 0.1, 63), Error);
  EXPECT_THROW(welch_spectrum(rate, 0.1, 4), Error);
  EXPECT_THROW(welch_spectrum(rate, 0.1, 128), Error);
}

}  // namespace
}  // namespace imulab
