#include "imulab/estimate/static_problem.hpp"

#include "imulab/earth/earth.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <cmath>

namespace imulab {

using Eigen::Index;

StaticProblem::StaticProblem(std::vector<Rest> rests, double gravity, std::optional<double> latitude, const SampleNoise& noise, const Scaling& scaling,
                             const SensorModel& scaled_model, const Prior& prior, std::vector<int> indices)
    : rests_(std::move(rests)), gravity_(gravity), latitude_(latitude), scaling_(scaling), model_(scaled_model), prior_(prior), indices_(std::move(indices)),
      sigma_(prior_.sigmas(indices_, gravity_)) {
  noise_ = {noise.accel.cwiseQuotient(scaling.accel_scale), noise.gyro.cwiseQuotient(scaling.gyro_scale)};
}

Conditions StaticProblem::conditions(const Spreads& spreads) const {
  const Index per_rest = latitude_ ? 3 : 1;
  const Index rows = per_rest * static_cast<Index>(rests_.size()) + static_cast<Index>(indices_.size());
  Conditions c;
  c.value.setZero(rows);
  c.jacobian.setZero(rows, static_cast<Index>(indices_.size()));
  c.spread_gain.setOnes(rows);
  c.kind.assign(static_cast<std::size_t>(rows), ConditionKind::gravity);
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const Rest& rest = rests_[k];
    const Index row = per_rest * static_cast<Index>(k);
    const double n = static_cast<double>(rest.range.size());
    const Vector3d va = (rest.accel - scaling_.accel_center).cwiseQuotient(scaling_.accel_scale);
    const Vector3d vg = (rest.gyro - scaling_.gyro_center).cwiseQuotient(scaling_.gyro_scale);
    const Vector3d force = model_.accel.offset + model_.accel.matrix * va, up = force.normalized();
    const Matrix3d force_covariance = Matrix3d(model_.accel.matrix * noise_.accel.cwiseAbs2().asDiagonal() * model_.accel.matrix.transpose()) / n +
                                      spreads[0] * spreads[0] * Matrix3d::Identity();
    // How the rest's rows feel an error of its force and of its rate.
    Eigen::MatrixXd on_force = Eigen::MatrixXd::Zero(per_rest, 3), on_rate = Eigen::MatrixXd::Zero(per_rest, 3);
    on_force.row(0) = up.transpose();
    c.value[row] = force.norm() - gravity_;
    Conditions::Block block{row, per_rest, {}, {}};
    Matrix3d rate_covariance = Matrix3d::Zero();
    if (latitude_) {
      const Vector3d rate = model_.gyro.offset + model_.gyro.matrix * vg + model_.g_sensitivity * force;
      const double vertical = up.dot(rate);
      const Vector3d across = rate - vertical * up, north = across.normalized();
      const Matrix3d turn_up = (Matrix3d::Identity() - up * up.transpose()) / force.norm();
      rate_covariance = Matrix3d(model_.gyro.matrix * noise_.gyro.cwiseAbs2().asDiagonal() * model_.gyro.matrix.transpose()) / n +
                        spreads[1] * spreads[1] * Matrix3d::Identity();
      const Vector3d east = north.cross(up);
      on_rate.row(1) = up.transpose();
      on_force.row(1) = rate.transpose() * turn_up;
      on_rate.row(2) = north.transpose();
      on_force.row(2) = -vertical * north.transpose() * turn_up;
      c.value[row + 1] = vertical - earth_rate * std::sin(*latitude_);
      // Noise across north lengthens the horizontal part by var / (2 |w|) on average.
      c.value[row + 2] = across.norm() - east.dot(rate_covariance * east) / (2 * across.norm()) - earth_rate * std::cos(*latitude_);
      c.kind[static_cast<std::size_t>(row + 1)] = c.kind[static_cast<std::size_t>(row + 2)] = ConditionKind::gyro_rest;
    }
    for (std::size_t i = 0; i < indices_.size(); ++i) {
      const Coefficient& coefficient = coefficient_table()[static_cast<std::size_t>(indices_[i])];
      const bool accel = coefficient.triad == Triad::accel;
      const double basis = coefficient.term == Term::offset ? 1.0 : accel ? va[coefficient.column] : vg[coefficient.column];
      c.jacobian.col(static_cast<Index>(i)).segment(row, per_rest) = basis * (accel ? on_force : on_rate).col(coefficient.row);
    }
    block.covariance = on_force * force_covariance * on_force.transpose() + on_rate * rate_covariance * on_rate.transpose();
    c.blocks.push_back(std::move(block));
  }
  add_prior_rows(c, per_rest * static_cast<Index>(rests_.size()), prior_, sigma_, model_, indices_);
  c.variance.resize(rows);
  for (const Conditions::Block& block : c.blocks) c.variance.segment(block.first, block.size) = block.covariance.diagonal();
  return c;
}

void StaticProblem::pin(const std::vector<char>& determined) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    if (!determined[i]) sigma_[static_cast<Index>(i)] *= 1e-6;
}

void StaticProblem::correct(const Eigen::VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
}

std::vector<Suspect> StaticProblem::suspects(const Conditions& conditions) const {
  std::vector<Suspect> all;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    Suspect suspect{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}};
    for (Index r = 0; r < conditions.blocks[k].size; ++r) suspect.rows.push_back(conditions.blocks[k].first + r);
    all.push_back(std::move(suspect));
  }
  return all;
}

}  // namespace imulab
