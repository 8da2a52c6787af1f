#include "imulab/navigation/aided/outages.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::aided {
namespace {

/// Returns the outage of each withheld stamp; a new one begins after the previous one has ended.
std::vector<Outage> withheld_times(const Problem& p) {
  std::vector<Outage> out;
  for (const Observation& o : p.observations) {
    if (!o.withheld) continue;
    constexpr double apart = 5;  // s: fixes within one outage are closer
    if (out.empty() || o.stamp - out.back().end > apart) out.push_back({o.stamp, o.stamp});
    out.back().end = o.stamp;
  }
  return out;
}

struct Sum {
  double squares = 0;
  std::size_t fixes = 0;
};

}  // namespace

void add_outages(const Problem& p, const std::vector<Withheld>& withheld, OutageErrors OutageResult::*part, std::vector<OutageResult>& outages) {
  if (outages.empty())
    for (const Outage& o : withheld_times(p)) outages.push_back({.begin = o.begin, .end = o.end, .predicted = {}, .smoothed = {}});
  std::vector<Sum> sums(outages.size());
  for (const auto& [observation, source, residual, variance] : withheld) {
    const Observation& o = p.observations[observation];
    const Channel& c = p.channels[o.channel];
    const bool positions = c.aid.kind == AidKind::gnss || !c.aid.record.place.empty();
    if (!positions || residual.size() < 3 || source != c.first_noise) continue;
    const auto at = std::ranges::find_if(outages, [&](const OutageResult& r) { return o.stamp >= r.begin && o.stamp <= r.end; });
    OutageErrors& errors = *at.*part;
    const double horizontal = std::hypot(residual[0], residual[1]);
    if (horizontal > errors.horizontal) errors.horizontal = horizontal, errors.sigma = std::sqrt(variance[0] + variance[1]);
    errors.vertical = std::max(errors.vertical, std::abs(residual[2]));
    Sum& sum = sums[static_cast<std::size_t>(at - outages.begin())];
    sum.squares += (residual[0] * residual[0] / variance[0] + residual[1] * residual[1] / variance[1]) / 2, ++sum.fixes;
  }
  for (std::size_t k = 0; k < outages.size(); ++k) {
    outages[k].fixes = sums[k].fixes;
    (outages[k].*part).ratio = sums[k].fixes > 0 ? std::sqrt(sums[k].squares / static_cast<double>(sums[k].fixes)) : 0;
  }
}

}  // namespace imulab::aided
