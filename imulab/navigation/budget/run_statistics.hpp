// What is kept of the runs of a Monte Carlo, however many there are: moments and histograms, which add up.
#pragma once

#include "imulab/core/histogram.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Of each error at each output, and of the horizontal error.
class RunStatistics {
 public:
  explicit RunStatistics(std::size_t outputs) : cells_((budget_quantities + 1) * outputs) {}

  /// A run: a column for each output.
  void add(const BudgetRows& errors);
  void add(const RunStatistics& other);
  void write(std::string& bytes) const;
  /// From the front of what `write` appended for as many outputs. Throws Error where it is cut.
  void read(std::string_view& bytes);
  /// Sets all but the single runs. `out.time` has the outputs; the drift is that over `duration` [s].
  void summarize(ErrorDistribution& out, double duration) const;

 private:
  struct Cell {
    std::array<double, 3> numbers{};  ///< of runs; mean; sum of squares about it
    Histogram values;

    void add(const std::array<double, 3>& other);
  };
  Cell& cell(Eigen::Index q, Eigen::Index at) { return cells_[static_cast<std::size_t>(at * (budget_quantities + 1) + q)]; }
  const Cell& cell(Eigen::Index q, Eigen::Index at) const { return const_cast<RunStatistics*>(this)->cell(q, at); }

  std::vector<Cell> cells_;
};

}  // namespace imulab
