#include "imulab/navigation/aided/factor_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::aided {

double FactorSearch::update(Problem& p, const std::vector<NoiseEvidence>& evidence) {
  constexpr double least = 0.25, most = 2;  // slopes: a step is at most four times the plain one
  constexpr double believed = 4;            // values that the declared noise counts for
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
