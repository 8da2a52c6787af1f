#include "imulab/navigation/aided/factor_search.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/navigation/aided/observation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace imulab::aided {
namespace {

constexpr double vibration = 100;  // first factor of the sensors
constexpr double false_sigma = 3;  // too small by this factor: the size of a slow error is then unknown, too

/// Returns the ratio of white noise to its stated size from differences of some order over evenly spaced rows: noise has their variance times the sum
/// of squared weights, a smooth motion almost none.
template <class Values, class Sigmas>
double times_stated(const std::vector<std::int64_t>& time, const Values& values, const Sigmas& sigmas, const std::vector<double>& weights) {
  constexpr double even = 1.5, median_of_normal = 0.6745;
  const double size = std::sqrt(std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.));
  std::vector<double> all;
  for (std::size_t i = weights.size() - 1; i < time.size(); ++i) {
    Vector3d sum = weights[0] * values(i);
    std::int64_t least = INT64_MAX, most = 0;
    for (std::size_t k = 1; k < weights.size(); ++k) {
      sum += weights[k] * values(i - k);
      least = std::min(least, time[i - k + 1] - time[i - k]), most = std::max(most, time[i - k + 1] - time[i - k]);
    }
    if (static_cast<double>(most) > even * static_cast<double>(least)) continue;
    for (Eigen::Index k = 0; k < 3; ++k)
      if (std::isfinite(sum[k])) all.push_back(std::abs(sum[k]) / sigmas(i)[k]);
  }
  return all.empty() ? 1 : median(std::move(all)) / (median_of_normal * size);
}

/// Returns the smallest ratio of several orders, because a motion can only enlarge it, between the stated and the usual size.
template <class Values, class Sigmas>
double first_times(const std::vector<std::int64_t>& time, const Values& values, const Sigmas& sigmas, double usual) {
  std::vector<double> stated;
  for (std::size_t i = 0; i < time.size(); ++i) stated.push_back(sigmas(i).mean());
  const double third = times_stated(time, values, sigmas, {1, -3, 3, -1}), sixth = times_stated(time, values, sigmas, {1, -6, 15, -20, 15, -6, 1});
  return std::max(1., std::min({third, sixth, usual / median(std::move(stated))}));
}

void set_aid_factors(Problem& p, const Channel& c) {
  const AidRecord& r = c.aid.record;
  const AidLaw& law = aid_law(c.aid.kind);
  const bool places = !r.position.empty();
  double times = 1;
  if (places) {
    const LocalEarth earth = local_earth(r.position.front().x(), r.position.front().z());
    const auto place = [&](std::size_t i) {
      const Vector3d& at = r.position[i];
      return Vector3d(at.y() * earth.transverse_radius * earth.cos_latitude, at.x() * earth.meridian_radius, at.z());
    };
    times = first_times(
        r.time, place, [&](std::size_t i) { return position_sigma(c.aid, i); }, law.position_sigma);
  } else if (!r.value.empty()) {
    const auto value = [&](std::size_t i) { return Vector3d(r.value[i], NAN, NAN); };
    times = first_times(
        r.time, value, [&](std::size_t i) { return Vector3d::Constant(value_sigma(c.aid, i)); }, law.value_sigma);
  }
  p.sources[c.first_noise].factor = times * times;
  if (!r.velocity.empty()) {
    const auto velocity = [&](std::size_t i) { return r.velocity[i]; };
    const double of_velocity = first_times(
        r.time, velocity, [&](std::size_t i) { return velocity_sigma(c.aid, i); }, law.velocity_sigma);
    p.sources[c.second_noise].factor = of_velocity * of_velocity;
  }
  if (times < false_sigma || c.slow < 0) return;
  const StateBlock& slow = *std::ranges::find(p.blocks, c.slow, &StateBlock::first);
  p.sources[*slow.noise].factor = std::max(1., std::pow((places ? law.position_sigma : law.value_sigma) / slow.sigma, 2));
}

}  // namespace

void set_first_factors(Problem& p) {
  for (const std::size_t source : {p.gyro_source, p.accel_source}) p.sources[source].factor = vibration;
  for (const Channel& c : p.channels)
    if (has_record(c.aid.kind)) set_aid_factors(p, c);
}

double FactorSearch::update(Problem& p, const std::vector<NoiseEvidence>& evidence) {
  constexpr double least = 0.25, most = 2;  // limits of the slopes: a step is at most four times the plain one
  constexpr double believed = 4;            // number of values that represent the weight of the declared noise
  double change = 0;
  std::vector<Tried> now;
  for (std::size_t k = 0; k < p.sources.size(); ++k) {
    double& factor = p.sources[k].factor;
    const double plain = (factor * evidence[k].squares + believed) / (evidence[k].resolved + believed - 2), step = std::log(plain / factor);
    now.push_back({std::log(factor), step});
    double slope = 1;
    if (passes_ > 1 && now[k].factor != before_[k].factor)
      slope = std::clamp((before_[k].step - step) / (now[k].factor - before_[k].factor), least, most);
    factor *= std::exp(step / slope);
    if (evidence[k].resolved > 50 && passes_ > 0) change = std::max(change, std::abs(std::expm1(step / slope)));
  }
  before_ = std::move(now), ++passes_;
  return change;
}

}  // namespace imulab::aided
