#include "imulab/estimate/turntable/slow_noise.hpp"

#include "imulab/model/flicker.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// A part is the mean of this many equal cells, each of which is taken as its middle for what happens between cells.
constexpr Index cells = 8;

}  // namespace

MatrixXd slow_noise(const TableMotion& motion, const NoiseModel& noise, double interval_s) {
  if (noise.B == 0 && noise.K == 0 && noise.R.value == 0) return {};
  const FlickerCovariance flicker(noise.B, interval_s);
  const auto parts = static_cast<Index>(motion.parts());
  double start = motion.parts() > 0 ? motion.begin(0) : 0;
  for (std::size_t k = 0; k < motion.parts(); ++k) start = std::min(start, motion.begin(k));
  const auto cell = [&](Index part) {
    const auto k = static_cast<std::size_t>(part);
    return (motion.end(k) - motion.begin(k)) / cells;
  };
  const auto time = [&](Index part, Index c) {
    return motion.begin(static_cast<std::size_t>(part)) - start + (static_cast<double>(c) + 0.5) * cell(part);
  };
  MatrixXd out(parts, parts);
  for (Index a = 0; a < parts; ++a)
    for (Index b = 0; b <= a; ++b) {
      double sum = 0;
      for (Index i = 0; i < cells; ++i)
        for (Index j = 0; j < cells; ++j) {
          const double s = time(a, i), t = time(b, j);
          sum += (a == b && i == j ? flicker.of_mean(cell(a)) : flicker.between(std::abs(s - t))) + noise.K * noise.K * std::min(s, t) +
                 noise.R.value * noise.R.value * s * t;
        }
      const double gains = motion.gain(static_cast<std::size_t>(a)) * motion.gain(static_cast<std::size_t>(b));
      out(a, b) = out(b, a) = gains * sum / (cells * cells);
    }
  return out;
}

}  // namespace imulab::turntable
