#include "imulab/rig/table_readings.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/model/forward_model.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <utility>

namespace imulab {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd readings(const TableMotion& motion, const SensorModel& model, const VectorXd& truth) {
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse();
  VectorXd out(motion.rows());
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const Vector3d force = truth.segment<3>(static_cast<Eigen::Index>(6 * k)), rate = truth.segment<3>(static_cast<Eigen::Index>(6 * k + 3));
    if (motion.is_hold(k)) out.segment<3>(motion.row(k)) = accel * (force - model.accel.offset);
    out.segment<3>(motion.gyro_row(k)) = gyro * (rate - model.gyro.offset * motion.gain(k) - model.g_sensitivity * force);
  }
  return out;
}

namespace {

/// The columns of nonlinearity: holds show the accelerometers', turns the gyros', whose rate at rest is too small.
void add_nonlinearity(MatrixXd& x, const TableMotion& motion, const SensorModel& nominal, const VectorXd& truth) {
  const Matrix3d accel = nominal.accel.matrix.inverse(), gyro = nominal.gyro.matrix.inverse();
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const Vector3d force = truth.segment<3>(static_cast<Eigen::Index>(6 * k)), turned = truth.segment<3>(static_cast<Eigen::Index>(6 * k + 3));
    for (const int power : {2, 3}) {
      if (motion.is_hold(k)) {
        const Eigen::Index column = power == 2 ? Forward::accel_quadratic : Forward::accel_cubic;
        const Vector3d size = Vector3d(accel * force).array().pow(power);
        x.block<3, 3>(motion.row(k), column) = -accel * size.asDiagonal();
      } else {
        const Eigen::Index column = power == 2 ? Forward::gyro_quadratic : Forward::gyro_cubic;
        const Vector3d size = Vector3d(gyro * turned / motion.angle(k)).array().pow(power);
        x.block<3, 3>(motion.gyro_row(k), column) = -motion.rate_moment(k, power) * gyro * size.asDiagonal();
      }
    }
  }
}

}  // namespace

MatrixXd by_forward_columns(const TableMotion& motion, const SensorModel& nominal, const VectorXd& truth) {
  MatrixXd x = MatrixXd::Zero(motion.rows(), Forward::all);
  add_nonlinearity(x, motion, nominal, truth);
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const auto force = truth.segment<3>(static_cast<Eigen::Index>(6 * k)).transpose(),
               rate = truth.segment<3>(static_cast<Eigen::Index>(6 * k + 3)).transpose();
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Eigen::Index row = motion.row(k) + i, gyro_row = motion.gyro_row(k) + i;
      if (motion.is_hold(k)) {
        x(row, Forward::accel_offset + i) = 1;
        x.block<1, 3>(row, Forward::accel_matrix + 3 * i) = force;
      } else {
        x(gyro_row, Forward::turning_bias + i) = motion.gain(k);
      }
      x(gyro_row, Forward::gyro_offset + i) = motion.gain(k);
      x.block<1, 3>(gyro_row, Forward::gyro_matrix + 3 * i) = rate;
      x.block<1, 3>(gyro_row, Forward::gyro_force + 3 * i) = -force;
    }
  }
  return x;
}

MatrixXd reading_changes(const TableMotion& motion, const SensorModel& model, const MatrixXd& truth_changes) {
  SensorModel linear = model;
  linear.accel.offset.setZero();
  linear.gyro.offset.setZero();
  MatrixXd out(motion.rows(), truth_changes.cols());
  for (Eigen::Index c = 0; c < out.cols(); ++c) out.col(c) = readings(motion, linear, truth_changes.col(c));
  return out;
}

MatrixXd by_bias(const TableMotion& motion) {
  MatrixXd out = MatrixXd::Zero(motion.rows(), 6);
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    if (motion.is_hold(k)) out.block<3, 3>(motion.row(k), 0).setIdentity();
    out.block<3, 3>(motion.gyro_row(k), 3) = motion.gain(k) * Matrix3d::Identity();
  }
  return out;
}

MatrixXd by_truth(const TableMotion& motion, const SensorModel& model, const MatrixXd& weights) {
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse(), force = gyro * model.g_sensitivity;
  MatrixXd out(weights.rows(), static_cast<Eigen::Index>(6 * motion.parts()));
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const auto of_gyro = weights.middleCols<3>(motion.gyro_row(k));
    auto of_force = out.middleCols<3>(static_cast<Eigen::Index>(6 * k)), of_rate = out.middleCols<3>(static_cast<Eigen::Index>(6 * k + 3));
    of_rate = of_gyro * gyro;
    of_force = -of_gyro * force;
    if (motion.is_hold(k)) of_force += weights.middleCols<3>(motion.row(k)) * accel;
  }
  return out;
}

