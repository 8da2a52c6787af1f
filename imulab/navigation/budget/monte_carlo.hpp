// The error distribution of an inertial solution: full integration with random sensors, noise, starts and barometers.
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace imulab {

struct MonteCarloOptions {
  StrapdownOptions strapdown = {};
  double output_interval = 10;  // s; the end is always an output
  std::uint64_t runs = 1000;
  std::uint64_t seed = 1;
};

/// Largest number of runs that are also stored individually: the first ones.
inline constexpr std::uint64_t most_kept_runs = 1'000'000;

/// Error statistics, one column per output time; rows as in a budget, and finally the length of the horizontal position error [m].
struct ErrorDistribution {
  std::vector<double> time;                                                                     // s
  Eigen::Matrix<double, budget_quantities + 1, Eigen::Dynamic> mean, sigma, low, median, high;  // low, high: 5 and 95 %
  std::uint64_t runs = 0;
  std::vector<double> drift;                          // for each stored run: horizontal error at the end divided by the duration [m/s]
  double drift_rms = 0, drift_cep = 0, drift_95 = 0;  // RMS, median (CEP) and 95 % of these runs
  BudgetRows end;                                     // errors at the end, one column per stored run
  BudgetRows peak;                                    // largest absolute errors at any output, one column per stored run
};

/// Simulates runs. The result does not depend on the number of threads and processes. `progress` is called with the number of finished runs, from any
/// thread. The barometer is read at each sample if the vertical channel uses one. With `aligned_over`, each run aligns on its own noisy rest before
/// the motion, at the attitude of the start. Memory does not grow with the runs: quantiles come from histograms, with errors of at most 0.4 %
/// (core/histogram.hpp). Throws Error if there are too many outputs for histograms.
ErrorDistribution error_monte_carlo(const motion::NominalMotion& motion, const ErrorSources& sources, const MonteCarloOptions& options,
                                    const std::function<void(std::uint64_t)>& progress = {}, const Sharing* sharing = nullptr);

/// Returns the compensated output of one such unit on the motion.
std::vector<Increment> erring_increments(const motion::NominalMotion& motion, const ErrorSources& sources, std::uint64_t seed);

/// Returns the heights [s, m] that one such unit's barometer reads along the motion, at every `every`-th state and the last.
HeightRecord erring_heights(const motion::NominalMotion& motion, const BarometerErrors& errors, std::uint64_t seed, std::size_t every);

}  // namespace imulab
