#include "imulab/navigation/budget/specification.hpp"

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

/// Fixed error and sigma of a coefficient by its name.
std::pair<double, double> of(const ErrorSources& s, std::string_view name) {
  const auto found = std::find(s.coefficients.begin(), s.coefficients.end(), coefficient_index(name));
  if (found == s.coefficients.end()) return {0, 0};
  const auto k = found - s.coefficients.begin();
  return {s.fixed[k], std::sqrt(s.covariance(k, k))};
}

TEST(ErrorSpecification, StatedTermsGoBeforeTheGradesOwn) {
  ErrorSpecification s;
  s.grade = "tactical";
  s.gyro.bias = Spread{2e-6, true};
  s.accel.N = 1e-3;
  const ErrorSources out = error_sources(s);
  const Grade& g = grade("tactical");
  EXPECT_EQ(of(out, "gyro.offset.y"), std::pair(2e-6, 0.));
  EXPECT_EQ(of(out, "accel.offset.y"), std::pair(0., g.accel_bias));
  EXPECT_NEAR(of(out, "gyro.matrix.xy").second, g.gyro_misalignment, 1e-18);
  EXPECT_NEAR(of(out, "gyro.matrix.zz").second, g.gyro_scale, 1e-18);
  EXPECT_NEAR(of(out, "accel.matrix.yx").second, g.accel_misalignment, 1e-18);
  EXPECT_EQ(of(out, "accel.matrix.xy").second, 0);  // a grade's accelerometers are referred to themselves
  EXPECT_EQ(out.accel_noise.N, 1e-3);
  EXPECT_EQ(out.gyro_noise, [&] {
    NoiseModel n = g.gyro_noise;
    n.resolution = n.range = 0;
    return n;
  }());
}

TEST(ErrorSpecification, WithoutAGradeOnlyWhatIsStatedErrs) {
  ErrorSpecification s;
  s.accel.misalignment = Spread{1e-4, false};
  const ErrorSources out = error_sources(s);
  EXPECT_EQ(out.coefficients.size(), 6u);
  EXPECT_DOUBLE_EQ(of(out, "accel.matrix.xy").second, 1e-4);
  EXPECT_EQ(out.gyro_noise, NoiseModel{});
}

TEST(ErrorSpecification, ASystemIsOfNavigationGradeWithItsOwnGyro) {
  ErrorSpecification s;
  s.system = "Laseref";
  const ErrorSources out = error_sources(s);
  EXPECT_DOUBLE_EQ(of(out, "gyro.offset.x").second, 0.1 * unit::deg_per_h);
  EXPECT_DOUBLE_EQ(of(out, "accel.offset.x").second, grade("navigation").accel_bias);
}

TEST(ErrorSpecification, ACalibrationLeavesItsCovariance) {
  Calibration c;
  c.estimated = {coefficient_index("accel.offset.x"), coefficient_index("gyro.offset.z")};
  c.covariance = Eigen::Matrix2d{{4e-8, 1e-10}, {1e-10, 1e-12}};
  c.model.accel.offset.x() = 0.3;
  ErrorSpecification s;
  s.calibration = "calibration.json";
  s.gyro.N = 1e-6;
  const ErrorSources out = error_sources(s, &c);
  EXPECT_EQ(out.model.accel.offset.x(), 0.3);
  EXPECT_EQ(out.coefficients, c.estimated);
  EXPECT_EQ(out.covariance, c.covariance);
  EXPECT_EQ(out.gyro_noise.N, 1e-6);
}

TEST(ErrorSpecification, RefusesWhatContradictsItself) {
  ErrorSpecification both;
  both.grade = "navigation";
  both.system = "LTN-90";
  EXPECT_THROW(error_sources(both), Error);
  ErrorSpecification twice;
  twice.gyro.misalignment = twice.gyro.nonorthogonality = Spread{1, false};
  EXPECT_THROW(error_sources(twice), Error);
  ErrorSpecification beside;
  beside.calibration = "c.json";
  beside.gyro.bias = Spread{1, false};
  const Calibration c;
  EXPECT_THROW(error_sources(beside, &c), Error);
  ErrorSpecification unknown;
  unknown.grade = "perfect";
  EXPECT_THROW(error_sources(unknown), Error);
  ErrorSpecification given;
  given.accel.g_sensitivity = Spread{1, false};
  EXPECT_THROW(error_sources(given), Error);
}

}  // namespace
}  // namespace imulab
