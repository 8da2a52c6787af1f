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

/// White noise of the sensors, whose size the passes are to find as that of the aids.
void draw_noise(Problem& p) {
  constexpr std::uint64_t seed = 1;
  const RandomStream draws(seed, "foreseen sensors");
  std::uint64_t drawn = 0;
  for (TimedIncrement& sample : p.samples) {
    const double root = std::sqrt(sample.interval);
    for (Index k = 0; k < 3; ++k) {
      sample.increment.angle[k] += root * p.gyro_noise[k] * draws.normal(drawn++);
      sample.increment.velocity[k] += root * p.accel_noise[k] * draws.normal(drawn++);
    }
  }
}

}  // namespace

AidedNavigation foresee(const SensorPriors& priors, const Session& session, const motion::NominalMotion& motion, const std::vector<Aid>& aids,
                        int passes, const OutputTerms* terms) {
  const Recording recording = ideal_readings(motion);
  Problem p = make_problem(recording, priors, aids, session);
  add_first_rest(p, recording, session);
  draw_noise(p);
  set_first_factors(p);
  const FilterStart start = start_near(p, motion.states.front());
  AboutTrajectory about{.states = motion.states, .x = start.mean.x, .weights = {}};
  AidedNavigation out;
  FilterPass pass;
  SmootherPass smoothed;
  FactorSearch search;
  while (out.passes < passes && !out.converged) {
    pass = filter(p, start, {.about = &about});
    smoothed = smooth(p, pass);
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
      if (!std::isfinite(b.time) && b.prior[k] > 0) out.constants[at++].value = prior.mean[b.first + k];
  for (; at < out.constants.size(); ++at) out.constants[at].value = 0;
  for (std::size_t k = 0; k < pass.nodes.size(); ++k)
    out.covariance.push_back({pass.nodes[k].samples > 0 ? p.time[pass.nodes[k].samples - 1] : p.begin, smoothed.nodes[k].covariance});
  if (std::string text = hidden_heading(out); !text.empty()) out.doubts.push_back(std::move(text));
  return out;
}

}  // namespace imulab::aided
