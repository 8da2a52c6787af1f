// Simulated recordings on a turntable whose errors are drawn, and their Fisher information, derived independently of the estimator: readings with
// white noise alone as a function of the coefficients and of every error of the table, which are unknowns with a prior; derivatives by differences;
// the table's errors eliminated; and the second order of what remains of them.
#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/procedure.hpp"
#include "imulab/rig/table_readings.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/calibration_input.hpp"
#include <stdexcept>

namespace imulab::acceptance {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

SensorModel with_coefficients(SensorModel model, const std::vector<CoefficientIndex>& indices, const VectorXd& values) {
  for (std::size_t i = 0; i < indices.size(); ++i) set_coefficient(model, indices[i], values[static_cast<Index>(i)]);
  return model;
}

}  // namespace

MatrixXd turntable_information(const TableMotion& motion, const SensorModel& truth, const turntable::RawNoise& noise,
                               const std::vector<CoefficientIndex>& indices) {
  const auto m = static_cast<Index>(indices.size()), k = static_cast<Index>(motion.sources().size());
  const double step = 1e-5;
  VectorXd at(m + k);
  for (Index i = 0; i < m; ++i) at[i] = coefficient_value(truth, indices[static_cast<std::size_t>(i)]);
  at.tail(k) = motion.nominal();
  const auto predicted = [&](const VectorXd& x) { return readings(motion, with_coefficients(truth, indices, x.head(m)), motion.truth(x.tail(k))); };
  MatrixXd jacobian(motion.rows(), m + k);
  for (Index c = 0; c < m + k; ++c) {
    VectorXd plus = at, minus = at;
    plus[c] += step;
    minus[c] -= step;
    jacobian.col(c) = (predicted(plus) - predicted(minus)) / (2 * step);
  }
  jacobian.rightCols(k) *= motion.sigma().asDiagonal();  // in units of each one's sigma; those that are known exactly vanish
  const MatrixXd white = Cholesky(noise_covariance(motion, noise.accel, noise.gyro)).solve_lower(jacobian);
  const MatrixXd information = white.transpose() * white;
  const MatrixXd cross = information.topRightCorner(m, k);
  const MatrixXd first_order =
      information.topLeftCorner(m, m) -
      cross * solve_semidefinite(information.bottomRightCorner(k, k) + MatrixXd::Identity(k, k), MatrixXd(cross.transpose()));
  // The table errors that no reading shows are drawn, and no estimator can avoid their second order.
  turntable::EstimatorOptions settings;
  settings.terms = indices;
  const MatrixXd second_order = turntable::Estimator(motion, truth, noise, settings).second_order(truth, indices).covariance;
  return inverse_of(inverse_of(first_order) + second_order);
}

Run turntable_run(std::uint64_t seed, double table_sigma) {
  TableProcedureOptions options;
  options.rate_hz = 20;  // the noise of a mean and of a sum does not depend on it
  Session session = zhang_24_procedure(options);
  RigDeclaration& rig = session.rigs.front();
  rig.angle.value = rig.orthogonality.value = rig.zero.value = table_sigma;
  const Truth truth = draw_truth(session, seed);
  const RecordingSource& source = session.recordings.front();
  const Recording recording = simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed));
  CalibrationOptions chosen;
  chosen.effects = false;  // none are simulated: the estimates are compared with the bound of the model alone
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(selector)) chosen.terms.push_back(index);
  const Calibration c = turntable::calibrate(input_of(session, recording), chosen).calibration;
  if (c.estimated.size() != chosen.terms.size())
    throw std::runtime_error(fmt::format("seed {}: {} coefficients were found undetermined", seed, c.quality.unobservable.size()));
  const TableMotion motion(observe(recording, session).parts, rig, session.site);
  const turntable::RawNoise noise{turntable::raw_density(truth.accel_noise.N, truth.model.accel.matrix),
                                  turntable::raw_density(truth.gyro_noise.N, truth.model.gyro.matrix)};
  Run result{c.estimated, VectorXd(c.estimated.size()), c.covariance, turntable_information(motion, truth.model, noise, c.estimated)};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    result.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth.model, c.estimated[i]);
  return result;
}

Run arcsecond_table_run(std::uint64_t seed) { return turntable_run(seed, 2 * unit::arcsec); }
Run arcminute_table_run(std::uint64_t seed) { return turntable_run(seed, 60 * unit::arcsec); }

}  // namespace imulab::acceptance
