// Pictures that are not curves: values with their intervals, shares, correlations, directions on a sphere.
#pragma once

#include "imulab/eigen.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::report {

/// A value with what it may be off by, on both sides; a row of its own.
struct Interval {
  std::string name;
  double value = 0, half_width = 0;
  std::string text = {};  ///< beside the row
  bool marked = false;    ///< in another color
};
/// Rows on one axis with a line at zero, and a dashed one at the limit if there is one.
std::string interval_rows(const std::vector<Interval>& rows, std::string_view unit, std::string_view description, std::optional<double> limit = {});

/// A part of a bar: its color (that of the series), its share of one, and its name.
struct SharePart {
  std::size_t color = 0;
  double share = 0;
  std::string name;
};
/// One bar of parts that add up to one; a negative part is drawn to the left of zero.
struct ShareRow {
  std::string name, value, largest;  ///< the largest part in words
  std::vector<SharePart> parts;
};
std::string share_bars(const std::vector<ShareRow>& rows, std::string_view description);

/// Correlations as a square of colors: orange negative, blue positive, white none.
std::string correlation_map(const std::vector<std::string>& names, const Eigen::MatrixXd& correlation, std::string_view description);

/// A direction in the body: a dot, or a cross where it is missing.
struct SphereMark {
  Vector3d direction;
  bool gap = false;
};
/// Both halves of the sphere, seen along -z and +z (equal-area), with the body's axes.
std::string sphere(const std::vector<SphereMark>& marks, std::string_view description);

/// Right-handed axes with the sense of a positive rate.
std::string axes_sketch();

}  // namespace imulab::report
