// Zhang 2010, table 1 (docs/evidence/papers/zhang2010.md): compares the printed errors of a simulated calibration with their predicted distribution.
#include "imulab/coefficient.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/procedure.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::turntable {
namespace {

/// Section 3.1: the white noise is that of a position's one-minute mean. The constant of a run is removed from the printed biases below.
Plan plan_of_table_1() {
  TableProcedureOptions options;
  options.latitude = 28 * unit::deg;
  Session procedure = zhang_24_procedure(options);
  RigDeclaration& rig = procedure.rigs.front();
  rig.angle.value = rig.orthogonality.value = 2 * unit::arcsec;
  rig.zero.value = 0;
  procedure.imu.gyro_noise_density = 0.005 * unit::deg_per_h * std::sqrt(60);
  procedure.imu.accel_noise_density = 20 * unit::ug * std::sqrt(60);
  Plan plan = plan_of(procedure);
  plan = classical(plan);
  return plan;
}

TEST(Zhang2010, ThePrintedErrorsOfTable1AreOneDrawOfOurs) {
  const Prediction prediction = predict(plan_of_table_1());
  const auto mean_square = [&](const char* selector) {
    double sum = 0;
    const std::vector<CoefficientIndex> indices = select_coefficients(selector);
    for (const CoefficientIndex index : indices) {
      const auto row = std::find(prediction.coefficients.begin(), prediction.coefficients.end(), index) - prediction.coefficients.begin();
      sum += std::pow(prediction.sigma[row], 2) / static_cast<double>(indices.size());
    }
    return sum;
  };
  struct Group {
    const char* selector;
    std::vector<double> printed;  ///< relative to the scale (1e-8 rad and 1e-6 m/s a pulse), or SI
  };
  const double run = 0.01, run_accel = 5e-5 * unit::g;
  for (const Group& group : {
           Group{"gyro.matrix.diagonal", {6.52e-8, 1.14e-7, 1.66e-7}},
           Group{"gyro.matrix.off_diagonal", {1.93e-5, 9.76e-6, 2.65e-5, 9.72e-6, 9.64e-6, 2.73e-5}},
           Group{"gyro.offset", {(1.1e-2 - run) * unit::deg_per_h, (9.77e-3 - run) * unit::deg_per_h, (9.25e-3 - run) * unit::deg_per_h}},
           Group{"accel.matrix.diagonal", {2.49e-6, 2.65e-6, 3.95e-6}},
           Group{"accel.matrix.off_diagonal", {4.55e-6, 9.75e-6, 1.89e-5, 2.36e-6, 3.67e-6, 6.58e-6}},
           Group{"accel.offset", {5.89e-4 - run_accel, 4.63e-4 - run_accel, 5.01e-4 - run_accel}},
       }) {
    double chi2 = 0;
    for (const double error : group.printed) chi2 += error * error / mean_square(group.selector);
    const auto degrees = static_cast<double>(group.printed.size());
    EXPECT_GT(chi2, chi_square_quantile(0.0005, degrees)) << group.selector;  // 99.9 %
    EXPECT_LT(chi2, chi_square_quantile(0.9995, degrees)) << group.selector;
  }
}

/// docs/evidence/papers/zhang2010.md: the error of a turn's angle is its end error minus its start error, shared by the turns forward and back.
TEST(Zhang2010, AnglesGiveAGyroScaleErrorOfRootSix) {
  const Prediction p = predict(plan_of_table_1());
  const auto row = std::find(p.coefficients.begin(), p.coefficients.end(), coefficient_index("gyro.matrix.xx")) - p.coefficients.begin();
  const auto angle = std::find(p.sources.begin(), p.sources.end(), "angle") - p.sources.begin();
  const double expected = std::sqrt(6) * 2 * unit::arcsec / (4 * std::numbers::pi * 5);
  EXPECT_NEAR(std::sqrt(p.variance(row, angle)) / expected, 1, 1e-3);  // Earth's rate in a turn is 6e-4 of a lever
}

}  // namespace
}  // namespace imulab::turntable
