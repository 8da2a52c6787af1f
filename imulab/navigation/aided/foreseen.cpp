#include "imulab/navigation/aided/foreseen.hpp"

#include "imulab/core/random.hpp"
#include "imulab/navigation/aided/factor_search.hpp"
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/start.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace imulab::aided {

using Eigen::Index;

Recording ideal_readings(const motion::NominalMotion& motion) {
  std::vector<double> time(motion.time.begin() + 1, motion.time.end());
  Columns3 gyro, accel;
  for (std::size_t i = 0; i < motion.increments.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double T = motion.time[i + 1] - motion.time[i];
      gyro[k].push_back(motion.increments[i].angle[static_cast<Index>(k)] / T);
      accel[k].push_back(motion.increments[i].velocity[static_cast<Index>(k)] / T);
    }
  return make_recording(time, std::move(gyro), std::move(accel));
}

namespace {

/// Adds white noise of the sensors. The passes estimate its size and the size of the aids' noise.
Recording with_noise(Recording r, const Problem& p) {
  constexpr std::uint64_t seed = 1;
  const RandomStream draws(seed, "foreseen sensors");
  std::uint64_t drawn = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double root = std::sqrt(r.interval(i, false));
    for (std::size_t k = 0; k < 3; ++k) {
      r.gyro[k][i] += p.gyro_white[static_cast<Index>(k)] / root * draws.normal(drawn++);
      r.accel[k][i] += p.accel_white[static_cast<Index>(k)] / root * draws.normal(drawn++);
    }
  }
  return r;
}

}  // namespace

AidedNavigation foresee(const SensorPriors& priors, const Session& session, const motion::NominalMotion& motion, const std::vector<Aid>& aids,
                        int passes, const OutputTerms* terms) {
  const Recording recording = ideal_readings(motion);
  Problem p = make_problem(recording, priors, aids, session);
  add_first_rest(p, recording, session);
  const Recording noisy = with_noise(recording, p);
  p.samples = IncrementView(noisy);
  set_first_factors(p);
  const FilterStart start = start_near(p, motion.states.front());
  AboutTrajectory about{.at = [&](std::size_t samples) { return motion.states[samples]; }, .x = start.mean.x, .weights = {}};
  AidedNavigation out;
  SmootherPass smoothed;
  FactorSearch search;
  while (out.passes < passes && !out.converged) {
    smoothed = smooth(p, filter(p, start, {.about = &about}));
    about.weights = smoothed.weights;
    out.factors.clear();
    for (std::size_t k = 0; k < p.sources.size(); ++k) out.factors.push_back({p.sources[k].name, p.sources[k].factor, smoothed.evidence[k].resolved});
    ++out.passes;
    out.converged = search.update(p, smoothed.evidence) < settled && out.passes > 2;
  }
  for (const Channel& c : p.channels) out.aids.push_back(c.name);
  if (terms)
    add_constants_with(*terms, p, start, about, out);
  else
    add_constants(p, smoothed, out);
  const Prior prior = prior_of(p);
  std::size_t at = 0;
  for (const StateBlock& b : p.blocks)
    for (Index k = 0; k < b.size; ++k)
      if (is_result(p, b) && b.prior[k] > 0) out.constants[at++].value = prior.mean[b.first + k];
  for (; at < out.constants.size(); ++at) out.constants[at].value = 0;
  for (const SmoothedNode& node : smoothed.nodes) out.covariance.push_back({p.time_after(node.samples), node.covariance});
  judge_heading(out);
  return out;
}

}  // namespace imulab::aided
