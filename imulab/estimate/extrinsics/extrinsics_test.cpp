#include "imulab/extrinsics.hpp"

#include "imulab/calibrate.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace imulab {
namespace {

using testing::Contains, testing::HasSubstr;

/// A motion of three sines an axis. Rates and forces are independent: those of one IMU need not be of one attitude.
struct Sway {
  Matrix3d along = Matrix3d::Identity();  ///< of the rates
  double pace = 1;

  Vector3d rate(double t) const { return along * sines(t, 0); }
  Vector3d slope(double t) const { return along * sines(t, 1); }
  Vector3d force(double t) const { return {3 * std::sin(2.3 * t), 5 * std::cos(3.7 * t), 9.8 + std::sin(4.9 * t + 1)}; }
  Vector3d force_at(double t, const Vector3d& r) const {
    const Vector3d w = rate(t);
    return force(t) + slope(t).cross(r) + w.cross(w.cross(r));
  }

 private:
  Vector3d sines(double t, int derivative) const {
    constexpr std::array<std::array<double, 3>, 3> frequencies{{{1.7, 3.1, 9.4}, {2.2, 5.3, 8.6}, {0.9, 4.1, 7.9}}};
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const double w = pace * frequencies[i][k], phase = w * t + static_cast<double>(3 * i + k * k);
        sum[static_cast<Eigen::Index>(i)] += derivative == 0 ? 0.6 * std::sin(phase) : 0.6 * w * std::cos(phase);
      }
    return sum;
  }
};

struct Place {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d arm = Vector3d::Zero();
  double offset = 0, delay = 0, rate_hz = 100, drift = 0;
};

constexpr double gyro_density = 1e-4, accel_density = 1e-3;

/// Means over the intervals by Simpson's rule, with white noise and offsets.
BodyImu imu(const std::string& name, const Place& place, const Sway& motion = {}, double seconds = 20) {
  const RandomStream random(7, name);
  const double h = 1 / place.rate_hz, root = std::sqrt(place.rate_hz);
  std::vector<double> t;
  Columns3 gyro, accel;
  std::uint64_t drawn = 0;
  for (double stamp = 1; stamp < seconds + 1; stamp += h) {
    const auto mean = [&](const auto& of) {
      const double end = (stamp - place.offset) * (1 - place.drift);
      return Vector3d((of(end - h) + 4 * of(end - h / 2) + of(end)) / 6);
    };
    const Vector3d rate = (1 - place.drift) * place.rotation * mean([&](double s) { return motion.rate(s); });  // per second of its own clock
    const Vector3d force = place.rotation * mean([&](double s) { return motion.force_at(s - place.delay, place.arm); });
    t.push_back(stamp);
    for (int i = 0; i < 3; ++i) {
      gyro[static_cast<std::size_t>(i)].push_back(rate[i] + 0.01 + gyro_density * root * random.normal(drawn++));
      accel[static_cast<std::size_t>(i)].push_back(force[i] - 0.05 + accel_density * root * random.normal(drawn++));
    }
  }
  return {.name = name, .recording = make_recording(t, gyro, accel, {.name = name})};
}

const Place second{rotation_exp({0.5, -1.1, 0.3}), {0.21, -0.08, 0.4}, 0.0123, 0, 200};
const Place third{rotation_exp({-0.2, 0.4, 2.1}), {-0.3, 0.25, 0.02}, -0.31, 0.004, 50};

void expect_near(const Mounting& m, const Place& from, const Place& to) {
  constexpr double most = 4.5;  // sigmas, of 8 numbers of each
  const Vector3d turned = rotation_log(m.rotation * (to.rotation * from.rotation.transpose()).transpose());
  const Vector3d arm = from.rotation * (to.arm - from.arm);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(turned[i], 0, most * m.uncertainties(Mounting::rotation_row)[i]) << m.to << i;
    EXPECT_NEAR(m.lever_arm[i], arm[i], most * m.uncertainties(Mounting::lever_arm_row)[i]) << m.to << i;
  }
  EXPECT_NEAR(m.clock_offset, to.offset - from.offset, most * m.uncertainty(Mounting::clock_offset_row));
  EXPECT_NEAR(m.accel_delay, to.delay - from.delay, most * m.uncertainty(Mounting::accel_delay_row));
}

