// A calibration with a fleet's sizes of terms over temperature.
#include "imulab/tasks/calibrate.hpp"

#include "imulab/finding_code.hpp"
#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(CalibrationTask, AFleetsSizesOfTermsOverTemperatureReplaceTheGrades) {
  Session session = warm_up_procedure({.minutes = 4}, 2);
  Truth truth = draw_truth(session, 2);
  truth.model.accel.thermal.col(1) = Vector3d(1, -2, 1) * 1e-2;
  truth.model.accel.temperature = ThermalReading{.reference = 10, .range = {-20, 30}};
  const Recording recording = simulate_recording(session, session.recordings.front(), truth, 2);
  session.steps.clear();
  const SessionRecordings data = given_recordings(session, {recording});
  FleetPrior prior{.fleet = "fleet.db",
                   .units = 40,
                   .accel_unit = "m/s^2",
                   .gyro_unit = "rad/s",
                   .coefficients = select_each({"accel.offset"}),
                   .mean = Eigen::VectorXd::Zero(3),
                   .covariance = Eigen::MatrixXd::Identity(3, 3)};
  CalibrationTask task{.method = "handheld", .prior = prior};
  const auto u = [&](const CalibrationResult& r) {
    return standard_uncertainty(r.calibration, coefficient_index("accel.matrix_thermal1.xx")).value();
  };
  const CalibrationResult before = calibrate(data, task);
  task.prior->effect_sigmas = {{"accel.matrix_thermal", 50 * unit::ppm}, {"gyro.matrix_thermal", 50 * unit::ppm}, {"accel.thermal", 2e-2}};
  const CalibrationResult with = calibrate(data, task);
  EXPECT_LT(u(with), 0.8 * u(before));
  EXPECT_TRUE(with.calibration.quality.findings.has(Code::prior_used));
  task.prior->effect_sigmas["accel.thermal"] = 1e-4;  // this unit has up to 200 times as much
  const CalibrationResult beyond = calibrate(data, task);
  EXPECT_NEAR(u(beyond), u(before), 1e-3 * u(before)) << "which took the prior of the offsets";
  EXPECT_TRUE(beyond.calibration.quality.findings.has(Code::outlier_of_fleet));
  EXPECT_FALSE(beyond.calibration.quality.findings.has(Code::prior_used));
}

}  // namespace
}  // namespace imulab
