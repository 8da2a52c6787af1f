// Statistics of Monte Carlo runs of any number: moments and histograms, which are additive.
#pragma once

#include "imulab/core/histogram.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Statistics of each error and of the horizontal error at each output.
class RunStatistics {
 public:
  explicit RunStatistics(std::size_t outputs) : cells_((budget_quantities + 1) * outputs) {}

  /// Adds a run, one column per output.
  void add(const BudgetRows& errors);
  void add(const RunStatistics& other);
  void write(std::string& bytes) const;
  /// Reads statistics written by `write` for as many outputs, and removes them from `bytes`. Throws Error if they are incomplete.
  void read(std::string_view& bytes);
  /// Sets everything except the individual runs. `out.time` has the outputs; the drift is over `duration` [s].
  void summarize(ErrorDistribution& out, double duration) const;

 private:
  struct Cell {
    std::array<double, 3> numbers{};  ///< number of runs; mean; sum of squares about it
    Histogram values;

    void add(const std::array<double, 3>& other);
  };
  Cell& cell(Eigen::Index q, Eigen::Index at) { return cells_[static_cast<std::size_t>(at * (budget_quantities + 1) + q)]; }
  const Cell& cell(Eigen::Index q, Eigen::Index at) const { return const_cast<RunStatistics*>(this)->cell(q, at); }

  std::vector<Cell> cells_;
};

}  // namespace imulab
