#include "imulab/noise/noise_type.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::noise {

namespace {

using Run = std::vector<double>;
constexpr std::size_t run_length = 1024, most_runs = 8;
constexpr std::size_t fewest_averages = 30;  // for an autocorrelation

/// Averages first and following over m samples (times m).
Run averages(const std::vector<double>& phase, std::size_t m, std::size_t first, std::size_t count) {
  Run run(count);
  for (std::size_t j = 0; j < count; ++j) run[j] = phase[(first + j + 1) * m] - phase[(first + j) * m];
  return run;
}

std::vector<Run> runs_of(const std::vector<double>& phase, std::size_t m) {
  const std::size_t count = (phase.size() - 1) / m;
  if (count <= run_length * most_runs) return {averages(phase, m, 0, count)};
  std::vector<Run> runs;
  for (std::size_t k = 0; k < most_runs; ++k) runs.push_back(averages(phase, m, k * (count - run_length) / (most_runs - 1), run_length));
  return runs;
}

void remove_line(Run& run) {
  const auto n = static_cast<double>(run.size());
  double mean = 0, slope = 0;
  for (const double v : run) mean += v / n;
  for (std::size_t j = 0; j < run.size(); ++j) slope += (static_cast<double>(j) - 0.5 * (n - 1)) * run[j];
  slope *= 12 / (n * (n * n - 1));
  for (std::size_t j = 0; j < run.size(); ++j) run[j] -= mean + slope * (static_cast<double>(j) - 0.5 * (n - 1));
}

/// Lag-1 autocorrelation about each run's mean; 0 where nothing varies.
double autocorrelation(const std::vector<Run>& runs) {
  double products = 0, squares = 0;
  for (const Run& run : runs) {
    double mean = 0;
    for (const double v : run) mean += v;
    mean /= static_cast<double>(run.size());
    for (const double v : run) squares += (v - mean) * (v - mean);
    for (std::size_t j = 1; j < run.size(); ++j) products += (run[j] - mean) * (run[j - 1] - mean);
  }
  return squares > 0 ? products / squares : 0;
}

int by_autocorrelation(std::vector<Run> runs, int least) {
  for (Run& run : runs) remove_line(run);
  const int most_differences = -least / 2;
  for (int d = 0;; ++d) {
    const double r = autocorrelation(runs), delta = r / (1 + r);
    if (delta < 0.25 || d == most_differences) return std::clamp(static_cast<int>(std::lround(-2 * (delta + d))), least, 2);
    for (Run& run : runs) {
      for (std::size_t j = 0; j + 1 < run.size(); ++j) run[j] = run[j + 1] - run[j];
      run.pop_back();
    }
  }
}

/// B1 of n averages for noise whose Allan variance goes as tau^mu.
double barnes_ratio(double n, int mu) {
  if (mu == 0) return n * std::log(n) / (2 * (n - 1) * std::log(2.0));
  return n * (1 - std::pow(n, mu)) / (2 * (n - 1) * (1 - std::pow(2.0, mu)));
}

int by_variance_ratio(const Run& run, int least) {
  const auto n = static_cast<double>(run.size());
  double mean = 0, standard = 0, allan = 0;
  for (const double v : run) mean += v / n;
  for (const double v : run) standard += (v - mean) * (v - mean) / (n - 1);
  for (std::size_t j = 1; j < run.size(); ++j) allan += (run[j] - run[j - 1]) * (run[j] - run[j - 1]) / (2 * (n - 1));
  if (allan == 0) return 0;
  // The boundary between two types: the geometric mean of what they give. alpha = 2 and 1 give the same.
  int alpha = 2;
  for (int mu = -1; - mu - 1 >= least; ++mu) {
    if (standard / allan < std::sqrt(barnes_ratio(n, mu) * barnes_ratio(n, mu - 1))) break;
    alpha = -mu - 1;
  }
  return alpha;
}

}  // namespace

int noise_type(const std::vector<double>& phase, std::size_t m, int least) {
  const std::size_t samples = phase.size() - 1;
  m = std::min(m, samples / 3);
  if (samples / m >= fewest_averages) return by_autocorrelation(runs_of(phase, m), least);
  const int by_ratio = by_variance_ratio(averages(phase, m, 0, samples / m), least);
  const std::size_t longest = samples / fewest_averages;
  return longest == 0 ? by_ratio : std::min(by_ratio, by_autocorrelation(runs_of(phase, longest), least));
}

}  // namespace imulab::noise
