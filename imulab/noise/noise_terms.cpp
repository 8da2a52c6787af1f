#include "imulab/noise/noise_terms.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise/spectral_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace imulab::noise {

namespace {

/// Required decrease of -2 ln likelihood for a term with one or two parameters, searched at several dozen points: p = 0.001.
constexpr double least_gain = 18;
constexpr int most_processes = 2, coarse_iterations = 15;
constexpr double coarse_precision = 0.5;
constexpr std::size_t fewest_bins = 12;
constexpr LowPassShape low_passes[] = {{1, false}, {1, true}, {2, false}, {2, true}, {4, false}, {4, true}};

/// Returns the misfit with nonnegative Q^2: a negative value only prevents bias of the other terms and must not represent a low-pass.
double misfit_of(const SpectrumLikelihood& problem, const Point& best) {
  if (best.at[Terms::Q] >= 0) return best.misfit;
  Point at_bound = best;
  at_bound.at[Terms::Q] = 0;
  return problem.fitted(at_bound, {Terms::Q, {}}, coarse_precision).misfit;
}

double density_near(const SpectrumLikelihood& problem, const Eigen::ArrayXd& density, double hz) {
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < problem.bins().size(); ++i)
    if (std::abs(std::log(problem.bins()[i].middle_hz() / hz)) < std::abs(std::log(problem.bins()[nearest].middle_hz() / hz))) nearest = i;
  return density[static_cast<Eigen::Index>(nearest)];
}

/// Returns the point with other terms; its processes and cutoff do not change.
Point moved(const Point& from, const Terms& old, const Terms& terms) {
  Point out = from;
  out.at.resize(terms.count());
  out.at.head(4 + 2 * old.markov) = from.at.head(4 + 2 * old.markov);
  if (old.low_pass.order > 0 && terms.low_pass.order > 0) out.at[terms.cutoff()] = from.at[old.cutoff()];
  return out;
}

std::optional<Model> best_of(const SpectrumLikelihood& problem, const std::vector<Point>& starts) {
  std::optional<Point> best;
  for (const Point& start : starts)
    if (const Point p = problem.fitted(start, {}, coarse_precision, coarse_iterations); std::isfinite(p.misfit) && (!best || p.misfit < best->misfit))
      best = p;
  if (!best) return {};
  *best = problem.fitted(problem.revived(*best));
  return Model{problem, *best, misfit_of(problem, *best)};
}

/// Returns true if a process dominates the highest frequencies, as white noise through a filter does.
bool stands_for_a_filter(const Model& model) {
  const Terms& terms = model.problem.terms();
  const Eigen::ArrayXd density = model.problem.density(model.best.at);
  const SpectrumBin& highest = model.problem.bins().back();
  for (int m = 0; m < terms.markov; ++m)
    if (std::exp(model.best.at[Terms::sigma(m)]) *
            MarkovDensity(std::exp(model.best.at[Terms::time(m)])).at(highest.interval, cosine_over_interval(highest)) >
        0.5 * density[density.size() - 1])
      return true;
  return false;
}

/// Adds another process, tried at correlation times that differ by factors of 3, with a third of the power near its corner.
std::optional<Model> with_process(const Model& model, double shortest_s, double record_s) {
  Terms terms = model.problem.terms();
  const int place = terms.markov++;
  const SpectrumLikelihood problem = model.problem.with(terms);
  const Eigen::ArrayXd density = model.problem.density(model.best.at);
  std::vector<Point> starts;
  const Point base = moved(model.problem.revived(model.best), model.problem.terms(), terms);
  for (double time = 3 * shortest_s; time < record_s / 11; time *= 3) {
    Point start = base;
    const double corner = 1 / (2 * std::numbers::pi * time);
    start.at[Terms::time(place)] = std::log(time);
    start.at[Terms::sigma(place)] = std::log(density_near(problem, density, corner) / (3 * time));  // its density there is sigma^2 time
    starts.push_back(start);
  }
  std::optional<Model> found = best_of(problem, starts);
  if (found && stands_for_a_filter(*found)) return {};
  return found;
}

std::optional<Model> with_low_pass(const Model& model, const LowPassShape& shape, double highest_hz) {
  Terms terms = model.problem.terms();
  const bool other = terms.low_pass.order > 0;
  terms.low_pass = shape;
  std::vector<Point> starts;
  const SpectrumLikelihood problem = model.problem.with(terms);
  const Point base = moved(model.problem.revived(model.best), model.problem.terms(), terms);
  if (other) starts.push_back(base);
  for (double cutoff = 0.95 * highest_hz; !other && cutoff > highest_hz / 64; cutoff /= 1.6) {
    Point start = base;
    start.at.head(4) = problem.start(cutoff / 2).at.head(4);
    start.at[Terms::Q] = 0;
    start.at[terms.cutoff()] = std::log(cutoff);
    starts.push_back(start);
  }
  return best_of(problem, starts);
}

