#include "imulab/noise/likelihood.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/noise/spectral_terms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace imulab::noise {

namespace {

using Eigen::ArrayXd, Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double largest_step = 3;  // largest change of a logarithm
/// A process faster than two samples is white; one slower than a tenth of the record is a random walk.
constexpr double fewest_intervals = 2, fewest_times = 10;

}  // namespace

SpectrumLikelihood::SpectrumLikelihood(const Spectrum& spectrum, double highest_hz, double resolution, const Terms& terms)
    : terms_(terms), resolution_(resolution), longest_time_(spectrum.record_s / fewest_times) {
  std::vector<SpectrumBin> used;
  for (const SpectrumBin& bin : spectrum.bins)
    if (bin.high_hz() <= highest_hz) used.push_back(bin);
  set_bins(std::move(used));
  if (!bins_.empty()) Q_scale_ = (power_ / unit_.col(Terms::Q)).minCoeff();
}

void SpectrumLikelihood::set_bins(std::vector<SpectrumBin> bins) {
  bins_ = std::move(bins);
  const auto size = static_cast<Index>(bins_.size());
  unit_.resize(size, 4), counts_.resize(size), power_.resize(size), cosine_.resize(size);
  for (Index i = 0; i < size; ++i) {
    const SpectrumBin& bin = bins_[static_cast<std::size_t>(i)];
    const Densities d = unit_densities(bin);
    unit_.row(i) << d.Q, 1, d.B, d.K;
    counts_[i] = bin.count, power_[i] = bin.power, cosine_[i] = cosine_over_interval(bin);
    rounding_ = resolution_ * resolution_ / 12 * bin.interval / static_cast<double>(bin.averaged);
    shortest_interval_ = std::min(shortest_interval_, bin.interval);
  }
  filter_ = FilterShares(bins_, terms_.low_pass);
}

SpectrumLikelihood SpectrumLikelihood::at(const std::vector<double>& hz) const {
  constexpr std::size_t length = std::size_t{1} << 26;  // fine enough for frequencies of a day
  std::vector<SpectrumBin> bins;
  for (const double f : hz) {
    const double interval = bins_.front().interval / static_cast<double>(bins_.front().averaged);
    const auto k = static_cast<std::size_t>(std::clamp(std::round(2 * f * interval * length), 1.0, length - 1.0));
    bins.push_back({.interval = interval, .length = length, .first = k, .last = k});
  }
  SpectrumLikelihood out;
  out.terms_ = terms_, out.Q_scale_ = Q_scale_, out.resolution_ = resolution_, out.longest_time_ = longest_time_;
  out.set_bins(std::move(bins));
  return out;
}

SpectrumLikelihood SpectrumLikelihood::with(const Terms& terms) const {
  SpectrumLikelihood other = *this;
  other.terms_ = terms;
  if (terms.low_pass != terms_.low_pass) other.filter_ = FilterShares(bins_, terms.low_pass);
  return other;
}

Modeled SpectrumLikelihood::modeled(const Parameters& at) const {
  Modeled out;
  ArrayXd& S = out.density = unit_.rightCols<3>().matrix() * at.segment(Terms::N, 3).exp().matrix();
  const double white = std::exp(at[Terms::N]);
  for (int m = 0; m < terms_.markov; ++m)
    if (const double power = std::exp(at[Terms::sigma(m)]); power > 0) {
      MarkovDensity process(std::exp(at[Terms::time(m)]));
      for (Index i = 0; i < S.size(); ++i) S[i] += power * process.at(bins_[static_cast<std::size_t>(i)].interval, cosine_[i]);
    }
  if (terms_.low_pass.order > 0) {
    out.filter = filter_.at(std::exp(at[terms_.cutoff()]));
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      double& density = S[static_cast<Index>(i)];
      density = (density - white) * out.filter.red[i].share + white * out.filter.white[i].share;
    }
  }
  S = S + at[Terms::Q] * Q_scale_ * unit_.col(Terms::Q) + rounding_;
  return out;
}

