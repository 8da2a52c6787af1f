#include "imulab/estimate/hybrid/start.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/kernel/coarse.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using namespace kernel;

namespace {

/// Coarse gyros: from the Earth's rate at rest where the rests allow it, else the declared unit or, for counts, the motion of gravity; offset from
/// the rests.
void start_gyro(RestStart& start, const Recording& recording, double latitude) {
  TriadModel& gyro = start.model.gyro;
  std::vector<Vector3d> readings, up;
  for (const RestMeans& rest : start.rests) readings.push_back(start.gyro(rest)), up.push_back(start.up(rest));
  const bool counts = recording.gyro_unit == "count";
  const auto at_rest = coarse_gyro_at_rest(readings, up, earth_rate * std::sin(latitude));
  if (at_rest && !counts && (at_rest->matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.05) {
    gyro.matrix = at_rest->matrix;
    gyro.offset = at_rest->offset;
    start.findings.note("gyros started from the Earth's rate at rest");
    return;
  }
  if (counts) {
    const auto in_motion = coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
    if (!in_motion)
      throw Unsupported(recording.name +
                        ": gyro: the motion does not turn the unit about all its axes; readings in counts need that for their scale");
    gyro.matrix = *in_motion;
  }
  const Vector3d mean = gyro.matrix * start.scaling.gyro(mean_gyro(start.rests));
  if (mean.norm() > 2 * earth_rate) gyro.offset = -mean;  // a smaller mean is largely the Earth's rate
  start.findings.note(counts ? "gyros started from the motion of gravity between the rests" : "gyros started from the declared unit");
}

/// Axes that are swapped, reversed or left-handed, in words; empty where the gyros turn as gravity does.
std::string wrong_axes(const Matrix3d& gyro) {
  const Matrix3d m = gyro / std::cbrt(std::abs(gyro.determinant()));
  std::array<Index, 3> source;
  for (Index r = 0; r < 3; ++r) {
    m.row(r).cwiseAbs().maxCoeff(&source[static_cast<std::size_t>(r)]);
    if (std::abs(m(r, source[static_cast<std::size_t>(r)])) < 0.7) return {};  // mounted at an angle: undecided
  }
  if (source[0] == source[1] || source[0] == source[2] || source[1] == source[2]) return {};
  std::string swapped, reversed;
  int negative = 0;
  for (Index r = 0; r < 3; ++r) {
    const Index from = source[static_cast<std::size_t>(r)];
    if (from != r) swapped += fmt::format("{}{} reads about {}", swapped.empty() ? "" : ", ", "xyz"[from], "xyz"[r]);
    if (m(r, from) > 0) continue;
    ++negative;
    reversed += fmt::format("{}{}", reversed.empty() ? "" : " and ", "xyz"[from]);
  }
  if (swapped.empty() && negative == 0) return {};
  if (!swapped.empty()) return "the gyros' axes are not those of the accelerometers: gyro " + swapped + (negative ? "; reversed: " + reversed : "");
  if (negative == 3) return "the triads are left-handed: both have one axis reversed (or all three gyros are)";
  if (negative == 1) return "gyro " + reversed + " has the wrong sign";
  for (Index r = 0; r < 3; ++r)
    if (m(r, r) > 0) return fmt::format("accelerometer {} (or the gyros {}) has the wrong sign", "xyz"[r], reversed);
  return {};
}

void check_axes(const Recording& recording, const RestStart& start) {
  const auto in_motion = coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty())
    throw Error(recording.name + ": " + wrong + ", as gravity turns in the unit; expected right-handed axes, the same for both triads");
}

/// Standard deviation of one axis's samples in the median second of the rests, so that disturbances of some do not count.
double quiet_noise(const std::vector<double>& readings, const std::vector<RestMeans>& rests, std::size_t second) {
  std::vector<double> variances;
  for (const RestMeans& rest : rests)
    for (std::size_t begin = rest.range.begin; begin + second <= rest.range.end; begin += second) {
      double mean = 0, squares = 0;
      for (std::size_t i = begin; i < begin + second; ++i) mean += readings[i] / static_cast<double>(second);
      for (std::size_t i = begin; i < begin + second; ++i) squares += (readings[i] - mean) * (readings[i] - mean);
      variances.push_back(squares / static_cast<double>(second - 1));
    }
  if (variances.empty()) return std::numeric_limits<double>::infinity();
  const double of_median = std::pow(1 - 2 / (9 * static_cast<double>(second - 1)), 3);  // a chi-square's over its mean (Wilson and Hilferty)
  return std::sqrt(median(std::move(variances)) / of_median);
}

void use_quiet_noise(RestStart& start, const Recording& recording, const ImuDeclaration& imu) {
  const std::size_t second = std::max<std::size_t>(5, static_cast<std::size_t>(std::lround(1 / recording.interval_s)));
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<Index>(j);
    if (!imu.accel_noise_density) start.noise.accel[axis] = std::min(start.noise.accel[axis], quiet_noise(recording.accel[j], start.rests, second));
    start.noise.gyro[axis] = std::min(start.noise.gyro[axis], quiet_noise(recording.gyro[j], start.rests, second));
  }
  limit_noise(start);
}

}  // namespace

RestStart coarse_start(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double latitude, double gravity) {
  RestStart start = start_from_rests(recording, rests, imu, gravity);
  use_quiet_noise(start, recording, imu);
  start_gyro(start, recording, latitude);
  use_declared_gyro_noise(start, recording, imu);
  check_axes(recording, start);
  return start;
}

}  // namespace imulab::hybrid
