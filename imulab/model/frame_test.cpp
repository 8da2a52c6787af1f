#include "imulab/frame.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"

#include <Eigen/LU>
#include <gmock/gmock.h>

#include <numeric>

namespace imulab {
namespace {

Eigen::MatrixXd drawn_in_frame(int rows, int columns, std::uint64_t stream) {
  const RandomStream random(20261120, stream);
  Eigen::MatrixXd m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m(i) = random.normal(static_cast<std::uint64_t>(i));
  return m;
}

/// Returns a model with all terms except quadratic and cubic ones, misaligned by about `misalignment`, in a frame rotated by `turn` [rad].
SensorModel framed_model(double misalignment, double turn) {
  SensorModel m;
  m.accel.offset = drawn_in_frame(3, 1, 1);
  m.gyro.offset = drawn_in_frame(3, 1, 2);
  const Matrix3d frame = rotation_exp(turn * Vector3d(drawn_in_frame(3, 1, 3)).normalized());
  m.accel.matrix = 0.01 * frame * (Matrix3d::Identity() + misalignment * Matrix3d(drawn_in_frame(3, 3, 4)));
  m.gyro.matrix = 0.002 * frame * (Matrix3d::Identity() + misalignment * Matrix3d(drawn_in_frame(3, 3, 5)));
  m.g_sensitivity = 1e-3 * drawn_in_frame(3, 3, 6);
  m.lever_arm = 0.1 * drawn_in_frame(3, 3, 7);
  return m;
}

std::vector<CoefficientIndex> all_coefficients() { return {coefficient_indices().begin(), coefficient_indices().end()}; }

/// Returns P = L L^T with standard deviations of `size` relative to 1.
Eigen::MatrixXd covariance_of(int n, double size) {
  const Eigen::MatrixXd l = size * drawn_in_frame(n, n, 8);
  return l * l.transpose();
}

TEST(AccelerometerFrame, FollowsTheSensitiveAxes) {
  for (const double turn : {0.0, 1e-3, 0.5, 3.0}) {
    const Matrix3d a1 = framed_model(0.02, turn).accel.matrix;
    const Matrix3d r = accelerometer_frame(a1);
    const Matrix3d lower = r * a1;
    const Matrix3d axes = a1.inverse() * r.transpose();  // row i: sensitive axis of accelerometer i in the new frame
    // Products of rotations and a matrix of norm 0.02 (its inverse: 200) have rounding errors of a few units.
    EXPECT_LE((r * r.transpose() - Matrix3d::Identity()).norm(), 1e-15 * 4);
    EXPECT_GT(r.determinant(), 0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(lower(i, i), 0);
      for (int j = i + 1; j < 3; ++j) {
        EXPECT_NEAR(lower(i, j), 0, 1e-16);
        EXPECT_NEAR(axes(i, j), 0, 1e-12);
      }
    }
    EXPECT_GT(axes(0, 0), 0);
  }
}

TEST(AccelerometerFrame, IsTheIdentityForALowerTriangularMatrix) {
  Matrix3d a1;
  a1 << 0.013, 0, 0, 1e-4, 0.017, 0, -2e-4, 3e-4, 0.011;
  EXPECT_EQ(accelerometer_frame(a1), Matrix3d(Matrix3d::Identity()));
}

TEST(AccelerometerFrame, OfALeftHandedTriadIsStillARotation) {
  Matrix3d a1 = framed_model(0.02, 0.5).accel.matrix;
  a1.col(2) *= -1;
  const Matrix3d r = accelerometer_frame(a1);
  EXPECT_NEAR(r.determinant(), 1, 1e-14);
  EXPECT_GT((r * a1)(0, 0), 0);
  EXPECT_GT((r * a1)(1, 1), 0);
  EXPECT_LT((r * a1)(2, 2), 0);
}

TEST(AccelerometerFrame, ASingularMatrixIsAnError) {
  EXPECT_THROW(accelerometer_frame(Matrix3d::Zero()), Error);
  Matrix3d flat = Matrix3d::Identity();
  flat.col(2) = flat.col(0) + flat.col(1);
  EXPECT_THROW(accelerometer_frame(flat), Error);
}

TEST(InAccelerometerFrame, CompensatesToTheSameMotionInTheNewFrame) {
  Calibration c;
  c.frame = BodyFrame::rig;
  c.model = framed_model(0.02, 0.5);
  const Calibration turned = in_accelerometer_frame(c);
  EXPECT_EQ(turned.frame, BodyFrame::accelerometers);
  const Matrix3d r = accelerometer_frame(c.model.accel.matrix);
  const RawSample raw{.gyro = {70, 40, -90}, .accel = {300, -500, 800}};
  const Motion before = compensate(c.model, raw), after = compensate(turned.model, raw);
  // The tolerance is for sums of about 10 in size.
  EXPECT_LE((after.force - r * before.force).norm(), 1e-14 * 10);
  EXPECT_LE((after.rate - r * before.rate).norm(), 1e-14 * 10);
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_LE((turned.model.lever_arm.row(i).transpose() - r * c.model.lever_arm.row(i).transpose()).norm(), 1e-15);
}

TEST(InAccelerometerFrame, LeavesACalibrationThatIsInItAlone) {
  Calibration c;
  c.model = framed_model(0.02, 0);
  c.model.accel.matrix << 0.013, 0, 0, 1e-4, 0.017, 0, -2e-4, 3e-4, 0.011;
  c.estimated = all_coefficients();
  std::erase_if(c.estimated, [](CoefficientIndex i) { return coefficient(i).name.starts_with("accel.matrix.x") && i > 3; });
  std::erase_if(c.estimated, [](CoefficientIndex i) { return coefficient(i).name == "accel.matrix.yz"; });
  ASSERT_EQ(std::ssize(c.estimated), coefficient_count - 3);
  c.covariance = covariance_of(coefficient_count - 3, 1e-4);
  const Calibration same = in_accelerometer_frame(c);
  for (const CoefficientIndex i : coefficient_indices()) EXPECT_EQ(coefficient_value(same.model, i), coefficient_value(c.model, i));
  EXPECT_EQ(same.estimated, c.estimated);
  EXPECT_LE((same.covariance - c.covariance).norm(), 1e-14 * c.covariance.norm());  // the Jacobian is the identity up to rounding
}

/// Compares the covariance with central differences of the whole transformation, for a rotation and misalignment where R's dependence matters.
TEST(InAccelerometerFrame, CovarianceFollowsTheRotationsDependenceToo) {
  Calibration c;
  c.frame = BodyFrame::rig;
  c.model = framed_model(0.05, 0.5);
  c.model.accel.temperature = c.model.gyro.temperature = ThermalReading{};
  c.estimated = all_coefficients();
  c.covariance = covariance_of(coefficient_count, 1e-4);
  const Calibration turned = in_accelerometer_frame(c);
  ASSERT_EQ(std::ssize(turned.estimated), coefficient_count - 3);

  Eigen::MatrixXd jacobian(coefficient_count - 3, coefficient_count);
  for (const CoefficientIndex k : coefficient_indices()) {
    const double x = coefficient_value(c.model, k), h = 1e-5 * std::max(std::abs(x), 1e-3);
    Calibration low = c, high = c;
    set_coefficient(low.model, k, x - h);
    set_coefficient(high.model, k, x + h);
    low = in_accelerometer_frame(low);
    high = in_accelerometer_frame(high);
    for (int i = 0; i < coefficient_count - 3; ++i) {
      const CoefficientIndex at = turned.estimated[static_cast<std::size_t>(i)];
      jacobian(i, k) = (coefficient_value(high.model, at) - coefficient_value(low.model, at)) / (2 * h);
    }
  }
  const Eigen::MatrixXd expected = jacobian * c.covariance * jacobian.transpose();
  // Differences with h = 1e-8 of values of order 1 resolve 1e-16 / 1e-8 = 1e-8 of the sensitivities, of order 100 for R to A1.
  EXPECT_LE((turned.covariance - expected).norm(), 1e-6 * expected.norm());

  const Eigen::MatrixXd fixed_rotation = [&] {  // result without R's dependence, for the gyro offset
    const Matrix3d r = accelerometer_frame(c.model.accel.matrix);
    const CoefficientIndex at = coefficient_index("gyro.offset.x");
    return Eigen::MatrixXd(r * c.covariance.block<3, 3>(at, at) * r.transpose());
  }();
  const int at = coefficient_index("gyro.offset.x") - 3;  // three fewer estimated coefficients precede it
  EXPECT_GT((turned.covariance.block<3, 3>(at, at) - fixed_rotation).norm(), 0.1 * fixed_rotation.norm());
}

}  // namespace
}  // namespace imulab