MatrixXd mixed_curvature(const TableMotion& motion, const MatrixXd& truth_jacobian, const Eigen::RowVectorXd& weights) {
  MatrixXd out = MatrixXd::Zero(Forward::all, truth_jacobian.cols());
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const auto force = truth_jacobian.middleRows<3>(static_cast<Eigen::Index>(6 * k)),
               rate = truth_jacobian.middleRows<3>(static_cast<Eigen::Index>(6 * k + 3));
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (motion.is_hold(k)) out.middleRows<3>(Forward::accel_matrix + 3 * i) += weights[motion.row(k) + i] * force;
      out.middleRows<3>(Forward::gyro_matrix + 3 * i) += weights[motion.gyro_row(k) + i] * rate;
      out.middleRows<3>(Forward::gyro_force + 3 * i) -= weights[motion.gyro_row(k) + i] * force;
    }
  }
  return out;
}

MatrixXd noise_covariance(const TableMotion& motion, const Matrix3d& accel_density, const Matrix3d& gyro_density) {
  MatrixXd out = MatrixXd::Zero(motion.rows(), motion.rows());
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const double duration = motion.end(k) - motion.begin(k);
    const Eigen::Index row = motion.gyro_row(k);
    if (motion.is_hold(k)) {
      out.block<3, 3>(motion.row(k), motion.row(k)) = accel_density / duration;
      out.block<3, 3>(row, row) = gyro_density / duration;
      continue;
    }
    out.block<3, 3>(row, row) = gyro_density * duration;
    for (std::size_t other = 0; other < k; ++other) {  // samples that are in a hold's mean, too, or shared with a turn that follows without a rest
      const double shared = std::min(motion.end(k), motion.end(other)) - std::max(motion.begin(k), motion.begin(other));
      if (shared <= 0) continue;
      const double weight = motion.is_hold(other) ? shared / (motion.end(other) - motion.begin(other)) : shared;
      const Eigen::Index other_row = motion.gyro_row(other);
      out.block<3, 3>(row, other_row) = gyro_density * weight;
      out.block<3, 3>(other_row, row) = out.block<3, 3>(row, other_row).transpose();
    }
  }
  return out;
}

ReadingsSampler::ReadingsSampler(const TableMotion& motion, const std::array<Spread, 2>& turn_on, const MatrixXd& noise_covariance,
                                 std::uint64_t seed, VectorXd column_sigma, MatrixXd effects)
    : motion_(motion),
      turn_on_(turn_on),
      by_bias_(by_bias(motion)),
      noise_factor_(Cholesky(noise_covariance).lower().sparseView()),
      table_(seed, "predict: table errors"),
      noise_(seed, "predict: noise"),
      biases_(seed, "predict: turn-on"),
      terms_(seed, "predict: terms"),
      of_effects_(seed, "predict: effects"),
      column_sigma_(std::move(column_sigma)),
      effects_(std::move(effects)) {}

MatrixXd ReadingsSampler::drawn_columns(std::uint64_t begin, Eigen::Index procedures) const {
  MatrixXd columns = forward({}).replicate(1, procedures);
  if (column_sigma_.size() == 0) return columns;
  MatrixXd drawn(Forward::all, procedures);
  terms_.normals(begin * static_cast<std::uint64_t>(drawn.rows()), {drawn.data(), static_cast<std::size_t>(drawn.size())});
  return columns + column_sigma_.asDiagonal() * drawn;
}

MatrixXd ReadingsSampler::draw(std::uint64_t begin, Eigen::Index procedures) const {
  const auto normals = [&](const RandomStream& stream, Eigen::Index rows) {
    MatrixXd out(rows, procedures);
    stream.normals(begin * static_cast<std::uint64_t>(rows), {out.data(), static_cast<std::size_t>(out.size())});
    return out;
  };
  const VectorXd sigma = motion_.sigma();
  const MatrixXd errors = (sigma.asDiagonal() * normals(table_, sigma.size())).colwise() + motion_.nominal();
  MatrixXd bias = normals(biases_, 6);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    const Spread& spread = turn_on_[axis < 3 ? 0 : 1];
    if (spread.fixed) bias.row(axis).setOnes();
    bias.row(axis) *= spread.value;
  }
  MatrixXd seen = noise_factor_ * normals(noise_, motion_.rows());
  seen.noalias() += by_bias_ * bias;
  if (effects_.size() > 0) seen.noalias() += effects_ * normals(of_effects_, effects_.cols());
  if (column_sigma_.size() == 0) {
    for (Eigen::Index k = 0; k < procedures; ++k) seen.col(k) += readings(motion_, {}, motion_.truth(errors.col(k)));
    return seen;
  }
  const MatrixXd columns = drawn_columns(begin, procedures);
  for (Eigen::Index k = 0; k < procedures; ++k) seen.col(k) += by_forward_columns(motion_, {}, motion_.truth(errors.col(k))) * columns.col(k);
  return seen;
}

}  // namespace imulab