TEST(Extrinsics, AreFoundWithTheirUncertainties) {
  const Extrinsics found = estimate_extrinsics({imu("a", {}), imu("b", second), imu("c", third)});
  EXPECT_EQ(found.verdict, Verdict::good) << testing::PrintToString(found.findings.reasons());
  expect_near(found.between(0, 1), {}, second), expect_near(found.between(0, 2), {}, third), expect_near(found.between(1, 2), second, third);
  const Mounting m = found.between(0, 1);
  // What 20 s of 1 rad/s and noise of these densities give: the scales of the gyros, uncertain by 1 %, are most of it.
  EXPECT_LT(m.uncertainty(Mounting::lever_arm_row), 0.005);
  EXPECT_LT(m.uncertainty(Mounting::clock_offset_row), 2e-5);
  EXPECT_LT(m.uncertainty(Mounting::rotation_row), 0.6 * unit::deg);
  EXPECT_TRUE(found.findings.has(Code::accels_late));
  EXPECT_NEAR(found.residuals[1].gyro, gyro_density * std::sqrt(second.rate_hz), 0.1 * gyro_density * std::sqrt(second.rate_hz));
  EXPECT_NEAR(found.residuals[2].accel, accel_density * std::sqrt(third.rate_hz), 0.15 * accel_density * std::sqrt(third.rate_hz));
}