MatrixXd SpectrumLikelihood::sensitivity(const Parameters& at, const Modeled& modeled) const {
  const auto& [density, shares] = modeled;
  MatrixXd D(density.size(), terms_.count());
  const double white = std::exp(at[Terms::N]), flicker = std::exp(at[Terms::B]), walk = std::exp(at[Terms::K]);
  const bool filtered = terms_.low_pass.order > 0;
  constexpr double step = 1e-3;  // change of the logarithm of a correlation time
  std::vector<std::array<MarkovDensity, 3>> processes;
  for (int m = 0; m < terms_.markov; ++m) {
    const double time = std::exp(at[Terms::time(m)]);
    processes.push_back({MarkovDensity(time), MarkovDensity(time * (1 + step)), MarkovDensity(time * (1 - step))});
  }
  for (Index i = 0; i < density.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Passed of_red = filtered ? shares.red[k] : Passed{}, of_white = filtered ? shares.white[k] : Passed{};
    double red = flicker * unit_(i, Terms::B) + walk * unit_(i, Terms::K);
    D(i, Terms::Q) = Q_scale_ * unit_(i, Terms::Q);
    D(i, Terms::N) = white * of_white.share;
    D(i, Terms::B) = flicker * unit_(i, Terms::B) * of_red.share;
    D(i, Terms::K) = walk * unit_(i, Terms::K) * of_red.share;
    for (int m = 0; m < terms_.markov; ++m) {
      const double power = std::exp(at[Terms::sigma(m)]);
      auto& [process, longer, shorter] = processes[static_cast<std::size_t>(m)];
      const double T = bins_[k].interval, value = process.at(T, cosine_[i]);
      D(i, Terms::sigma(m)) = power * value * of_red.share;
      D(i, Terms::time(m)) = power * (longer.at(T, cosine_[i]) - shorter.at(T, cosine_[i])) / (2 * step) * of_red.share;
      red += power * value;
    }
    if (filtered) D(i, terms_.cutoff()) = white * of_white.by_log_cutoff + red * of_red.by_log_cutoff;
  }
  if (!terms_.has[Terms::Q]) D.col(Terms::Q).setZero();
  D.array().colwise() /= density;
  return D;
}

ArrayXd SpectrumLikelihood::ramp_information(const ArrayXd& density) const {
  ArrayXd information(density.size());
  for (Index i = 0; i < density.size(); ++i) information[i] = std::pow(bins_[static_cast<std::size_t>(i)].ramp, 2) / density[i];
  return information;
}

double SpectrumLikelihood::without_quantization(double density, const Parameters& at, Index bin) const {
  return density - at[Terms::Q] * Q_scale_ * unit_(bin, Terms::Q);
}

ArrayXd SpectrumLikelihood::power(double ramp) const {
  ArrayXd power = power_;
  for (std::size_t i = 0; i < bins_.size() && bins_[i].ramp != 0; ++i)
    power[static_cast<Index>(i)] = std::pow(bins_[i].amplitude - ramp * bins_[i].ramp, 2);
  return power;
}

/// Sets ramp and misfit of a point and returns the model there, or nothing if it is impossible. A fitted ramp absorbs power of the lowest ordinates,
/// for which the restricted likelihood allows.
Modeled SpectrumLikelihood::judge(Point& point, const Fixed& fixed, const Pull& pull) const {
  point.misfit = std::numeric_limits<double>::infinity();
  if (!possible(point.at)) return {};
  Modeled at_point = modeled(point.at);
  const ArrayXd& S = at_point.density;
  if (!(S.minCoeff() > 0)) return at_point;
  double sum = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) sum += bins_[i].ramp * bins_[i].amplitude / S[static_cast<Index>(i)];
  const double information = ramp_information(S).sum();
  point.ramp = fixed.ramp ? *fixed.ramp : sum / information;
  point.misfit = (counts_ * (S.log() + power(point.ramp) / S)).sum();
  if (!fixed.ramp) point.misfit += std::log(information);
  if (pull.weight > 0) point.misfit -= pull.weight * std::log(without_quantization(S[pull.bin], point.at, pull.bin));
  return at_point;
}

