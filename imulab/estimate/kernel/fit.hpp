// The fit iteration of all methods: steps until the correction is small; then priors that the data contradict are widened, or suspects dropped, and
// the steps are repeated. A suspect is a part of the data that may be bad as a whole: a rest, a rotation, a step of a table, a point of a machine.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/stop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace imulab::kernel {

/// The result of one step of a fit.
enum class Progress { moving, converged, stuck };

/// Takes at most `most` steps until one converges or is stuck; step(number) returns its progress. Returns true if the fit converged. Throws Stopped
/// between two steps if a stop was requested.
template <class Step>
bool iterate(int most, Step&& step) {
  for (int number = 0; number < most; ++number) {
    count_iteration();
    if (const Progress progress = step(number); progress != Progress::moving) return progress == Progress::converged;
  }
  return false;
}

/// Returns true if every correction is below 1 % of the parameter's standard deviation. Fixed parameters (sigma 0) count as converged.
inline bool is_small(const Eigen::VectorXd& correction, const Eigen::VectorXd& sigma) {
  return (sigma.array() > 0).select(correction.cwiseAbs() - 0.01 * sigma, 0).maxCoeff() <= 0;
}

/// Fits, and repeats the fit while an amendment changes something, at most `rounds` times. Amendments are tried in order; each widens priors or drops
/// suspects, and returns true if it did.
template <class Fit, class... Amendment>
void refine(int rounds, Fit&& fit, Amendment&&... amend) {
  fit();
  for (int round = 0; round < rounds && (amend() || ...); ++round) fit();
}

struct Suspect {
  std::string name;            ///< name in messages: "the rest at 12.3 s"
  double log_probability = 0;  ///< natural logarithm of the p-value of its deviation
};

/// The deviation of a part of the data: the decrease of chi-square if it is left out, and its degrees of freedom.
struct Deviation {
  double chi2 = 0;
  int degrees_of_freedom = 0;
  /// Returns the natural logarithm of the p-value; by the F distribution if the size of the residuals was estimated with finite `residual_degrees`.
  double log_probability(double residual_degrees = std::numeric_limits<double>::infinity()) const;
  /// Returns the log likelihood ratio between the most probable and the expected size of the residuals.
  double evidence() const;
};

/// Computes the deviation from a part's residuals after the fit (or a linear map of them), their covariance, and the covariance without adaptation of
/// the fit. Combinations to which the fit adapts fully (a millionth of the variance remains) do not count.
Deviation deviation(const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& unfitted);

/// Returns the indices of suspects with p-values below `level`, the least probable first.
inline std::vector<std::size_t> improbable(const std::vector<Suspect>& suspects, double level) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < suspects.size(); ++i)
    if (!(suspects[i].log_probability > std::log(level))) found.push_back(i);
  const auto size = [&](std::size_t i) { return std::isnan(suspects[i].log_probability) ? -HUGE_VAL : suspects[i].log_probability; };
  std::stable_sort(found.begin(), found.end(), [&](std::size_t a, std::size_t b) { return size(a) < size(b); });
  return found;
}

template <class Fit>
struct Cleaned {
  Fit fit;
  std::vector<std::string> dropped;  ///< names in the order of rejection
  std::string worst;                 ///< first improbable suspect; empty if there is none
  bool clean = true;                 ///< false: improbable suspects remain that the fit needs
};

/// Drops suspects one by one, the least probable first, while the p-value is below `level` divided by their number (Bonferroni). A Fit has
///   std::vector<Suspect> suspects()
///   bool may_drop(std::size_t suspect)  enough remains without it
///   Fit without(std::size_t suspect)    the fit of the other data
template <class Fit>
Cleaned<Fit> drop_suspects(Fit fit, double level) {
  Cleaned<Fit> out{std::move(fit), {}, {}, true};
  for (;;) {
    stop_point();
    const std::vector<Suspect> suspects = out.fit.suspects();
    const std::vector<std::size_t> found = improbable(suspects, level / static_cast<double>(std::max<std::size_t>(suspects.size(), 1)));
    if (found.empty()) return out;
    const std::size_t worst = found.front();
    if (out.worst.empty()) out.worst = suspects[worst].name;
    if (!out.fit.may_drop(worst)) {
      out.clean = false;
      return out;
    }
    out.dropped.push_back(suspects[worst].name);
    out.fit = out.fit.without(worst);
  }
}

}  // namespace imulab::kernel