TEST(Extrinsics, BetweenTwoIsTheInverseOfTheOtherWay) {
  const Extrinsics found = estimate_extrinsics({imu("a", {}), imu("b", second), imu("c", third)});
  const Mounting there = found.between(1, 2), back = found.between(2, 1), none = found.between(1, 1);
  EXPECT_LT((there.matrix() * back.matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(there.clock_offset, -back.clock_offset, 1e-15);
  const Matrix3d turn = there.rotation.transpose() * there.covariance.topLeftCorner<3, 3>() * there.rotation;
  EXPECT_LT((turn - back.covariance.topLeftCorner<3, 3>()).norm(), 1e-6 * turn.norm());
  EXPECT_TRUE(none.rotation.isIdentity(1e-12));
  EXPECT_TRUE(none.covariance.isZero(0));
  EXPECT_THROW(found.between(0, 3), Error);
}

TEST(Extrinsics, ACalibrationLeavesLessUncertain) {
  BodyImu a = imu("a", {}), b = imu("b", second);
  const Mounting rough = estimate_extrinsics({a, b}).between(0, 1);
  for (BodyImu* each : {&a, &b}) {
    Calibration& c = each->calibration.emplace();
    c.model.gyro.raw_unit = "rad/s", c.model.accel.raw_unit = "m/s^2";
    for (const CoefficientIndex index : coefficient_indices())
      if (coefficient(index).term == Term::matrix) c.estimated.push_back(index);
    const auto n = static_cast<Eigen::Index>(c.estimated.size());
    c.covariance = 1e-8 * Eigen::MatrixXd::Identity(n, n);
  }
  const Extrinsics found = estimate_extrinsics({a, b});
  expect_near(found.between(0, 1), {}, second);
  EXPECT_LT(found.between(0, 1).uncertainty(Mounting::lever_arm_row), 0.5 * rough.uncertainty(Mounting::lever_arm_row));
  EXPECT_LT(found.between(0, 1).uncertainty(Mounting::rotation_row), 0.02 * unit::deg);
  EXPECT_FALSE(found.findings.has(Code::imu_not_calibrated));
}

TEST(Extrinsics, TurnsAboutOneAxisDoNotShowTheLeverArmAlongIt) {
  Sway motion;
  motion.along = Vector3d::UnitZ() * Vector3d(0.3, 1, 1).transpose();
  const Extrinsics found = estimate_extrinsics({imu("a", {}, motion), imu("b", second, motion)});
  const Mounting m = found.between(0, 1);
  EXPECT_GT(m.uncertainties(Mounting::lever_arm_row).z(), 0.1);
  EXPECT_LT(m.uncertainty(Mounting::lever_arm_row), 0.02);
  EXPECT_THAT(m.not_shown, Contains("lever arm along z"));
  EXPECT_TRUE(found.findings.has(Code::mounting_not_shown));
}

std::string problem_of(const std::vector<BodyImu>& imus) {
  try {
    estimate_extrinsics(imus);
  } catch (const Error& e) {
    return e.what();
  } catch (const Unsupported& e) {
    return e.what();
  }
  return "";
}

TEST(Extrinsics, WhatIsNotOneBodyIsNamed) {
  BodyImu mirrored = imu("b", second);
  for (double& x : mirrored.recording.gyro[1]) x = -x;
  EXPECT_THAT(problem_of({imu("a", {}), mirrored}), HasSubstr("expected"));
  for (double& x : mirrored.recording.accel[1]) x = -x;
  EXPECT_THAT(problem_of({imu("a", {}), mirrored}), HasSubstr("expected"));
  Sway other;
  other.pace = 1.3;
  EXPECT_THAT(problem_of({imu("a", {}), imu("b", second, other)}), HasSubstr("do not turn alike"));
}

TEST(Extrinsics, AWrongSignOfOneAccelerometerIsNeverGood) {
  BodyImu b = imu("b", second);
  for (double& x : b.recording.accel[1]) x = -x;
  const std::string problem = problem_of({imu("a", {}), b});
  if (problem.empty()) EXPECT_EQ(estimate_extrinsics({imu("a", {}), b}).verdict, Verdict::doubtful);
}

TEST(Extrinsics, BadInputIsRefused) {
  EXPECT_THAT(problem_of({imu("a", {})}), HasSubstr("one IMU (a); expected two or more"));
  EXPECT_THAT(problem_of({imu("a", {}), imu("a", second)}), HasSubstr("a: two IMUs have this name"));
  EXPECT_THAT(problem_of({imu("a", {}), imu("b", second, {}, 3)}), HasSubstr("less than 5 s in common"));
  BodyImu again = imu("a", {});
  again.name = "b";
  EXPECT_THAT(problem_of({imu("a", {}), again}), HasSubstr("a and b have the same readings"));
  BodyImu counts = imu("b", second);
  counts.recording.gyro_unit = "count";
  EXPECT_THAT(problem_of({imu("a", {}), counts}), HasSubstr("b: its readings are counts; expected a calibration"));
  BodyImu still = imu("b", second);
  for (Columns3* columns : {&still.recording.gyro, &still.recording.accel})
    for (auto& axis : *columns) std::fill(axis.begin(), axis.end(), 0.1);
  EXPECT_THAT(problem_of({imu("a", {}), still}), HasSubstr("b: the readings of its gyros never change"));
  BodyImu unknown = imu("b", second);
  unknown.grade = "toy";
  EXPECT_THAT(problem_of({imu("a", {}), unknown}), HasSubstr("toy"));
}

TEST(Extrinsics, RecordsOverlapInPart) {
  BodyImu b = imu("b", second);
  b.recording = imu("b", second, {}, 12).recording;
  const Extrinsics found = estimate_extrinsics({imu("a", {}), b});
  EXPECT_EQ(found.verdict, Verdict::good) << testing::PrintToString(found.findings.reasons());
  EXPECT_GT(found.agreement[0], 0.99);
  expect_near(found.between(0, 1), {}, second);
}

TEST(Extrinsics, ACompliantMountIsDoubted) {
  BodyImu b = imu("b", second);
  constexpr std::size_t late = 8;  // samples: the mount bends 40 ms after the motion
  for (std::size_t i = late; i < b.recording.gyro[0].size(); ++i) b.recording.gyro[0][i] += 0.05 * b.recording.gyro[1][i - late];
  EXPECT_EQ(estimate_extrinsics({imu("a", {}), b}).verdict, Verdict::doubtful);
}

TEST(Extrinsics, OfOneImuAreWhatItsMotionWouldShowOfAnother) {
  const Mounting found = estimate_extrinsics({imu("a", {}), imu("b", {rotation_exp({0.6, -0.8, 1}), Vector3d::Constant(0.1)})}).between(0, 1);
  const Extrinsics predicted = predict_extrinsics(imu("a", {}));
  EXPECT_TRUE(predicted.findings.has(Code::mounting_predicted));
  const Mounting& m = predicted.from_first.front();
  // The grade has five times the noise of these readings; scales and misalignments make most of the rest.
  for (const auto row : {Mounting::rotation_row, Mounting::lever_arm_row}) {
    EXPECT_GT(m.uncertainty(row), 0.7 * found.uncertainty(row));
    EXPECT_LT(m.uncertainty(row), 5 * found.uncertainty(row));
  }
  Sway about_z;
  about_z.along = Vector3d::UnitZ() * Vector3d(0.3, 1, 1).transpose();
  EXPECT_THAT(predict_extrinsics(imu("a", {}, about_z)).from_first.front().not_shown, Contains("lever arm along z"));
  EXPECT_THROW(predict_extrinsics(imu("a", {}, {}, 3)), Unsupported);
}

TEST(ReferenceMethod, OffsetsThatDriftAreCurvesOverTime) {
  constexpr double drift = 5e-4;  // rad/s of gyro y, m/s^2 of accelerometer z, each second
  std::vector<Recording> recordings{imu("a", {}).recording, imu("b", second, {}, 30).recording};
  for (std::size_t i = 0; i < recordings[1].size(); ++i) {
    recordings[1].gyro[1][i] += drift * recordings[1].time_s(i);
    recordings[1].accel[2][i] += 20 * drift * recordings[1].time_s(i);
  }
  Session session;
  session.imu.name = "b", session.imu.grade = "mems";
  for (const char* name : {"a", "b"}) {
    RecordingSource& source = session.recordings.emplace_back();
    source.file = source.imu = name;
    source.gyro.unit = "rad/s", source.accel.unit = "m/s^2";
  }
  CalibrationOptions options;
  options.reference = ReferenceImu{.imu = "a", .grade = "tactical"};
  const CalibrationResult found = calibrate("reference", {session, recordings}, options);
  ASSERT_EQ(found.curves.size(), 6u);
  ASSERT_GE(found.curve_time.size(), 3u);
  const double seconds = found.curve_time.back() - found.curve_time.front();
  for (const ConvergenceCurve& curve : found.curves) {
    const double change = curve.residual.back() - curve.residual.front(), sigma = std::hypot(curve.sigma.front(), curve.sigma.back());
    const double expected = curve.name == "gyro.offset.y" ? -drift : curve.name == "accel.offset.z" ? -20 * drift : 0;
    EXPECT_NEAR(change, expected * seconds, 5 * sigma + 0.02 * drift * seconds) << curve.name;  // of matrices that the drift has changed
  }
}

/// The readings have no errors but offsets; the calibration is off by a draw of its covariance, which also ties the offsets to the scales.
BodyImu calibrated(BodyImu imu, double sigma, std::uint64_t seed) {
  Calibration& c = imu.calibration.emplace();
  c.model.gyro.raw_unit = "rad/s", c.model.accel.raw_unit = "m/s^2";
  c.estimated = select_each({"gyro.matrix", "accel.matrix", "gyro.offset", "accel.offset"});
  std::erase_if(c.estimated, zero_by_frame);
  const auto n = std::ssize(c.estimated);
  Eigen::MatrixXd factor = sigma * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    if (coefficient(c.estimated[static_cast<std::size_t>(i)]).term == Term::offset) factor.row(i).setConstant(0.2 * sigma);
  c.covariance = factor * factor.transpose() + 1e-4 * sigma * sigma * Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd draw(n);
  RandomStream(seed, imu.name).normals(0, {draw.data(), static_cast<std::size_t>(n)});
  const Eigen::VectorXd errors = Cholesky(c.covariance).lower() * draw;
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    set_coefficient(c.model, c.estimated[k], coefficient_value(c.model, c.estimated[k]) + errors[static_cast<Eigen::Index>(k)]);
  c.quality.verdict = Verdict::good;
  return imu;
}

/// Of all but the offsets, which the readings have, too.
Eigen::VectorXd errors_of(const Calibration& c) {
  Eigen::VectorXd out = coefficient_values(c.model, c.estimated);
  for (std::size_t k = 0; k < c.estimated.size(); ++k) out[static_cast<Eigen::Index>(k)] -= is_scale(coefficient(c.estimated[k])) ? 1 : 0;
  return out;
}
double per_coefficient(const Calibration& c) { return squared_norm_in(c.covariance, errors_of(c)) / static_cast<double>(c.estimated.size()); }

TEST(JointCalibration, IsMoreCertainAndItsUncertaintiesHold) {
  double alone = 0, jointly = 0, squares = 0, squares_alone = 0;
  constexpr int bodies = 3;
  for (std::uint64_t seed = 1; seed <= bodies; ++seed) {
    const std::vector<BodyImu> imus{calibrated(imu("a", {}), 2e-3, seed), calibrated(imu("b", second), 2e-3, seed),
                                    calibrated(imu("c", third), 2e-3, seed)};
    const std::vector<Calibration> found = calibrate_jointly(imus);
    for (std::size_t k = 0; k < imus.size(); ++k) {
      const Calibration& before = *imus[k].calibration;
      EXPECT_EQ(found[k].quality.verdict, Verdict::good);
      EXPECT_TRUE(found[k].quality.findings.has(Code::joint_estimate));
      EXPECT_GE((before.covariance.diagonal() - found[k].covariance.diagonal()).minCoeff(), 0) << "at least as certain as alone";
      alone += per_coefficient(before), jointly += per_coefficient(found[k]);
      squares_alone += errors_of(before).squaredNorm(), squares += errors_of(found[k]).squaredNorm();
      EXPECT_LT(std::sqrt(found[k].covariance(0, 0) / before.covariance(0, 0)), 0.7) << "1/sqrt(3) for three alike, of which the motion tells all";
    }
  }
  constexpr double imus = 3 * bodies, chance = 0.35;  // 3 sigmas of 21 coefficients of 9 IMUs, which have errors in common after the motion
  EXPECT_NEAR(alone / imus, 1, chance);
  EXPECT_LT(jointly / imus, 1 + chance);
  EXPECT_GT(jointly / imus, 0.4) << "directions that the motion's noise seems to show count as not shown";
  EXPECT_LT(squares, 0.6 * squares_alone);
}

TEST(JointCalibration, TheBetterOneHelpsTheOther) {
  const std::vector<BodyImu> imus{calibrated(imu("a", {}), 1e-4, 1), calibrated(imu("b", second), 1e-2, 1)};
  const std::vector<Calibration> found = calibrate_jointly(imus);
  const auto of_gyros = [](const Calibration& c) { return errors_of(c).head<9>().norm(); };
  EXPECT_LT(of_gyros(found[1]), 0.2 * of_gyros(*imus[1].calibration));
  EXPECT_LT(std::sqrt(found[1].covariance(0, 0)), 5e-4);
  EXPECT_LT(per_coefficient(found[1]), 2);
  EXPECT_NEAR(std::sqrt(found[0].covariance(0, 0)), 1e-4, 2e-6);
}

TEST(JointCalibration, EachCountsSecondsOfItsOwnClock) {
  Place fast = second;
  fast.drift = 3e-4;
  const std::vector<Calibration> found = calibrate_jointly({calibrated(imu("a", {}), 5e-5, 1), calibrated(imu("b", fast), 5e-5, 1)});
  for (const Calibration& c : found) {
    EXPECT_EQ(c.quality.verdict, Verdict::good) << testing::PrintToString(c.quality.findings.reasons());
    EXPECT_LT(per_coefficient(c), 2);
    EXPECT_LT(errors_of(c).head<9>().cwiseAbs().maxCoeff(), 1.5e-4);
  }
}

TEST(JointCalibration, AContradictionIsDoubted) {
  std::vector<BodyImu> imus{calibrated(imu("a", {}), 1e-3, 1), calibrated(imu("b", second), 1e-3, 1)};
  imus[1].calibration->model.gyro.matrix(0, 0) += 0.02;
  const std::vector<Calibration> found = calibrate_jointly(imus);
  for (std::size_t k = 0; k < imus.size(); ++k) {
    EXPECT_EQ(found[k].quality.verdict, Verdict::doubtful);
    EXPECT_EQ(errors_of(found[k]), errors_of(*imus[k].calibration));
  }
}

TEST(JointCalibration, NeedsGoodCalibrationsAndOneBody) {
  Sway other;
  other.pace = 1.3;
  BodyImu a = calibrated(imu("a", {}), 1e-3, 1), b = calibrated(imu("b", second), 1e-3, 1);
  EXPECT_THROW(calibrate_jointly({a, calibrated(imu("b", second, other), 1e-3, 1)}), Unsupported);
  b.calibration->quality.verdict = Verdict::doubtful;
  EXPECT_THROW(calibrate_jointly({a, b}), Error);
  EXPECT_THROW(calibrate_jointly({a, imu("b", second)}), Error);
}

}  // namespace
}  // namespace imulab
