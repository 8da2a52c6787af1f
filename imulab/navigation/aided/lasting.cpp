#include "imulab/navigation/aided/lasting.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/model/finding_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace imulab::aided {

namespace {

/// Returns the innovations by source and component, in time.
std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> series_of(const std::vector<AidedInnovation>& innovations) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<double>> out;
  std::size_t component = 0;
  for (std::size_t k = 0; k < innovations.size(); ++k) {
    const AidedInnovation& now = innovations[k];
    const bool same = k > 0 && innovations[k - 1].time == now.time && innovations[k - 1].source == now.source;
    component = same ? component + 1 : 0;
    if (!now.suspect) out[{now.source, component}].push_back(now.sigmas);
  }
  return out;
}

constexpr std::array<std::size_t, 2> block_lengths{5, 20};

/// Correlation statistics of one or several series. For white values, the first correlation is normal, and sums of blocks are chi-square distributed.
struct Likeness {
  double count = 0, squares = 0, products = 0;  // sums over adjacent values
  std::array<double, 2> chi2{}, blocks{};
  void add(const Likeness& other) {
    count += other.count, squares += other.squares, products += other.products;
    for (std::size_t k = 0; k < 2; ++k) chi2[k] += other.chi2[k], blocks[k] += other.blocks[k];
  }
};
Likeness likeness_of(const std::vector<double>& all) {
  Likeness out{.count = static_cast<double>(all.size())};
  const double squares = std::inner_product(all.begin(), all.end(), all.begin(), 0.), size = std::max(squares / out.count, 1.);
  out.squares = squares / size, out.products = std::inner_product(all.begin() + 1, all.end(), all.begin(), 0.) / size;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto length = static_cast<std::ptrdiff_t>(block_lengths[k]);
    for (auto block = all.begin(); all.end() - block >= length; block += length, ++out.blocks[k])
      out.chi2[k] += std::pow(std::accumulate(block, block + length, 0.), 2) / static_cast<double>(length) / size;
  }
  return out;
}

void take_larger(const Likeness& l, SerialCorrelation& out) {
  constexpr double improbable = 2e-5;  // per test: a drive with 15 series, including those of all components, has 45 tests
  const auto take = [&](std::size_t values, double variance, double chi2, double freedom) {
    const double times = std::sqrt(std::max(variance, 0.));
    if (times > out.times && log_chi_square_tail(chi2, freedom) < std::log(improbable)) out = {values, times};
  };
  const double first = l.products / l.count;
  take(2, l.squares / l.count + 2 * first / std::max(1 - first, 0.01), first * first * l.count, 1);  // variance of a Markov process
  for (std::size_t k = 0; k < 2; ++k)
    if (l.blocks[k] > 0) take(block_lengths[k], l.chi2[k] / l.blocks[k], l.chi2[k], l.blocks[k]);
}

}  // namespace

std::vector<SerialCorrelation> serial_correlations(const AidedNavigation& n) {
  constexpr std::size_t fewest = 30;
  std::vector<SerialCorrelation> out(n.factors.size());
  std::map<std::size_t, Likeness> together;  // all components of a source
  for (const auto& [key, all] : series_of(n.innovations)) {
    if (all.size() <= fewest) continue;
    const Likeness own = likeness_of(all);
    take_larger(own, out[key.first]);
    together[key.first].add(own);
  }
  for (const auto& [source, all] : together) take_larger(all, out[source]);
  return out;
}

namespace {

constexpr double much = 1.4;  // slow errors of another shape leave less, and uncertainties remain correct

bool has_slow_error(const Problem& p, std::size_t source) {
  return std::ranges::any_of(p.channels, [&](const Channel& c) { return c.slow >= 0 && c.first_noise == source; });
}

}  // namespace

bool widen_lasting(const Problem& p, AidedNavigation& n) {
  std::vector<SerialCorrelation> found = serial_correlations(n);
  for (std::size_t k = 0; k < found.size(); ++k)
    if (has_slow_error(p, k)) found[k] = {};
  const auto worst = std::ranges::max_element(found, {}, &SerialCorrelation::times);
  if (worst == found.end() || worst->times <= much) return false;
  n.factors[static_cast<std::size_t>(worst - found.begin())].lasting *= worst->times;
  return true;
}

void judge_lasting(AidedNavigation& n) {
  const std::vector<SerialCorrelation> found = serial_correlations(n);
  const auto worst = std::ranges::max_element(found, {}, &SerialCorrelation::times);
  if (worst == found.end() || worst->times <= much) return;
  n.findings.add<Code::lasting_errors>(Subject{n.factors[static_cast<std::size_t>(worst - found.begin())].name}, worst->values, worst->times);
}

}  // namespace imulab::aided
