// The readings of an IMU on a turntable, raw: six rows for the means of a hold, three for the sums of a turn. Each reading is linear in the columns
// of the forward model and in the table's truth.
#pragma once

#include "imulab/core/random.hpp"
#include "imulab/eigen.hpp"
#include "imulab/grade.hpp"
#include "imulab/rig/table_motion.hpp"
#include "imulab/sensor_model.hpp"

#include <Eigen/SparseCore>

#include <array>
#include <cstdint>

namespace imulab {

/// Without noise. `truth` as TableMotion gives it.
Eigen::VectorXd readings(const TableMotion& motion, const SensorModel& model, const Eigen::VectorXd& truth);

/// d reading / d column of the forward model. Those of nonlinearity are of the size that the readings have with `nominal`.
Eigen::MatrixXd by_forward_columns(const TableMotion& motion, const SensorModel& nominal, const Eigen::VectorXd& truth);
/// Changes of the readings where the truth changes by each of the columns.
Eigen::MatrixXd reading_changes(const TableMotion& motion, const SensorModel& model, const Eigen::MatrixXd& truth_changes);
/// d reading / d bias of each axis: accelerometers, then gyros.
Eigen::MatrixXd by_bias(const TableMotion& motion);
/// d weighted reading / d truth, a row for each of `weights`.
Eigen::MatrixXd by_truth(const TableMotion& motion, const SensorModel& model, const Eigen::MatrixXd& weights);
/// d^2 weighted reading / d (column of the forward model, error of the table and the site).
Eigen::MatrixXd mixed_curvature(const TableMotion& motion, const Eigen::MatrixXd& truth_jacobian, const Eigen::RowVectorXd& weights);

/// Covariance of the readings from white noise with these raw covariance densities, including the samples that a hold and a turn share.
Eigen::MatrixXd noise_covariance(const TableMotion& motion, const Matrix3d& accel_density, const Matrix3d& gyro_density);

/// Readings in whole procedures of an IMU that is ideal but for drawn terms, with drawn errors of the table, biases and noise.
class ReadingsSampler {
 public:
  /// `turn_on`: biases of accelerometers and gyros. `column_sigma`: by column of the forward model; empty: an ideal IMU. `effects`: what one sigma of
  /// each further error does to the readings; empty: none. `motion` outlives the sampler.
  ReadingsSampler(const TableMotion& motion, const std::array<Spread, 2>& turn_on, const Eigen::MatrixXd& noise_covariance, std::uint64_t seed,
                  Eigen::VectorXd column_sigma = {}, Eigen::MatrixXd effects = {});
  /// A procedure each column, from number `begin` on: the same for any split into calls.
  Eigen::MatrixXd draw(std::uint64_t begin, Eigen::Index procedures) const;
  /// Columns of the forward model of these IMUs.
  Eigen::MatrixXd drawn_columns(std::uint64_t begin, Eigen::Index procedures) const;

 private:
  const TableMotion& motion_;
  std::array<Spread, 2> turn_on_;
  Eigen::MatrixXd by_bias_;
  Eigen::SparseMatrix<double> noise_factor_;
  RandomStream table_, noise_, biases_, terms_, of_effects_;
  Eigen::VectorXd column_sigma_;
  Eigen::MatrixXd effects_;
};

}  // namespace imulab
