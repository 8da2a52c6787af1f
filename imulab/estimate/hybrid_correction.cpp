#include "imulab/estimate/hybrid_correction.hpp"

#include "imulab/model/coefficient.hpp"

#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using L = HybridLayout;

SensorModel corrected(const SensorModel& model, const VectorXd& x, const HybridLayout& layout) {
  Matrix3d Ma = Matrix3d::Zero(), Mg, Cg = Matrix3d::Zero();
  Index lower = L::accel_matrix;
  for (Index r = 0; r < 3; ++r)
    for (Index c = 0; c < 3; ++c) {
      if (c <= r) Ma(r, c) = x[lower++];
      Mg(r, c) = x[L::gyro_matrix + 3 * r + c];
      if (layout.g_sensitivity >= 0) Cg(r, c) = x[layout.g_sensitivity + 3 * r + c];
    }
  const Vector3d ba = x.segment<3>(L::accel_offset), bg = x.segment<3>(L::gyro_offset);
  const Matrix3d one = Matrix3d::Identity();
  SensorModel out = model;
  out.accel.offset = (one - Ma) * model.accel.offset - ba;
  out.accel.matrix = (one - Ma) * model.accel.matrix;
  // The g-sensitivity is fed with the corrected force.
  out.gyro.offset = (one - Mg) * (model.gyro.offset + model.g_sensitivity * ba) - bg;
  out.gyro.matrix = (one - Mg) * model.gyro.matrix;
  out.g_sensitivity = (one - Mg) * model.g_sensitivity * (one + Ma) - Cg;
  for (Index i = 0; i < 3; ++i) {
    if (layout.lever_arm >= 0) out.lever_arm.row(i) += x.segment<3>(layout.lever_arm + 3 * i).transpose();
    if (layout.quadratic < 0) continue;
    const double q = x[layout.quadratic + i], a0 = model.accel.offset[i], a1 = model.accel.matrix(i, i);  // q (a0 + a1 V)^2
    out.accel.offset[i] -= q * a0 * a0;
    out.accel.matrix(i, i) -= 2 * q * a0 * a1;
    out.accel.quadratic[i] -= q * a1 * a1;
  }
  return out;
}

MatrixXd correction_jacobian(const SensorModel& model, const std::vector<int>& indices, const HybridLayout& layout) {
  constexpr double step = 1e-6;  // the correction is quadratic at most: central differences are exact
  MatrixXd jacobian(static_cast<Index>(indices.size()), layout.constants);
  for (Index s = 0; s < layout.constants; ++s) {
    VectorXd x = VectorXd::Zero(layout.constants);
    x[s] = step;
    const SensorModel plus = corrected(model, x, layout), minus = corrected(model, -x, layout);
    for (std::size_t i = 0; i < indices.size(); ++i)
      jacobian(static_cast<Index>(i), s) = (coefficient_value(plus, indices[i]) - coefficient_value(minus, indices[i])) / (2 * step);
  }
  return jacobian;
}

std::vector<int> corrected_coefficients(const HybridLayout& layout) {
  std::vector<int> out(static_cast<std::size_t>(layout.constants), -1);
  const auto set = [&](Index state, Triad triad, Term term, Index row, Index column) {
    out[static_cast<std::size_t>(state)] = coefficient_index(triad, term, static_cast<int>(row), static_cast<int>(column));
  };
  Index lower = L::accel_matrix;
  for (Index r = 0; r < 3; ++r) {
    set(L::accel_offset + r, Triad::accel, Term::offset, r, r);
    set(L::gyro_offset + r, Triad::gyro, Term::offset, r, r);
    if (layout.quadratic >= 0) set(layout.quadratic + r, Triad::accel, Term::quadratic, r, r);
    for (Index c = 0; c < 3; ++c) {
      if (c <= r) set(lower++, Triad::accel, Term::matrix, r, c);
      set(L::gyro_matrix + 3 * r + c, Triad::gyro, Term::matrix, r, c);
      if (layout.g_sensitivity >= 0) set(layout.g_sensitivity + 3 * r + c, Triad::gyro, Term::g_sensitivity, r, c);
      if (layout.lever_arm >= 0) set(layout.lever_arm + 3 * r + c, Triad::accel, Term::lever_arm, r, c);
    }
  }
  return out;
}

}  // namespace imulab
