// Bounds are where the likelihood, maximized over all other terms, has fallen by what 95 % of chi-square do not exceed.
#include "imulab/noise/noise_interval.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab::noise {
namespace {

/// The rise of the misfit with a parameter at this size.
double rise_at(const SpectrumLikelihood& problem, const Point& best, int parameter, double size) {
  Point start = problem.revived(best);
  start.at[parameter] = 2 * std::log(size);
  return problem.fitted(start, {parameter, {}}).misfit - best.misfit;
}

TEST(NoiseInterval, EndsWhereTheMisfitHasRisenByChiSquare) {
  std::vector<double> rate(8192);
  const AxisNoise noise({.N = 1, .K = 0.02}, 0.1, 3, "noise of intervals");
  noise.add_slow(rate);
  noise.add_fast(0, rate);
  const Spectrum spectrum = spectrum_of(rate, 0.1);
  const SpectrumLikelihood problem(spectrum, 10, 0, {});
  const Point best = problem.fitted(problem.revived(problem.fitted(problem.start())));
  const double rise = chi_square_quantile(0.95, 1);
  int determined = 0, bounded = 0;
  for (const int parameter : {Terms::N, Terms::B, Terms::K}) {
    const NoiseCoefficient c = size_of(problem, best, parameter, 1);
    (c.determined ? determined : bounded)++;
    // A bound is found to a hundredth of its distance from the value; the rise goes with the square of it, or faster.
    EXPECT_NEAR(rise_at(problem, best, parameter, c.upper), rise, 0.1 * rise) << parameter;
    if (c.determined) {
      EXPECT_NEAR(rise_at(problem, best, parameter, c.lower), rise, 0.1 * rise) << parameter;
    }
  }
  EXPECT_GE(determined, 1);
  EXPECT_GE(bounded, 1) << "a term that is not determined has its bound there, too";
}

}  // namespace
}  // namespace imulab::noise
