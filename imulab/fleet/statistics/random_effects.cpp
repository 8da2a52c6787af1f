#include "imulab/fleet/statistics/random_effects.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

/// The restricted likelihood at a spread, in one pass in pieces that stay in the cache.
struct RestrictedFit {
  double w = 0, w2 = 0, w3 = 0, mean = 0, squares = 0, squares2 = 0, logs = 0;  // sums of w^k, of w^k (y - mean)^2, of ln(v + spread^2)
  double likelihood() const { return -0.5 * (logs + std::log(w) + squares); }
  double score() const { return -0.5 * (w - w2 / w - squares2); }
  double information() const { return 0.5 * (w2 - 2 * w3 / w + w2 * w2 / (w * w)); }
};

RestrictedFit fit_at(const Eigen::ArrayXd& y, const Eigen::ArrayXd& v, double center, double spread2, bool with_logs) {
  constexpr Eigen::Index piece = 512;
  RestrictedFit f;
  double wy = 0, wyy = 0, w2y = 0, w2yy = 0;
  Eigen::Array<double, Eigen::Dynamic, 1, 0, piece, 1> w, wz, z;
  for (Eigen::Index begin = 0; begin < y.size(); begin += piece) {
    const Eigen::Index n = std::min(piece, y.size() - begin);
    w = (v.segment(begin, n) + spread2).inverse();
    z = y.segment(begin, n) - center;  // the sums of squares lose no digits
    wz = w * z;
    f.w += w.sum(), f.w2 += w.square().sum(), f.w3 += w.cube().sum();
    wy += wz.sum(), wyy += (wz * z).sum(), w2y += (wz * w).sum(), w2yy += wz.square().sum();
    if (with_logs) f.logs -= w.log().sum();
  }
  const double m = wy / f.w;
  f.mean = center + m;
  f.squares = wyy - m * wy;
  f.squares2 = w2yy - 2 * m * w2y + m * m * f.w2;
  return f;
}

/// Fisher scoring from `start`.
double best_from(const Eigen::ArrayXd& y, const Eigen::ArrayXd& v, double center, double start) {
  double s = start;
  for (int k = 0; k < 200; ++k) {
    const RestrictedFit f = fit_at(y, v, center, s, false);
    const double next = std::max(0.0, s + f.score() / f.information());
    const double change = std::abs(next - s);
    s = next;
    if (change <= 1e-10 * (s + 1 / f.w)) break;
  }
  return s;
}

/// The spread^2 from `best` towards `end` at which the likelihood has fallen by `drop`: a root of r(u) = sqrt(2 fall) - sqrt(2 drop), which is nearly
/// linear in u = ln(spread^2 + floor), by regula falsi (Illinois).
double where_fallen(const Eigen::ArrayXd& y, const Eigen::ArrayXd& v, double center, double best, double top, double drop, double floor, bool up) {
  const auto r = [&](double u) {
    const double s = std::max(0.0, std::exp(u) - floor);
    return std::sqrt(2 * std::max(0.0, top - fit_at(y, v, center, s, true).likelihood())) - std::sqrt(2 * drop);
  };
  double a = std::log(best + floor), ra = -std::sqrt(2 * drop), b = a, rb = ra;
  if (up) {
    double step = std::max(0.05, 4 / std::sqrt(static_cast<double>(y.size())));
    while (rb < 0 && b - a < 200) b += step, rb = r(b), step *= 2;
    if (rb < 0) return std::numeric_limits<double>::infinity();
  } else {
    b = std::log(floor);
    if (b >= a || (rb = r(b)) <= 0) return 0;
  }
  for (int k = 0; k < 100 && std::abs(b - a) > 1e-7; ++k) {
    const double c = (a * rb - b * ra) / (rb - ra), rc = r(c);
    if (std::abs(rc) < 1e-6) return std::max(0.0, std::exp(c) - floor);
    if (rc < 0)
      a = c, ra = rc, rb *= k % 2 == 0 ? 1 : 0.5;
    else
      b = c, rb = rc, ra *= k % 2 == 0 ? 1 : 0.5;
  }
  return std::max(0.0, std::exp(0.5 * (a + b)) - floor);
}

}  // namespace

double random_spread2(const Eigen::ArrayXd& y, const Eigen::ArrayXd& v) {
  if (y.size() < 2) return 0;
  const double center = y.mean(), total = (y - center).square().sum() / (static_cast<double>(y.size()) - 1);
  return best_from(y, v, center, std::max(0.0, total - v.mean()));
}

RandomEffects random_effects(const Eigen::ArrayXd& y, const Eigen::ArrayXd& v, double confidence) {
  if (y.size() == 0) throw Error("no value; expected at least one unit");
  if (!(v > 0).all() || !v.isFinite().all() || !y.isFinite().all())
    throw Error("a value or a variance is not usable; expected numbers, variances above 0");
  const auto n = static_cast<double>(y.size());
  const double two_sided = 0.5 + 0.5 * confidence, center = y.mean();
  RandomEffects out{.units = y.size(), .mean = center, .measurement = std::sqrt(v.mean())};
  if (y.size() == 1) {
    out.mean_low = center - normal_quantile(two_sided) * out.measurement;
    out.mean_high = center + normal_quantile(two_sided) * out.measurement;
    out.spread_high = std::numeric_limits<double>::infinity();
    return out;
  }
  const double total = (y - center).square().sum() / (n - 1);
  double best = best_from(y, v, center, std::max(0.0, total - v.mean()));
  double top = fit_at(y, v, center, best, true).likelihood();
  if (y.size() < 1000)  // of few units with different uncertainties the likelihood may have two maxima
    for (const double part : {0.0, 1e-4, 1e-2, 0.1, 0.5, 1.0, 2.0}) {
      const double other = best_from(y, v, center, part * total), height = fit_at(y, v, center, other, true).likelihood();
      if (height > top) best = other, top = height;
    }
  const RestrictedFit f = fit_at(y, v, center, best, false);
  const double half = student_quantile(two_sided, n - 1) * std::sqrt(f.squares / ((n - 1) * f.w));
  const double drop = 0.5 * chi_square_quantile(confidence, 1), floor = std::max(1e-3 * v.mean(), 1e-12 * total);
  out.mean = f.mean, out.mean_low = f.mean - half, out.mean_high = f.mean + half;
  out.spread = std::sqrt(best);
  out.spread_low = best > 0 ? std::sqrt(where_fallen(y, v, center, best, top, drop, floor, false)) : 0;
  out.spread_high = std::sqrt(where_fallen(y, v, center, best, top, drop, floor, true));
  out.p_value = chi_square_tail(fit_at(y, v, center, 0, false).squares, n - 1);
  return out;
}

}  // namespace imulab
