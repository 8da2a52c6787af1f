// Cubic splines with two continuous derivatives through, or near, points of one to four coordinates.
#pragma once

#include "imulab/eigen.hpp"

#include <vector>

namespace imulab::motion {

template <int N>
class Spline {
 public:
  using Point = Eigen::Matrix<double, N, 1>;
  struct Value {
    Point value, first, second;
  };

  /// Interpolates points at four or more ascending knots (Error for fewer), with a continuous third derivative next to the ends (not-a-knot).
  Spline(std::vector<double> knots, std::vector<Point> points);

  /// Returns the smoothest spline (least integral of the squared second derivative) with a mean square distance `mean_square` from the points, over
  /// all coordinates (Reinsch 1967). Smoothing is limited to about 3000 knots for well-conditioned equations; with fewer knots, the limit is a
  /// straight line.
  static Spline smoothing(std::vector<double> knots, const std::vector<Point>& points, double mean_square);

  Value at(double t) const;
  const std::vector<double>& knots() const { return knots_; }

 private:
  Spline() = default;

  std::vector<double> knots_;
  std::vector<Point> values_, curvatures_;  // second derivatives at the knots
};

}  // namespace imulab::motion
