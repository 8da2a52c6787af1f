#include "imulab/navigation/budget/run_statistics.hpp"

#include "imulab/core/shared_work.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

/// Combines sums of squares about the common mean (Chan, Golub, LeVeque 1979).
void RunStatistics::Cell::add(const std::array<double, 3>& other) {
  auto& [n, mean, squares] = numbers;
  const double all = n + other[0], apart = other[1] - mean;
  if (other[0] == 0) return;
  squares += other[2] + apart * apart * n * other[0] / all;
  mean += apart * other[0] / all;
  n = all;
}

void RunStatistics::add(const BudgetRows& errors) {
  for (Eigen::Index at = 0; at < errors.cols(); ++at)
    for (Eigen::Index q = 0; q <= budget_quantities; ++q) {
      const auto value = static_cast<float>(q < budget_quantities ? errors(q, at) : errors.block<2, 1>(0, at).norm());
      cell(q, at).add({1, static_cast<double>(value), 0});
      cell(q, at).values.add(value);
    }
}

void RunStatistics::add(const RunStatistics& other) {
  for (std::size_t k = 0; k < cells_.size(); ++k) {
    cells_[k].add(other.cells_[k].numbers);
    cells_[k].values.add(other.cells_[k].values);
  }
}

void RunStatistics::write(std::string& bytes) const {
  for (const Cell& c : cells_) {
    bytes += bytes_of(c.numbers.data(), c.numbers.size());
    c.values.write(bytes);
  }
}

void RunStatistics::read(std::string_view& bytes) {
  for (Cell& c : cells_) {
    constexpr std::size_t size = sizeof c.numbers;
    read_numbers(std::string(bytes.substr(0, size)), c.numbers.data(), c.numbers.size());
    bytes.remove_prefix(size);
    c.values.read(bytes);
  }
}

void RunStatistics::summarize(ErrorDistribution& out, double duration) const {
  const auto outputs = static_cast<Eigen::Index>(out.time.size());
  for (auto* m : {&out.mean, &out.sigma, &out.low, &out.median, &out.high}) m->resize(budget_quantities + 1, outputs);
  for (Eigen::Index at = 0; at < outputs; ++at)
    for (Eigen::Index q = 0; q <= budget_quantities; ++q) {
      const Cell& c = cell(q, at);
      const auto [n, mean, squares] = c.numbers;
      out.mean(q, at) = mean;
      out.sigma(q, at) = std::sqrt(squares / std::max(1.0, n - 1));
      out.low(q, at) = c.values.quantile(0.05);
      out.median(q, at) = c.values.quantile(0.5);
      out.high(q, at) = c.values.quantile(0.95);
    }
  const auto [n, mean, squares] = cell(budget_quantities, outputs - 1).numbers;
  out.drift_rms = std::sqrt(mean * mean + squares / n) / duration;
  out.drift_cep = out.median(budget_quantities, outputs - 1) / duration;
  out.drift_95 = out.high(budget_quantities, outputs - 1) / duration;
}

}  // namespace imulab