/// Returns true if correlation times and cutoff are distinguishable from the other terms.
bool SpectrumLikelihood::possible(const Parameters& at) const {
  for (int m = 0; m < terms_.markov; ++m)
    if (at[Terms::time(m)] < std::log(fewest_intervals * shortest_interval_) || at[Terms::time(m)] > std::log(longest_time_)) return false;
  return terms_.low_pass.order == 0 || at[terms_.cutoff()] <= std::log((terms_.low_pass.digital ? 0.49 : 1.0) / shortest_interval_);
}

Point SpectrumLikelihood::start(double below_hz) const {
  Point start;
  start.at = Parameters::Constant(terms_.count(), absent);
  start.at[Terms::Q] = 0;
  const ArrayXd ones = ArrayXd::Ones(counts_.size());
  double sum = 0;
  for (const SpectrumBin& bin : bins_) sum += bin.ramp * bin.amplitude;
  const ArrayXd P = power(sum / ramp_information(ones).sum());
  for (int j = 0; j < 4; ++j) {
    if (!terms_.has[static_cast<std::size_t>(j)]) continue;
    std::vector<double> ratios;
    for (Index i = 0; i < P.size(); ++i)
      if (counts_[i] >= 3 && bins_[static_cast<std::size_t>(i)].middle_hz() < below_hz) ratios.push_back(P[i] / unit_(i, j));
    if (ratios.empty()) ratios.push_back(P.mean() / unit_.col(j).mean());
    const double size = std::max(quantile(ratios, 0.05), 1e-290);
    start.at[j] = j == Terms::Q ? size / Q_scale_ : std::log(size);
  }
  return start;
}

Point SpectrumLikelihood::revived(Point point) const {
  const ArrayXd S = density(point.at);
  for (const int j : {Terms::N, Terms::B, Terms::K})
    if (terms_.has[static_cast<std::size_t>(j)]) point.at[j] = std::max(point.at[j], std::log(1e-3 / (unit_.col(j) / S).maxCoeff()));
  return point;
}

Point SpectrumLikelihood::fitted(Point point, const Fixed& fixed, double precision, int iterations, const Pull& pull) const {
  Modeled now = judge(point, fixed, pull);
  if (now.density.size() == 0) now = modeled(point.at);
  double damping = 1e-3;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const ArrayXd& S = now.density;
    MatrixXd D = sensitivity(point.at, now);
    for (const int parameter : {fixed.parameter, fixed.second})
      if (parameter >= 0) D.col(parameter).setZero();
    VectorXd gradient = D.transpose() * (counts_ * (1 - power(point.ramp) / S)).matrix();
    if (!fixed.ramp) {
      const ArrayXd ramp = ramp_information(S);
      gradient -= D.transpose() * (ramp / ramp.sum()).matrix();
    }
    if (pull.weight > 0) {
      const double share = S[pull.bin] / without_quantization(S[pull.bin], point.at, pull.bin);
      const double of_Q = gradient[Terms::Q];
      gradient -= pull.weight * share * D.row(pull.bin).transpose();
      gradient[Terms::Q] = of_Q;
    }
    const MatrixXd information = D.transpose() * counts_.matrix().asDiagonal() * D;
    Point next;
    Modeled then;
    bool better = false;
    for (; !better && damping < 1e12; damping *= 10) {
      MatrixXd damped = information;
      damped.diagonal() += damping * (information.diagonal().array() + 1e-9).matrix();
      const ArrayXd step = solve_semidefinite(damped, gradient).array();
      next = point;
      next.at[Terms::Q] -= step[Terms::Q];
      next.at.tail(next.at.size() - 1) -= step.tail(step.size() - 1).max(-largest_step).min(largest_step);
      next.at = next.at.max(absent).min(700.0);
      then = judge(next, fixed, pull);
      better = std::isfinite(next.misfit) && next.misfit <= point.misfit;
    }
    if (!better) return point;
    const double gain = point.misfit - next.misfit;
    point = next, now = std::move(then);
    const bool full_step = damping < 1e-1;  // a damped step gains little anywhere
    damping = std::max(1e-9, damping * 1e-2);
    if (gain < precision && full_step) return point;
  }
  return point;
}

}  // namespace imulab::noise
