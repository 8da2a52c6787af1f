#include "imulab/extrinsics.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/extrinsics/body_fit.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/finding_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {

using namespace extrinsics;

double Mounting::uncertainty(int row) const { return std::sqrt(covariance(row, row)); }

Vector3d Mounting::uncertainties(Row first) const { return covariance.diagonal().segment<3>(first).cwiseSqrt(); }

Eigen::Matrix4d Mounting::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation;
  m.topRightCorner<3, 1>() = -rotation * lever_arm;
  return m;
}

Mounting Extrinsics::between(std::size_t from, std::size_t to) const {
  if (from >= imus.size() || to >= imus.size()) throw Error(fmt::format("{} IMUs; expected two of 0 to {}", imus.size(), imus.size() - 1));
  const Mounting none{.from = imus.front(), .to = imus.front(), .epoch = from_first.front().epoch};
  const Mounting &a = from == 0 ? none : from_first[from - 1], &b = to == 0 ? none : from_first[to - 1];
  Mounting m{.from = imus[from], .to = imus[to], .epoch = a.epoch};
  m.rotation = b.rotation * a.rotation.transpose();
  m.lever_arm = a.rotation * (b.lever_arm - a.lever_arm);
  m.clock_offset = b.clock_offset - a.clock_offset, m.clock_drift = b.clock_drift - a.clock_drift, m.accel_delay = b.accel_delay - a.accel_delay;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(mount_columns, covariance.rows());
  if (to > 0) {
    auto by_b = jacobian.middleCols<mount_columns>(static_cast<Eigen::Index>(mount_columns * (to - 1)));
    by_b.setIdentity();
    by_b.block<3, 3>(arm, arm) = a.rotation;
  }
  if (from > 0 && from != to) {
    auto by_a = jacobian.middleCols<mount_columns>(static_cast<Eigen::Index>(mount_columns * (from - 1)));
    by_a.diagonal().setConstant(-1);
    by_a.block<3, 3>(turn, turn) = -m.rotation;
    by_a.block<3, 3>(arm, turn) = -skew<double>(m.lever_arm);
    by_a.block<3, 3>(arm, arm) = -a.rotation;
  }
  if (from == to) jacobian.setZero();
  m.covariance = jacobian * covariance * jacobian.transpose();
  m.not_shown = not_shown(m);
  return m;
}

Extrinsics estimate_extrinsics(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress) {
  Extrinsics out;
  for (const BodyImu& imu : imus) {
    out.imus.push_back(imu.name);
    if (!imu.calibration) out.findings.add<Code::imu_not_calibrated>(Subject{imu.name}, "grade " + imu.grade);
  }
  const BodyFit body = fit_body(imus, {.progress = progress}, out.findings);
  out.duration = body.duration, out.used = body.used, out.agreement = body.agreement;
  out.residuals = body.residuals;
  if (!body.converged) out.findings.add<Code::not_converged>();
  const auto others = static_cast<Eigen::Index>(imus.size() - 1);
  out.covariance.resize(mount_columns * others, mount_columns * others);
  for (Eigen::Index a = 0; a < others; ++a)
    for (Eigen::Index b = 0; b < others; ++b)
      out.covariance.block<mount_columns, mount_columns>(mount_columns * a, mount_columns * b) =
          body.constants.covariance.block<mount_columns, mount_columns>(MotionFit::mount_column(static_cast<std::size_t>(a) + 1),
                                                                        MotionFit::mount_column(static_cast<std::size_t>(b) + 1));
  for (std::size_t k = 1; k < imus.size(); ++k) {
    out.rates.push_back(body.fit->rates(k));
    out.from_first.push_back(body.mounting(k, imus));
    body.judge_agreement(k, imus, out.rates.back(), out.findings);
    body.judge_scatter(out.from_first.back(), MotionFit::mount_column(k), mount_columns, out.findings);
    BodyFit::judge_mounting(out.from_first.back(), out.findings);
  }
  out.verdict = out.findings.doubtful() ? Verdict::doubtful : Verdict::good;
  return out;
}

namespace {

/// The readings of an IMU like it, turned and at a lever arm, with noise of its own: differences of rates, which have noise, only make it look worse.
Recording readings_at(const Recording& recording, const Matrix3d& rotation, const Vector3d& arm, const Grade& sizes) {
  Recording out = recording;
  const RandomStream random(1, "another IMU");
  const double root_rate = 1 / std::sqrt(recording.interval_s);
  const auto rate = [&](std::size_t i) { return Vector3d(recording.gyro[0][i], recording.gyro[1][i], recording.gyro[2][i]); };
  std::uint64_t drawn = 0;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const std::size_t before = i == 0 || recording.follows_gap(i) ? i : i - 1;
    const std::size_t after = i + 1 == recording.size() || recording.follows_gap(i + 1) ? i : i + 1;
    const double seconds = recording.time_s(after) - recording.time_s(before);
    const Vector3d slope = seconds > 0 ? Vector3d((rate(after) - rate(before)) / seconds) : Vector3d::Zero();
    const Vector3d force(recording.accel[0][i], recording.accel[1][i], recording.accel[2][i]);
    const Vector3d turned = rotation * rate(i), moved = rotation * (force + slope.cross(arm) + rate(i).cross(rate(i).cross(arm)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<Eigen::Index>(axis);
      out.gyro[axis][i] = turned[k] + sizes.gyro_noise.N * root_rate * random.normal(drawn++);
      out.accel[axis][i] = moved[k] + sizes.accel_noise.N * root_rate * random.normal(drawn++);
    }
  }
  return out;
}

}  // namespace

Extrinsics predict_extrinsics(const BodyImu& imu) {
  BodyImu moved = imu;
  if (moved.calibration) moved.recording = compensate(moved.calibration->model, imu.recording).recording, moved.calibration.reset();
  stream_of(moved, 0);  // throws for readings that move no body
  BodyImu other = moved;
  other.name = "another IMU";
  other.recording = readings_at(moved.recording, rotation_exp({0.6, -0.8, 1}), Vector3d::Constant(0.1), grade(imu.grade));
  if (other.name == imu.name) other.name += "'";
  Extrinsics out;
  try {
    out = estimate_extrinsics({moved, other});
  } catch (const Unsupported&) {
    throw Unsupported(imu.name + ": its motion shows no mounting; expected 5 s or more with turns of some 30 deg/s");
  }
  std::erase_if(out.findings, [](const Finding& f) { return f.severity == Severity::doubt; });  // of what is not measured
  out.verdict = Verdict::good;
  Mounting& m = out.from_first.front();  // nothing is measured
  m.rotation.setConstant(NAN), m.lever_arm.setConstant(NAN), m.clock_offset = m.clock_drift = m.accel_delay = NAN;
  out.rates.clear();
  out.findings.add<Code::mounting_predicted>(Subject{imu.name});
  return out;
}

}  // namespace imulab
