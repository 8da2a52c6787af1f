#include "imulab/noise/upper_density.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::noise {

namespace {

constexpr double nodes_in_a_decade = 6;  // frequencies: a power law between them is exact
constexpr double rise_precision = 0.1;   // error of the rise of the misfit, of which the density's logarithm has half
constexpr int most_tries = 8;

std::size_t nearest_bin(const SpectrumLikelihood& problem, double hz) {
  const auto& bins = problem.bins();
  const auto after = std::find_if(bins.begin(), bins.end(), [&](const SpectrumBin& bin) { return bin.middle_hz() > hz; });
  if (after == bins.begin()) return 0;
  const auto before = after - 1;
  const bool later = after != bins.end() && after->middle_hz() / hz < hz / before->middle_hz();
  return static_cast<std::size_t>((later ? after : before) - bins.begin());
}

/// Returns the model with the largest density in a bin whose misfit is that of the best one and `rise`.
Point raised(const SpectrumLikelihood& problem, const Point& best, std::size_t bin, double rise) {
  const auto at = static_cast<Eigen::Index>(bin);
  const Point base = problem.revived(best);
  const Eigen::MatrixXd D = problem.sensitivity(base.at, problem.modeled(base.at));
  Eigen::MatrixXd information = D.transpose() * problem.counts().matrix().asDiagonal() * D;
  information.diagonal().array() += 1e-9;  // an absent term has no information
  Eigen::VectorXd gradient = D.row(at).transpose();
  gradient[Terms::Q] = 0;
  Pull pull{at, std::sqrt(2 * rise / std::max(gradient.dot(solve_semidefinite(information, gradient)), 1e-12))};
  Point found = base;
  for (int i = 0; i < most_tries; ++i) {
    found = problem.fitted(found, {}, rise_precision * rise_precision, 50, pull);
    if (!std::isfinite(found.misfit)) return base;
    const double risen =
        found.misfit + pull.weight * std::log(problem.without_quantization(problem.density(found.at)[at], found.at, at)) - best.misfit;
    if (std::abs(risen / rise - 1) < rise_precision) break;
    pull.weight *= std::clamp(std::sqrt(rise / std::max(risen, 1e-3 * rise)), 0.25, 4.0);  // the rise is as the square of the pull
  }
  return found;
}

/// Raises the bounds to those of the measured power in ranges where the model does not fit it.
void raise_to_power(std::vector<UpperDensity>& upper, const ChosenModel& model, const Spectrum& spectrum, double confidence) {
  const std::vector<PowerGroup> groups = grouped(spectrum.bins, [&](std::size_t i) { return spectrum.bins[i].power; });
  for (UpperDensity& u : upper)
    for (const PowerGroup& g : groups) {
      const auto overlaps = [&](const NoiseMisfit& m) { return m.low_hz < g.high_hz && m.high_hz > g.low_hz; };
      if (u.hz < g.low_hz || u.hz > g.high_hz) continue;
      if (g.high_hz > model.highest_hz || std::ranges::any_of(model.agreement.misfits, overlaps))
        u.density = std::max(u.density, g.sum / chi_square_quantile(1 - confidence, g.count));
    }
}

}  // namespace

std::vector<UpperDensity> upper_densities(const ChosenModel& model, const Spectrum& spectrum, double half_rate_hz, double confidence,
                                          double widening) {
  const SpectrumLikelihood& problem = model.problem;
  const double lowest = problem.bins().front().middle_hz();
  const auto steps = static_cast<std::size_t>(std::ceil(nodes_in_a_decade * std::log10(half_rate_hz / lowest)));
  std::vector<double> hz;
  for (std::size_t i = 0; i <= steps; ++i)
    hz.push_back(lowest * std::pow(half_rate_hz / lowest, static_cast<double>(i) / static_cast<double>(steps)));
  const SpectrumLikelihood shown = problem.at(hz);
  const double rise = widening * chi_square_quantile(2 * confidence - 1, 1);  // one-sided
  std::vector<UpperDensity> out;
  for (std::size_t i = 0; i < hz.size(); ++i) {
    const Point most = raised(problem, model.best, nearest_bin(problem, hz[i]), rise);
    const auto density = [&](Parameters at) {
      at[Terms::Q] = 0;
      return shown.density(at)[static_cast<Eigen::Index>(i)];
    };
    out.push_back({hz[i], std::max(density(most.at), density(model.best.at))});
  }
  raise_to_power(out, model, spectrum, confidence);
  return out;
}

}  // namespace imulab::noise
