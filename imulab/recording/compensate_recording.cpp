#include "imulab/recording/compensate_recording.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/compensate.hpp"
#include "imulab/model/outlier_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

template <class Out>
std::array<Out, 3> spans(auto& columns) {
  return {Out(columns[0]), Out(columns[1]), Out(columns[2])};
}

bool out_of_range(const TriadModel& m, const Columns3& temperature, std::size_t sample) {
  if (!m.temperature || temperature[0].empty()) return false;
  return std::any_of(temperature.begin(), temperature.end(), [&](const auto& t) { return !in_range(*m.temperature, t[sample]); });
}

/// Samples with a replaced reading.
std::vector<std::size_t> replace_outliers(Recording& r) {
  const std::vector<std::uint8_t> marks = reject_outliers({r.gyro[0], r.gyro[1], r.gyro[2], r.accel[0], r.accel[1], r.accel[2]});
  std::vector<std::size_t> replaced;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i] != 0) replaced.push_back(i);
  return replaced;
}

/// A calibration made from counts is meaningless for physical readings, and the reverse.
void check_unit(const Recording& recording, const char* triad, const std::string& unit, const TriadModel& model) {
  if (!model.raw_unit.empty() && model.raw_unit != unit)
    throw Error(recording.name + ": " + triad + " is in " + unit + ", expected " + model.raw_unit + ", which the calibration was made from");
}

/// Readings beyond what a double holds after the third power are no sensor's.
void expect_finite(const Recording& r) {
  for (const auto* triad : {&r.gyro, &r.accel})
    for (const auto& column : *triad)
      for (std::size_t i = 0; i < column.size(); ++i)
        if (!std::isfinite(column[i]))
          throw Error(r.name + ": the sample at " + std::to_string(r.time_s(i)) + " s has a reading that no compensation makes finite");
}

}  // namespace

CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers) {
  CompensatedRecording out{std::move(recording), {}, {}};
  Recording& r = out.recording;
  check_unit(r, "accel", r.accel_unit, model.accel);
  check_unit(r, "gyro", r.gyro_unit, model.gyro);
  if (outliers == Outliers::reject) out.replaced = replace_outliers(r);
  using In = std::span<const double>;
  const RawColumns raw{spans<In>(r.gyro), spans<In>(r.accel), spans<In>(r.gyro_temperature), spans<In>(r.accel_temperature)};
  try {
    compensate(model, raw, {spans<std::span<double>>(r.gyro), spans<std::span<double>>(r.accel)});
  } catch (const Error& e) {
    throw Error(r.name + ": " + e.what());
  }
  expect_finite(r);
  r.gyro_unit = "rad/s";
  r.accel_unit = "m/s^2";
  for (std::size_t i = 0; i < r.size(); ++i)
    if (out_of_range(model.accel, r.accel_temperature, i) || out_of_range(model.gyro, r.gyro_temperature, i)) out.out_of_range.push_back(i);
  return out;
}

void remove_lever_arms(Recording& r, const Matrix3d& lever_arm) {
  const auto rate = [&](std::size_t i) { return Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]); };
  for (std::size_t i = 0; i < r.size(); ++i) {
    const std::size_t before = i > 0 && !r.follows_gap(i) ? i - 1 : i, after = i + 1 < r.size() && !r.follows_gap(i + 1) ? i + 1 : i;
    Vector3d acceleration = Vector3d::Zero();
    if (after > before) acceleration = (rate(after) - rate(before)) / (r.time_s(after) - r.time_s(before));
    const Vector3d effect = size_effect(rate(i), acceleration, lever_arm);
    for (std::size_t axis = 0; axis < 3; ++axis) r.accel[axis][i] -= effect[static_cast<Eigen::Index>(axis)];
  }
}

}  // namespace imulab
