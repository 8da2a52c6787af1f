// Conformance on a real sensor: the Xsens MTi record of imu_tk (BSD), moved by hand, raw counts, and the factory's calibration of that IMU.
#include "imulab/coefficient.hpp"
#include "imulab/files.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/run_command.hpp"
#include <cmath>

namespace imulab {
namespace {

const std::filesystem::path xsens_folder = std::filesystem::path(IMULAB_SOURCE) / ".." / "shared" / "data" / "imu_tk_xsens";

std::string session_of(const std::filesystem::path& folder) {
  return "format = \"imulab.session/1\"\n"
         "[imu]\n"
         "name = \"Xsens MTi\"\n"
         "[site]\n"
         "gravity_mps2 = 9.80665\n"
         "[[recording]]\n"
         "file = \"" +
         folder.string() +
         "/xsens_gyro.mat\"\n"
         "time = { column = 1, unit = \"s\" }\n"
         "gyro = { columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\n"
         "accel = { file = \"" +
         folder.string() + "/xsens_acc.mat\", columns = [2, 3, 4], output = \"rate\", unit = \"count\" }\n";
}

TEST(Xsens, AgreesWithTheFactory) {
  if (!std::filesystem::exists(xsens_folder / "xsens_acc.mat")) GTEST_SKIP() << "the record is not here: " << xsens_folder;
  const TemporaryFolder folder;
  folder.write("session.toml", session_of(std::filesystem::canonical(xsens_folder)));
  const CommandResult result = run_imulab(folder, "calibrate session.toml --method handheld -o calibration.json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const Calibration c = read_calibration(folder / "calibration.json");

  // The factory's scales are rounded to a count: accelerometers within 0.6 count/(m/s^2); gyros within 0.07 % RMS, what an independent study of this
  // record reached with the g-sensitivity modeled.
  const Vector3d accel = c.model.accel.matrix.diagonal().cwiseInverse(), gyro = c.model.gyro.matrix.diagonal().cwiseInverse();
  EXPECT_LT((accel - Vector3d(415, 413, 415)).cwiseAbs().maxCoeff(), 0.6) << accel.transpose();
  const Vector3d relative = gyro.cwiseQuotient(Vector3d(4778, 4758, 4766)) - Vector3d::Ones();
  EXPECT_LT(std::sqrt(relative.squaredNorm() / 3), 7e-4) << gyro.transpose();
  // The factory's misalignments are rounded to 0.01: the gyros' are compared in the accelerometers' frame, whose own factory figures are no better.
  const Matrix3d gyro_misalignment = gyro.asDiagonal() * c.model.gyro.matrix;
  EXPECT_NEAR(-gyro_misalignment(1, 2), 0.04, 0.012);

  ASSERT_TRUE(c.quality.rotation_residual_deg);
  EXPECT_LE(*c.quality.rotation_residual_deg, 0.17);
  ASSERT_EQ(c.quality.term_tests.size(), 5u);
  EXPECT_EQ(c.quality.term_tests[4].term, "gyro.g_sensitivity");
  EXPECT_TRUE(c.quality.term_tests[4].kept);
  EXPECT_EQ(c.quality.verdict, Verdict::good);
  EXPECT_TRUE(c.quality.unobservable.empty());
}

TEST(Xsens, HalvesOfTheRecordAgreeWithinTheirUncertainties) {
  if (!std::filesystem::exists(xsens_folder / "xsens_acc.mat")) GTEST_SKIP() << "the record is not here: " << xsens_folder;
  // Without a truth, two calibrations of one IMU from different data are the test of the stated uncertainties.
  const TemporaryFolder folder;
  const auto d = std::filesystem::canonical(xsens_folder).string();
  for (const std::string half : {"first", "second"}) {
    for (const std::string triad : {"acc", "gyro"}) {
      const std::string take = half == "first" ? "head -n 25500 " : "tail -n +25501 ";
      ASSERT_EQ(run_shell(folder, take + d + "/xsens_" + triad + ".mat > " + half + "_" + triad + ".txt").exit_code, 0);
    }
    std::string text = session_of(d);
    for (const std::string triad : {"acc", "gyro"})
      text.replace(text.find(d + "/xsens_" + triad + ".mat"), (d + "/xsens_" + triad + ".mat").size(), half + "_" + triad + ".txt");
    folder.write(half + ".toml", text);
    const CommandResult result = run_imulab(folder, "calibrate " + half + ".toml --method handheld -o " + half + ".json");
    ASSERT_EQ(result.exit_code, 0) << result.errors;
  }
  const Calibration a = read_calibration(folder / "first.json"), b = read_calibration(folder / "second.json");
  double squares = 0;
  int count = 0;
  for (const CoefficientIndex index : a.estimated) {
    const auto u = standard_uncertainty(a, index), v = standard_uncertainty(b, index);
    if (!v) continue;
    const double z = (coefficient_value(a.model, index) - coefficient_value(b.model, index)) / std::hypot(*u, *v);
    squares += z * z;
    ++count;
  }
  EXPECT_GE(count, 27);
  // Each variance rests on spreads estimated from some 15 rests: a mean square of 2 would need a chance below 1e-3 even with correlated coefficients.
  EXPECT_LT(squares / count, 2.0);
}

TEST(Xsens, NavigatesAsAMemsUnitDoes) {
  if (!std::filesystem::exists(xsens_folder / "xsens_acc.mat")) GTEST_SKIP() << "the record is not here: " << xsens_folder;
  const TemporaryFolder folder;
  std::string session = session_of(std::filesystem::canonical(xsens_folder));
  session.replace(session.find("[site]\n"), 7, "[site]\nlatitude_deg = 45\nlongitude_deg = 0\nheight_m = 0\n");
  folder.write("session.toml", session);
  ASSERT_EQ(run_imulab(folder, "calibrate session.toml --method handheld -o calibration.json").exit_code, 0);
  const CommandResult blind = run_imulab(folder, "navigate calibration.json session.toml");
  EXPECT_EQ(blind.exit_code, 1);
  EXPECT_NE(blind.errors.find("do not resolve the Earth's rate"), std::string::npos) << blind.errors;
  const CommandResult led = run_imulab(folder, "navigate calibration.json session.toml --heading 0 -o nav.csv");
  ASSERT_EQ(led.exit_code, 0) << led.errors;
  const NavigationState end = read_solution(folder / "nav.csv").states.back();
  const double way = 6.37e6 * std::hypot(end.latitude - 45 * unit::deg, end.longitude * std::cos(45 * unit::deg));
  // The IMU stayed in one place. Gyros known to some 15 deg/h tilt by g w t^3 / 6 = 12 km in 460 s: within a factor of ten either way.
  EXPECT_GT(way, 1.2e3);
  EXPECT_LT(way, 1.2e5);
}

}  // namespace
}  // namespace imulab
