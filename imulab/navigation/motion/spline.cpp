#include "imulab/navigation/motion/spline.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::motion {
namespace {

void check(const std::vector<double>& knots, std::size_t points) {
  if (knots.size() < 4 || points != knots.size()) throw Error("spline: expected four or more knots and a point for each");
  for (std::size_t i = 0; i + 1 < knots.size(); ++i)
    if (!(knots[i] < knots[i + 1])) throw Error("spline: expected ascending knots");
}

/// Returns the changes of slope at the inner knots: Q'y.
template <class Point>
std::vector<Point> slope_changes(const std::vector<double>& t, const std::vector<Point>& y) {
  std::vector<Point> out(t.size() - 2);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (y[i + 2] - y[i + 1]) / (t[i + 2] - t[i + 1]) - (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
  return out;
}

/// Row i of Q, the transpose of slope_changes: columns i - 2, i - 1, i.
struct SlopeRow {
  double below, middle, above;
};

/// A symmetric positive pentadiagonal matrix, and its solution by L D L'.
struct FiveDiagonals {
  std::vector<double> diagonal, first, second;  // (i, i), (i, i + 1), (i, i + 2)

  explicit FiveDiagonals(std::size_t n) : diagonal(n), first(n), second(n) {}

  template <class Point>
  std::vector<Point> solve(std::vector<Point> x) {
    const std::size_t n = diagonal.size();
    for (std::size_t i = 0; i < n; ++i) {  // factors replace the matrix, with forward substitution
      const double a = first[i], b = second[i], d = diagonal[i];
      if (i + 1 < n) {
        first[i] = a / d;
        diagonal[i + 1] -= a * first[i];
        x[i + 1] -= first[i] * x[i];
      }
      if (i + 2 < n) {
        second[i] = b / d;
        diagonal[i + 2] -= b * second[i];
        first[i + 1] -= b * first[i];
        x[i + 2] -= second[i] * x[i];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      x[i] /= diagonal[i];
      if (i + 1 < n) x[i] -= first[i] * x[i + 1];
      if (i + 2 < n) x[i] -= second[i] * x[i + 2];
    }
    return x;
  }
};

template <class Point>
struct Smoothed {
  std::vector<Point> values, curvatures;
  double mean_square = 0;  // mean square of the removed part
};

/// Smooths by Reinsch: (R + a Q'Q) c = Q'y, values y - a Q c, natural ends.
template <class Point>
Smoothed<Point> smoothed(const std::vector<double>& t, const std::vector<Point>& y, double a) {
  const std::size_t n = t.size(), m = n - 2;
  const auto h = [&](std::size_t i) { return t[i + 1] - t[i]; };
  const auto q = [&](std::size_t j) { return SlopeRow{1 / h(j), -1 / h(j) - 1 / h(j + 1), 1 / h(j + 1)}; };  // column j of Q: rows j, j + 1, j + 2
  FiveDiagonals A(m);
  for (std::size_t j = 0; j < m; ++j) {
    const SlopeRow u = q(j);
    A.diagonal[j] = (h(j) + h(j + 1)) / 3 + a * (u.below * u.below + u.middle * u.middle + u.above * u.above);
    if (j + 1 < m) A.first[j] = h(j + 1) / 6 + a * (u.middle * q(j + 1).below + u.above * q(j + 1).middle);
    if (j + 2 < m) A.second[j] = a * u.above * q(j + 2).below;
  }
  const std::vector<Point> c = A.solve(slope_changes(t, y));
  Smoothed<Point> out{y, std::vector<Point>(n, Point::Zero())};
  for (std::size_t j = 0; j < m; ++j) {
    const SlopeRow u = q(j);
    out.values[j] -= a * u.below * c[j];
    out.values[j + 1] -= a * u.middle * c[j];
    out.values[j + 2] -= a * u.above * c[j];
    out.curvatures[j + 1] = c[j];
  }
  for (std::size_t i = 0; i < n; ++i) out.mean_square += (out.values[i] - y[i]).squaredNorm() / static_cast<double>(n);
  return out;
}

}  // namespace

template <int N>
Spline<N>::Spline(std::vector<double> knots, std::vector<Point> points) : knots_(std::move(knots)), values_(std::move(points)) {
  check(knots_, values_.size());
  const std::size_t n = knots_.size(), m = n - 2;
  const auto h = [&](std::size_t i) { return knots_[i + 1] - knots_[i]; };
  std::vector<Point> c = slope_changes(knots_, values_);
  std::vector<double> below(m), diagonal(m), above(m);
  for (std::size_t j = 0; j < m; ++j) below[j] = h(j) / 6, diagonal[j] = (h(j) + h(j + 1)) / 3, above[j] = h(j + 1) / 6;
  // The curvature at an end lies on the line through its two neighbors.
  const double p = h(0) / h(1), q = h(n - 2) / h(n - 3);
  diagonal[0] += below[0] * (1 + p);
  above[0] -= below[0] * p;
  diagonal[m - 1] += above[m - 1] * (1 + q);
  below[m - 1] -= above[m - 1] * q;
  for (std::size_t j = 1; j < m; ++j) {
    const double f = below[j] / diagonal[j - 1];
    diagonal[j] -= f * above[j - 1];
    c[j] -= f * c[j - 1];
  }
  for (std::size_t j = m; j-- > 0;) c[j] = (j + 1 < m ? Point(c[j] - above[j] * c[j + 1]) : c[j]) / diagonal[j];
  curvatures_.push_back(c[0] + p * (c[0] - c[1]));
  curvatures_.insert(curvatures_.end(), c.begin(), c.end());
  curvatures_.push_back(c[m - 1] + q * (c[m - 1] - c[m - 2]));
}

template <int N>
Spline<N> Spline<N>::smoothing(std::vector<double> knots, const std::vector<Point>& points, double mean_square) {
  check(knots, points.size());
  const double h = (knots.back() - knots.front()) / static_cast<double>(knots.size() - 1);
  double low = std::log(1e-9 * h * h * h), high = std::log(1e14 * h * h * h);  // limits of ln a; the removed part grows with a
  Smoothed<Point> best = smoothed(knots, points, std::exp(high));
  for (int i = 0; i < 60 && std::abs(best.mean_square - mean_square) > 1e-6 * mean_square && (i > 0 || best.mean_square > mean_square); ++i) {
    const double middle = (low + high) / 2;
    best = smoothed(knots, points, std::exp(middle));
    (best.mean_square > mean_square ? high : low) = middle;
  }
  Spline out;
  out.knots_ = std::move(knots);
  out.values_ = std::move(best.values);
  out.curvatures_ = std::move(best.curvatures);
  return out;
}

template <int N>
auto Spline<N>::at(double t) const -> Value {
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
  const auto i = static_cast<std::size_t>(after - knots_.begin()) - 1;
  const double h = knots_[i + 1] - knots_[i], x = (t - knots_[i]) / h, y = 1 - x;
  const Point &c0 = curvatures_[i], &c1 = curvatures_[i + 1];
  return {y * values_[i] + x * values_[i + 1] + h * h / 6 * ((y * y * y - y) * c0 + (x * x * x - x) * c1),
          (values_[i + 1] - values_[i]) / h + h / 6 * ((1 - 3 * y * y) * c0 + (3 * x * x - 1) * c1), y * c0 + x * c1};
}

template class Spline<1>;
template class Spline<3>;
template class Spline<4>;

}  // namespace imulab::motion