/// Chooses the model; the caller sets `agreement` and `highest_hz`.
ChosenModel choose(const SpectrumLikelihood& simple, double shortest_s, double record_s, double highest_hz, bool filters,
                   const std::optional<NoiseModelTerms>& given) {
  const Point best = simple.fitted(simple.revived(simple.fitted(simple.start())));
  Model model{simple, best, misfit_of(simple, best)};
  for (;;) {
    std::optional<Model> chosen;
    double most = 0;
    const auto offer = [&](std::optional<Model> found, double price) {
      if (!found || model.misfit - found->misfit - price < most) return;
      most = model.misfit - found->misfit - price;
      chosen = std::move(found);
    };
    const Terms& terms = model.problem.terms();
    for (const LowPassShape& shape : low_passes)
      if (filters && shape != terms.low_pass) offer(with_low_pass(model, shape, highest_hz), terms.low_pass.order > 0 ? 1 : least_gain);
    std::optional<Model> wider;
    if (given && terms.markov < given->processes) {
      chosen = with_process(model, shortest_s, record_s);
      if (!chosen) throw Unsupported(fmt::format("the spectrum has no place for {} processes; expected a longer log, or fewer", given->processes));
    }
    if (!given && terms.markov < most_processes) wider = with_process(model, shortest_s, record_s);
    if (wider && model.best.misfit - wider->best.misfit >= least_gain) offer(wider, least_gain + 2);
    if (!chosen) return {std::move(model), std::move(wider), 0, {}};
    model = std::move(*chosen);
  }
}

/// Returns measured over modeled power in ranges of at least 20 degrees of freedom and a third of an octave.
Agreement agreement_of(const Model& model) {
  const SpectrumLikelihood& problem = model.problem;
  const Eigen::ArrayXd ratio = problem.power(model.best.ramp) / problem.density(model.best.at);
  const std::vector<PowerGroup> groups = grouped(problem.bins(), [&](std::size_t i) { return ratio[static_cast<Eigen::Index>(i)]; });
  Agreement out;
  const double by_chance = 0.001 / static_cast<double>(groups.size());
  for (const PowerGroup& g : groups) {
    const double tail = chi_square_tail(g.sum, g.count);
    if (std::min(tail, 1 - tail) < 0.5 * by_chance) out.misfits.push_back({g.low_hz, g.high_hz, g.sum / g.count});
    out.chi2_per_dof += std::pow(g.sum / g.count - 1, 2) * g.count / 2;
  }
  out.chi2_per_dof /= std::max(1.0, static_cast<double>(groups.size()) - problem.terms().count() - 1);
  return out;
}

}  // namespace

ChosenModel choose_terms(const Spectrum& spectrum, double half_rate_hz, double resolution, const std::optional<NoiseModelTerms>& model) {
  Terms terms;
  if (model) terms.has = {model->Q, true, model->B, model->K};
  const double shortest = 0.5 / half_rate_hz;
  std::optional<ChosenModel> chosen;
  for (double highest = 2 * half_rate_hz; highest > half_rate_hz / 32; highest = std::min(highest, half_rate_hz) * 0.8) {
    const SpectrumLikelihood simple(spectrum, highest, resolution, terms);
    if (simple.bins().size() < fewest_bins) break;
    ChosenModel found = choose(simple, shortest, spectrum.record_s, std::min(highest, half_rate_hz), highest > half_rate_hz, model);
    found.highest_hz = highest;
    found.agreement = agreement_of(found);
    // A significantly negative quantization (three sigma) represents a filter.
    const bool holds = found.agreement.misfits.empty() && found.misfit - found.best.misfit < 9;
    if (!chosen || holds || found.agreement.chi2_per_dof < chosen->agreement.chi2_per_dof) chosen = std::move(found);
    if (holds) break;
  }
  if (!chosen) throw Unsupported("too few frequencies are left to see noise; expected a longer record");
  return *chosen;
}

namespace {

constexpr std::size_t most_lines = 8, lowest_ordinate = 8, around = 5, shortest_block = 16, longest_block = 128;
constexpr double chance = 1e-3;       // for a line in a log without one
constexpr double left_at_most = 0.3;  // fraction of the excess near a line, after its removal

struct Peak {
  std::size_t level = 0, ordinate = 0;
  double hz = 0, noise = 0;  // density near it
};

/// Density and its degrees of freedom.
struct Floor {
  double noise = 0, degrees = 0;
};

/// Converts the median of ordinates with `transforms` degrees of freedom each to a mean. Its variance is 1 / (4 n density^2) at the median.
class MedianFloor {
 public:
  explicit MedianFloor(double transforms) {
    const double median = chi_square_quantile(0.5, transforms), step = 1e-4 * median;
    const double density = (chi_square_tail(median - step, transforms) - chi_square_tail(median + step, transforms)) / (2 * step);
    of_one_ = median / transforms;
    degrees_of_one_ = 8 * std::pow(median * density, 2);
  }
  Floor operator()(const SpectrumLevel& level, std::size_t first, std::size_t end) const {
    const auto at = [&](std::size_t k) { return level.power.begin() + static_cast<std::ptrdiff_t>(k); };
    return {median({at(first), at(end)}) / of_one_, degrees_of_one_ * static_cast<double>(end - first)};
  }

