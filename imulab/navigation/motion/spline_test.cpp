#include "imulab/navigation/motion/spline.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab::motion {
namespace {

using Curve = Spline<1>;
using Point = Curve::Point;

TEST(Spline, ACubicIsItsOwnSpline) {
  const auto cubic = [](double t) { return 1 + t * (2 + t * (-3 + 0.5 * t)); };
  const std::vector<double> knots{0, 0.3, 1, 1.2, 2.5, 4};
  std::vector<Point> points;
  for (const double t : knots) points.emplace_back(cubic(t));
  const Curve spline(knots, points);
  for (double t = 0; t <= 4; t += 0.1) {
    const auto v = spline.at(t);
    EXPECT_NEAR(v.value(0), cubic(t), 1e-13);  // rounding
    EXPECT_NEAR(v.first(0), 2 - 6 * t + 1.5 * t * t, 1e-12);
    EXPECT_NEAR(v.second(0), -6 + 3 * t, 1e-12);
  }
}

TEST(Spline, ItsErrorsAreWithinThoseOfTheory) {
  // Hall and Meyer 1976: 5/384 h^4, 1/24 h^3, 3/8 h^2 times the fourth derivative, ten knots away from the ends, where the effect of the end
  // conditions has decayed (by 0.27 per knot).
  const double h = 0.05;
  std::vector<double> knots;
  std::vector<Point> points;
  for (int i = 0; i <= 100; ++i) knots.push_back(i * h), points.emplace_back(std::sin(knots.back()));
  const Curve spline(knots, points);
  double value = 0, first = 0, second = 0;
  for (double t = 0.5; t <= 4.5; t += 0.0037) {
    const auto v = spline.at(t);
    value = std::max(value, std::abs(v.value(0) - std::sin(t)));
    first = std::max(first, std::abs(v.first(0) - std::cos(t)));
    second = std::max(second, std::abs(v.second(0) + std::sin(t)));
  }
  EXPECT_LT(value, 5. / 384 * std::pow(h, 4));
  EXPECT_LT(first, 1. / 24 * std::pow(h, 3));
  EXPECT_LT(second, 3. / 8 * h * h);
  EXPECT_NEAR(second, h * h / 12, 0.1 * h * h / 12);  // at equally spaced knots; 10 % because the tested instants miss them
}

TEST(Spline, SmoothingTakesOffWhatItIsTold) {
  const RandomStream random(1, 2);
  std::vector<double> knots;
  std::vector<Point> points;
  double t = 0;
  for (std::uint64_t i = 0; i < 400; ++i, t += i % 3 == 0 ? 0.02 : 0.05) {
    knots.push_back(t);
    points.emplace_back(std::sin(t) + 0.1 * random.normal(i));
  }
  const Curve spline = Curve::smoothing(knots, points, 0.01);
  double residual = 0, error = 0;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    residual += std::pow(spline.at(knots[i]).value(0) - points[i](0), 2) / 400;
    error += std::pow(spline.at(knots[i]).value(0) - std::sin(knots[i]), 2) / 400;
  }
  EXPECT_NEAR(residual, 0.01, 1e-7);  // tolerance of the search
  // The square of the noise scatters by sqrt(2/400), as much as 28 parameters remove: 0.1 sqrt(28/400) = 0.026; the curve's own parameters and bias
  // add about as much again.
  EXPECT_LT(std::sqrt(error), 0.1 / 2);
  for (const std::size_t i : {7, 200}) {  // two derivatives are continuous; 1e-6: the third over 2e-9 s
    const auto a = spline.at(knots[i] - 1e-9), b = spline.at(knots[i] + 1e-9);
    EXPECT_NEAR(a.first(0), b.first(0), 1e-6);
    EXPECT_NEAR(a.second(0), b.second(0), 1e-6);
  }
}

TEST(Spline, SmoothingOfAStraightLineIsThatLine) {
  std::vector<double> knots;
  std::vector<Point> points;
  for (int i = 0; i < 50; ++i) knots.push_back(i), points.emplace_back(3 - 2. * i);
  const Curve spline = Curve::smoothing(knots, points, 1);
  EXPECT_NEAR(spline.at(24.5).value(0), 3 - 49, 1e-9);  // rounding
  EXPECT_NEAR(spline.at(24.5).second(0), 0, 1e-9);
}

TEST(Spline, RefusesFewAndUnorderedKnots) {
  const std::vector<Point> four(4, Point(1.));
  EXPECT_THROW(Curve({0, 1, 2}, {four[0], four[0], four[0]}), Error);
  EXPECT_THROW(Curve({0, 1, 1, 2}, four), Error);
  EXPECT_THROW(Curve({0, 1, std::nan(""), 2}, four), Error);
  EXPECT_THROW(Curve::smoothing({0, 1, 2, 3, 4}, four, 1), Error);
}

}  // namespace
}  // namespace imulab::motion
