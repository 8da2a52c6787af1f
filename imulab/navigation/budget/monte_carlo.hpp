// Errors of an inertial solution as a distribution: the full integration with drawn sensors, noise, starts and barometers.
#pragma once

#include "imulab/core/shared_work.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace imulab {

struct MonteCarloOptions {
  StrapdownOptions strapdown = {};
  double output_interval = 10;  // s; the end is always among the outputs
  std::uint64_t runs = 1000;
  std::uint64_t seed = 1;
};

/// As many runs are also kept by themselves: the first ones.
inline constexpr std::uint64_t most_kept_runs = 1'000'000;

/// A column for each output time; rows as in a budget, and last the horizontal position error's length [m].
struct ErrorDistribution {
  std::vector<double> time;                                                                     // s
  Eigen::Matrix<double, budget_quantities + 1, Eigen::Dynamic> mean, sigma, low, median, high;  // low, high: 5 and 95 %
  std::uint64_t runs = 0;
  std::vector<double> drift;                          // of each kept run: horizontal error at the end over the motion's time [m/s]
  double drift_rms = 0, drift_cep = 0, drift_95 = 0;  // of those; CEP: half of the runs stay below
  BudgetRows end;                                     // errors at the end, a column each kept run
  BudgetRows peak;                                    // largest absolute errors at any output, a column each kept run
};

/// The result does not depend on the number of threads and processes. `progress` is called with the number of finished runs, from any thread. The
/// barometer is read at each sample where the vertical channel uses one. With `aligned_over` each run aligns on its own noisy rest before the motion,
/// at the start's attitude. Memory does not grow with the runs: quantiles are those of histograms, at most 0.4 % off
/// (core/histogram.hpp). Throws Error where the outputs are too many for them.
ErrorDistribution error_monte_carlo(const motion::NominalMotion& motion, const ErrorSources& sources, const MonteCarloOptions& options,
                                    const std::function<void(std::uint64_t)>& progress = {}, const Sharing* sharing = nullptr);

/// The compensated output of one such unit on the motion.
std::vector<Increment> erring_increments(const motion::NominalMotion& motion, const ErrorSources& sources, std::uint64_t seed);

/// The heights that one such unit's barometer reads along the motion, at every `every`-th of its states and the last [s, m].
HeightRecord erring_heights(const motion::NominalMotion& motion, const BarometerErrors& errors, std::uint64_t seed, std::size_t every);

}  // namespace imulab
