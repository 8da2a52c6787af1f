// Simulated sessions of the hybrid method, and their Fisher information, derived independently of the filter: the attitude at the end of every fifth
// of a second is an unknown of its own, tied to its neighbors by the gyros' increments; the accelerometers' increments are gravity's in that
// attitude, since the velocity is zero at every end. Derivatives by the coefficients are those of the raw readings; attitudes are eliminated one
// after the other.
#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/hybrid_session.hpp"
#include <stdexcept>

namespace imulab::acceptance {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A recording without noise, compensated by the truth: the exact inputs of the sensors.
struct Inputs {
  const Recording& recording;
  const SensorModel& truth;
  Vector3d raw(const Columns3& triad, std::size_t i) const { return {triad[0][i], triad[1][i], triad[2][i]}; }
  Motion operator[](std::size_t i) const {
    RawSample sample;
    sample.accel = raw(recording.accel, i);
    sample.gyro = raw(recording.gyro, i);
    return compensate(truth, sample);
  }
};

/// Axes of a level frame whose north is that of the Earth's rate.
Matrix3d attitude_at_rest(const Motion& motion) {
  const Vector3d up = motion.force.normalized(), east = motion.rate.cross(up).normalized();
  Matrix3d C_nb;
  C_nb << east.transpose(), up.cross(east).transpose(), up.transpose();
  return C_nb;
}

/// Derivatives of the increments over a block: of velocity in n by the accelerometers' coefficients, of rotation in the block's first axes by the
/// gyros'.
MatrixXd increment_derivatives(const std::vector<CoefficientIndex>& indices, const Inputs& inputs, std::size_t begin, std::size_t end, Matrix3d& C_nb,
                               const Vector3d& earth_rate_n) {
  const double dt = inputs.recording.interval_s;
  const Matrix3d C_start = C_nb;
  MatrixXd derivatives = MatrixXd::Zero(6, static_cast<Index>(indices.size()));
  for (std::size_t i = begin; i < end; ++i) {
    const Vector3d turn = inputs[i].rate * dt;
    const Matrix3d middle = C_nb * rotation_exp(0.5 * turn), to_start = C_start.transpose() * middle;
    for (std::size_t k = 0; k < indices.size(); ++k) {
      const Coefficient& c = coefficient(indices[k]);
      const bool accel = c.triad == Triad::accel;
      const double reading =
          c.term == Term::offset ? 1 : (accel ? inputs.recording.accel : inputs.recording.gyro)[static_cast<std::size_t>(c.column)][i];
      derivatives.block<3, 1>(accel ? 0 : 3, static_cast<Index>(k)) += (reading * dt) * (accel ? middle : to_start).col(c.row);
    }
    C_nb = rotation_exp(-dt * earth_rate_n) * C_nb * rotation_exp(turn);
  }
  return derivatives;
}

MatrixXd hybrid_information(const Recording& exact, const Truth& truth, const Site& site, const std::vector<CoefficientIndex>& indices) {
  const auto m = static_cast<Index>(indices.size()), known = m + 1;  // the coefficients, and g
  const Inputs inputs{exact, truth.model};
  const Vector3d earth = earth_rate_enu(*site.latitude);
  const auto length = static_cast<std::size_t>(std::lround(0.2 / exact.interval_s));
  Matrix3d C_nb = attitude_at_rest(inputs[0]);
  MatrixXd information = MatrixXd::Zero(known + 6, known + 6);  // ..., attitude errors at the block's ends
  information(m, m) = 1 / (site.gravity_sigma() * site.gravity_sigma());
  for (std::size_t begin = 0; begin + length <= exact.size(); begin += length) {
    const double T = static_cast<double>(length) * exact.interval_s;
    const Matrix3d C_start = C_nb;
    MatrixXd jacobian = MatrixXd::Zero(6, known + 6);
    jacobian.leftCols(m) = increment_derivatives(indices, inputs, begin, begin + length, C_nb, earth);
    jacobian(2, m) = -T;
    const Matrix3d push = skew<double>(Vector3d(0, 0, truth.gravity * T));  // exp(phi) g T = g T - [g T x] phi, phi that of the middle
    jacobian.block<3, 3>(0, known) = jacobian.block<3, 3>(0, known + 3) = -0.5 * push;
    jacobian.block<3, 3>(3, known) = C_start.transpose();
    jacobian.block<3, 3>(3, known + 3) = -C_start.transpose() * rotation_exp(T * earth);
    jacobian.topRows<3>() /= truth.accel_noise.N * std::sqrt(T);
    jacobian.bottomRows<3>() /= truth.gyro_noise.N * std::sqrt(T);
    information += jacobian.transpose() * jacobian;
    // The first attitude is eliminated.
    std::vector<Index> rest;
    for (Index i = 0; i < known + 6; ++i)
      if (i < known || i >= known + 3) rest.push_back(i);
    const MatrixXd cross = information(rest, Eigen::seqN(known, 3));
    const MatrixXd left = information(rest, rest) - cross * solve_semidefinite(information.block<3, 3>(known, known), MatrixXd(cross.transpose()));
    information.setZero();
    information.topLeftCorner(known + 3, known + 3) = left;
  }
  const MatrixXd cross = information.block(0, m, m, 4);  // with g and the last attitude
  return information.topLeftCorner(m, m) - cross * solve_semidefinite(information.block<4, 4>(m, m), MatrixXd(cross.transpose()));
}

Run run(std::uint64_t seed, double table_sigma, double rest, double rate_hz) {
  Session session = hybrid_procedure(rest, rate_hz);
  RigDeclaration& rig = session.rigs.front();
  rig.angle.value = rig.orthogonality.value = rig.zero.value = table_sigma;
  const Truth truth = draw_truth(session, seed, hybrid_unit(seed));
  const RecordingSource& source = session.recordings.front();
  const RigErrors errors = draw_rig_errors(session, source, seed);
  const Recording recording = simulate_recording(session, source, truth, seed, errors);
  const Calibration c = hybrid::calibrate(input_of(session, recording), base_terms()).calibration;
  if (c.estimated.size() != 21)
    throw std::runtime_error(fmt::format("seed {}: {} coefficients were found undetermined", seed, c.quality.unobservable.size()));
  Truth quiet = truth;
  quiet.accel_noise.N = quiet.gyro_noise.N = 0;
  const Recording exact = simulate_recording(session, source, quiet, seed, errors);
  Run result{c.estimated, VectorXd(21), c.covariance, hybrid_information(exact, truth, session.site, c.estimated)};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    result.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth.model, c.estimated[i]);
  return result;
}

}  // namespace

Run hybrid_arcsecond_run(std::uint64_t seed) { return run(seed, 2 * unit::arcsec, 60, 100); }
Run hybrid_arcminute_run(std::uint64_t seed) { return run(seed, 60 * unit::arcsec, 60, 100); }
Run hybrid_degree_run(std::uint64_t seed) { return run(seed, 1 * unit::deg, 60, 100); }
Run short_hybrid_run(std::uint64_t seed) { return run(seed, 60 * unit::arcsec, 15, 20); }

}  // namespace imulab::acceptance
