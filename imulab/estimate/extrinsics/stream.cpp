#include "imulab/estimate/extrinsics/stream.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace imulab::extrinsics {
namespace {

constexpr double least_interval_s = 0.004;  // hands and vehicles turn more slowly than these means resolve

Recording compensated(const BodyImu& imu) {
  if (imu.calibration) return compensate(imu.calibration->model, imu.recording).recording;
  for (const std::string& unit : {imu.recording.gyro_unit, imu.recording.accel_unit})
    if (unit == "count")
      throw Error(
          fmt::format("{}: its readings are counts; expected a calibration, or counts_per_unit and the unit that so many counts are", imu.name));
  return imu.recording;
}

Vector3d row_of(const Columns3& columns, std::size_t i) { return {columns[0][i], columns[1][i], columns[2][i]}; }

}  // namespace

Stream stream_of(const BodyImu& imu, std::int64_t origin_ns) {
  if (imu.recording.size() < 2 || imu.recording.gyro[0].empty() || imu.recording.accel[0].empty())
    throw Error(imu.name + ": has no gyros, or no accelerometers; expected both");
  const auto is_constant = [](const std::vector<double>& axis) {
    return std::all_of(axis.begin(), axis.end(), [&](double x) { return x == axis.front(); });
  };
  for (const auto& [columns, triad] : {std::pair{&imu.recording.gyro, "gyros"}, {&imu.recording.accel, "accelerometers"}})
    if (std::all_of(columns->begin(), columns->end(), is_constant))
      throw Error(fmt::format("{}: the readings of its {} never change; expected those of a moving IMU", imu.name, triad));
  const Recording recording = compensated(imu);
  const double own_interval = recording.interval_s;
  const auto together = static_cast<std::size_t>(std::max(1., std::floor(least_interval_s / own_interval + 0.01)));
  const std::int64_t shift = imu.clock_zero_ns - origin_ns;
  Stream out;
  out.samples.reserve(recording.size() / together);
  Sample mean;
  std::size_t n = 0;
  auto saturated = recording.saturated.begin();
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const double end = 1e-9 * static_cast<double>(recording.time_ns[i] + shift);
    const double begin = end - recording.interval(i, false);
    while (saturated != recording.saturated.end() && *saturated < i) ++saturated;
    if (saturated != recording.saturated.end() && *saturated == i) {
      n = 0;
      continue;
    }
    if (n == 0 || recording.follows_gap(i)) mean = {begin, end, Vector3d::Zero(), Vector3d::Zero()}, n = 0;
    mean.rate += row_of(recording.gyro, i), mean.force += row_of(recording.accel, i), mean.end = end;
    if (++n < together) continue;
    mean.rate /= static_cast<double>(n), mean.force /= static_cast<double>(n);
    out.samples.push_back(mean);
    n = 0;
  }
  out.interval = own_interval * static_cast<double>(together);
  return out;
}

std::vector<Span> spans_with_motion(const Stream& stream, const Span& whole, double most) {
  if (whole.length() <= most) return {whole};
  constexpr double piece_s = 10;
  const auto pieces = static_cast<std::size_t>(whole.length() / piece_s);
  std::vector<double> motion(pieces, 0), count(pieces, 0);
  Vector3d mean = Vector3d::Zero();
  for (const Sample& s : stream.samples) mean += s.rate / static_cast<double>(stream.samples.size());
  for (const Sample& s : stream.samples) {
    const double place = (s.end - whole.begin) / piece_s;
    if (place < 0 || place >= static_cast<double>(pieces)) continue;
    motion[static_cast<std::size_t>(place)] += (s.rate - mean).squaredNorm(), ++count[static_cast<std::size_t>(place)];
  }
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < pieces; ++i)
    if (count[i] > 0) order.emplace_back(-motion[i], i);
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), static_cast<std::size_t>(most / piece_s)));
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<Span> out;
  for (const auto& [motion_of, i] : order) {
    const double begin = whole.begin + piece_s * static_cast<double>(i);
    if (!out.empty() && begin - out.back().end < 1e-6)
      out.back().end = begin + piece_s;
    else
      out.push_back({begin, begin + piece_s});
  }
  return out;
}

}  // namespace imulab::extrinsics
