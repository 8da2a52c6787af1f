#include "imulab/model/triad_axes.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <array>
#include <cmath>

namespace imulab {

std::string wrong_axes(const Matrix3d& gyro) {
  const Matrix3d m = gyro / std::cbrt(std::abs(gyro.determinant()));
  std::array<Eigen::Index, 3> source;
  for (Eigen::Index r = 0; r < 3; ++r) {
    m.row(r).cwiseAbs().maxCoeff(&source[static_cast<std::size_t>(r)]);
    if (std::abs(m(r, source[static_cast<std::size_t>(r)])) < 0.7) return {};  // mounted at an angle: undecided
  }
  if (source[0] == source[1] || source[0] == source[2] || source[1] == source[2]) return {};
  std::string swapped, reversed;
  int negative = 0;
  for (Eigen::Index r = 0; r < 3; ++r) {
    const Eigen::Index from = source[static_cast<std::size_t>(r)];
    if (from != r) swapped += fmt::format("{}{} reads about {}", swapped.empty() ? "" : ", ", "xyz"[from], "xyz"[r]);
    if (m(r, from) > 0) continue;
    ++negative;
    reversed += fmt::format("{}{}", reversed.empty() ? "" : " and ", "xyz"[from]);
  }
  if (swapped.empty() && negative == 0) return {};
  if (!swapped.empty()) return "the gyros' axes are not those of the accelerometers: gyro " + swapped + (negative ? "; reversed: " + reversed : "");
  if (negative == 3) return "the triads are left-handed: both have one axis reversed (or all three gyros are)";
  if (negative == 1) return "gyro " + reversed + " has the wrong sign";
  for (Eigen::Index r = 0; r < 3; ++r)
    if (m(r, r) > 0) return fmt::format("accelerometer {} (or the gyros {}) has the wrong sign", "xyz"[r], reversed);
  return {};
}

}  // namespace imulab
