#include "tests/acceptance/mems_unit.hpp"

#include "imulab/estimate/whole_unit.hpp"
#include "imulab/rig/procedure.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace imulab::acceptance {

namespace {

/// Mean readings of a step.
struct Point {
  Vector3d up;       // body axis
  double rate = 0;   // about it
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();
};

std::vector<Point> points_of(const Recording& r, const Session& session) {
  std::vector<Point> points;
  for (const Step& step : session.steps) {
    if (step.recording != r.name || !step.mount) continue;
    Point p{step.mount->up.sign * Vector3d::Unit(step.mount->up.index), step.kind == StepKind::spin ? step.rate : 0};
    double samples = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      if (r.time_s(i) - r.interval_s < step.start - 1e-6 || r.time_s(i) > step.end + 1e-6) continue;
      p.accel += Vector3d(r.accel[0][i], r.accel[1][i], r.accel[2][i]);
      p.gyro += Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]);
      samples += 1;
    }
    p.accel /= samples, p.gyro /= samples;
    points.push_back(p);
  }
  return points;
}

}  // namespace

SensorModel traditional_calibration(const Recording& recording, const Session& session) {
  SensorModel out;
  // Readings are S f + D. With e the axis up: S = sum of readings e^T / sum of e e^T over the rests, since these cancel in D; gyros alike over the spins.
  Matrix3d accel = Matrix3d::Zero(), gyro = Matrix3d::Zero(), up = Matrix3d::Zero(), turned = Matrix3d::Zero();
  Vector3d rest_accel = Vector3d::Zero(), rest_gyro = Vector3d::Zero();
  double rests = 0;
  for (const Point& p : points_of(recording, session)) {
    gyro += p.rate * p.gyro * p.up.transpose();
    turned += p.rate * p.rate * p.up * p.up.transpose();
    if (p.rate != 0) continue;
    accel += p.accel * p.up.transpose();
    up += session.site.gravity() * p.up * p.up.transpose();
    rest_accel += p.accel, rest_gyro += p.gyro, rests += 1;
  }
  out.accel.matrix = (accel * up.inverse()).inverse();
  out.gyro.matrix = (gyro * turned.inverse()).inverse();
  out.accel.offset = -out.accel.matrix * rest_accel / rests;
  out.gyro.offset = -out.gyro.matrix * rest_gyro / rests;  // the Earth's rate cancels over opposed faces
  return out;
}

CalibratedUnit calibrated_unit(std::uint64_t seed) {
  Session session = dai_unit_procedure({});
  CalibratedUnit out{draw_truth(session, seed), {}, {}};
  std::vector<Recording> recordings;
  for (const RecordingSource& source : session.recordings)
    recordings.push_back(simulate_recording(session, source, out.truth, seed, draw_rig_errors(session, source, seed)));
  out.whole = calibrate_whole_unit(recordings, session, {.full = true}).model;
  const auto table = std::find_if(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::rate_table; });
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (session.recordings[i].rig == table->name) out.traditional = traditional_calibration(recordings[i], session);
  session.imu.noise = NoiseTerms::full;
  const Truth flown = draw_truth(session, seed);
  out.truth.gyro_noise = flown.gyro_noise, out.truth.accel_noise = flown.accel_noise;
  return out;
}

}  // namespace imulab::acceptance
