#include "imulab/estimate/kernel/common_turns.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/coarse.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

namespace {

/// How much of gravity's turning in the IMU from rest to rest the gyros explain: 1 all, 0 as little as gyros that read nothing. Turns of less than
/// 10 deg, with a gap or with saturated samples do not count; empty where fewer than three others are. `gyro`: the matrix of scaled readings.
std::optional<double> explained_turning(const Recording& recording, const RestStart& start, const Matrix3d& gyro) {
  constexpr std::size_t fewest = 3;
  constexpr double least_turn = 10 * unit::deg;
  const Vector3d at_rest = start.scaling.gyro(mean_gyro(start.rests));
  std::size_t turns = 0;
  double turned = 0, missed = 0;  // squares
  for (std::size_t k = 0; k + 1 < start.rests.size(); ++k) {
    const Range between{start.rests[k].range.end, start.rests[k + 1].range.begin};
    const Vector3d begin = start.up(start.rests[k]), end = start.up(start.rests[k + 1]);
    if (begin.dot(end) > std::cos(least_turn) || recording.saturated_in(between) > 0 || recording.gaps_in({between.begin, between.end + 1}) > 0)
      continue;
    Vector3d carried = begin;  // gravity turns in the IMU against the IMU's turning
    for (std::size_t i = between.begin; i < between.end; ++i)
      carried = rotation_exp(-recording.interval_s * (gyro * (start.scaling.gyro(reading_at(recording.gyro, i)) - at_rest))) * carried;
    turned += (end - begin).squaredNorm();
    missed += (end - carried).squaredNorm();
    ++turns;
  }
  if (turns < fewest) return std::nullopt;
  return 1 - missed / turned;
}

}  // namespace

std::optional<Matrix3d> coarse_gyro_in_common_turns(const Recording& recording, const RestStart& start) {
  const std::optional<Matrix3d> coarse = coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  // Scales that are off by a third explain nine tenths; gyros that have nothing to do with the turns explain none of them, or less.
  constexpr double least = 0.5;
  const auto by_coarse = coarse ? explained_turning(recording, start, *coarse) : std::nullopt;
  const auto as_declared = recording.gyro_unit != "count" ? explained_turning(recording, start, Matrix3d::Identity()) : std::nullopt;
  const double best = std::max(by_coarse.value_or(-HUGE_VAL), as_declared.value_or(-HUGE_VAL));
  if ((by_coarse || as_declared) && best < least)
    throw Unsupported(
        fmt::format("{}: the gyros do not turn with the accelerometers: they explain {:.0f} % of the turning of gravity between the rests; "
                    "check that both triads are of one recording, with stamps of one clock",
                    recording.name, 100 * std::max(0.0, best)));
  if (!coarse || recording.gyro_unit == "count") return coarse;
  const bool lost = !recording.gaps.empty() || !recording.saturated.empty();  // and with it the turns that would show the scale
  if (!as_declared) return lost ? std::nullopt : coarse;
  return *as_declared > *by_coarse && !near_identity(*coarse) ? std::nullopt : coarse;
}

}  // namespace imulab::kernel