 private:
  double of_one_ = 1, degrees_of_one_ = 0;
};

/// Returns the median power near each ordinate: over three blocks, which are longer at high frequency. At the lowest frequencies it uses equally many
/// ordinates on either side, because the median of a decreasing spectrum is then its value in the middle.
std::vector<Floor> floors(const SpectrumLevel& level) {
  const MedianFloor floor(level.transforms);
  std::vector<Floor> out(level.end);
  std::size_t k = std::max(level.first, lowest_ordinate);
  for (; k < std::min(level.end, 3 * shortest_block); ++k) {
    const std::size_t side = std::min({k - level.first, level.end - 1 - k, 3 * shortest_block / 2});
    out[k] = floor(level, k - side, k + side + 1);
  }
  for (std::size_t length; k < level.end; k += length) {
    length = std::clamp(k / 8, shortest_block, longest_block);
    const Floor about = floor(level, std::max(level.first, k - length), std::min(level.end, k + 2 * length));
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(k), out.begin() + static_cast<std::ptrdiff_t>(std::min(level.end, k + length)), about);
  }
  return out;
}

/// Returns the logarithmic frequency range of all levels together, because the probability of a false line is equal in each octave.
double log_range(const Spectrum& spectrum) {
  double sum = 0;
  for (const SpectrumLevel& level : spectrum.levels)
    if (const std::size_t first = std::max(level.first, lowest_ordinate); first < level.end)
      sum += std::log(static_cast<double>(level.end) / static_cast<double>(first));
  return sum;
}

std::optional<Peak> highest_peak(const Spectrum& spectrum, const std::vector<double>& known) {
  const double range = log_range(spectrum);
  double most = 0;
  std::optional<Peak> best;
  for (std::size_t l = 0; l < spectrum.levels.size(); ++l) {
    const SpectrumLevel& level = spectrum.levels[l];
    const std::vector<Floor> about = floors(level);
    const double scatter = std::sqrt(2 / level.transforms), resolved = level.hz(3);
    for (std::size_t k = std::max(level.first, lowest_ordinate); k < level.end; ++k) {
      const double hz = level.hz(static_cast<double>(k)), ratio = level.power[k] / about[k].noise;
      if (!(ratio > 1 + 4 * scatter) || (ratio - 1) / scatter <= most) continue;
      if (std::any_of(known.begin(), known.end(), [&](double f) { return std::abs(f - hz) < resolved; })) continue;
      if (f_tail(ratio, level.transforms, about[k].degrees) > chance / (range * static_cast<double>(k))) continue;
      most = (ratio - 1) / scatter;
      best = Peak{l, k, hz, about[k].noise};
    }
  }
  return best;
}

/// Returns the power above the noise near a peak.
double excess(const Spectrum& spectrum, const Peak& peak) {
  const SpectrumLevel& level = spectrum.levels[peak.level];
  double sum = 0;
  for (std::size_t k = peak.ordinate - std::min(peak.ordinate, around); k < std::min(level.end, peak.ordinate + around + 1); ++k)
    sum += level.power[k] / peak.noise - 1;
  return sum;
}

/// Returns the amplitude of the last removed sinusoid, from its mean square minus the contribution of noise.
NoiseCoefficient amplitude_of(const Spectrum& spectrum, const Peak& peak) {
  constexpr double coverage = 1.96;
  NoiseCoefficient c;
  c.value = std::sqrt(std::max(0.0, spectrum.squares / spectrum.pieces - 4 * peak.noise / spectrum.piece_s));
  c.standard_uncertainty = std::sqrt(2 * peak.noise / (spectrum.piece_s * spectrum.pieces));
  c.lower = std::max(0.0, c.value - coverage * c.standard_uncertainty), c.upper = c.value + coverage * c.standard_uncertainty;
  c.determined = c.lower > 0;
  return c;
}

}  // namespace

WithoutLines without_lines(std::span<const double> rate, double interval_s) {
  WithoutLines out{spectrum_of(rate, interval_s), {}};
  std::vector<double> taken;
  while (taken.size() < most_lines) {
    const std::optional<Peak> peak = highest_peak(out.spectrum, taken);
    if (!peak) break;
    const SpectrumLevel& level = out.spectrum.levels[peak->level];
    taken.push_back(sharpened(rate, interval_s, peak->hz, level.interval * static_cast<double>(level.power.size())));
    Spectrum less = spectrum_of(rate, interval_s, taken);
    if (!(excess(less, *peak) < left_at_most * excess(out.spectrum, *peak))) break;  // not a single frequency
    out.spectrum = std::move(less);
    out.lines.push_back({taken.back(), amplitude_of(out.spectrum, *peak)});
  }
  std::sort(out.lines.begin(), out.lines.end(), [](const NoiseLine& a, const NoiseLine& b) { return a.hz < b.hz; });
  return out;
}

}  // namespace imulab::noise
