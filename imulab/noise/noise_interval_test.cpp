// At the bounds, the likelihood, maximized over all other terms, must have fallen by the 95 % quantile of chi-square.
#include "imulab/noise/noise_interval.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab::noise {
namespace {

/// Returns the rise of the misfit with a parameter at this size.
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
    // A bound has an error of at most 1 % of its distance from the value; the rise is at least quadratic in this distance.
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
