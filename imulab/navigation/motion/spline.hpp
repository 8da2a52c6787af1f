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

  /// Through the points at ascending knots, four or more, the third derivative continuous at the second and the last but one (not-a-knot ends).
  /// Throws Error for fewer.
  Spline(std::vector<double> knots, std::vector<Point> points);

  /// The smoothest (least integral of the squared second derivative) whose mean square distance from the points, all coordinates together, is
  /// `mean_square` (Reinsch 1967). No smoother than over some 3000 knots, which leaves the equations well conditioned: of fewer, a straight line.
  static Spline smoothing(std::vector<double> knots, const std::vector<Point>& points, double mean_square);

  Value at(double t) const;
  const std::vector<double>& knots() const { return knots_; }

 private:
  Spline() = default;

  std::vector<double> knots_;
  std::vector<Point> values_, curvatures_;  // second derivatives at the knots
};

}  // namespace imulab::motion
