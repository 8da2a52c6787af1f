#include "imulab/analysis/motion_information.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/recording/turn.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using L = HybridLayout;

/// Attitude of the body and its rate against n, over time.
struct Attitude {
  Matrix3d C_nb;
  Vector3d rate_n;
};
using Course = std::function<Attitude(double)>;

/// Attitude error and velocity after a block, from the states before it: rows and columns of the filter's transition. By midpoints of short steps.
MatrixXd transition(const InformationModel& m, const Course& course, double begin, double end) {
  const auto steps = static_cast<int>(std::ceil((end - begin) / 0.05));
  const double h = (end - begin) / steps, g = m.site.gravity;
  const Vector3d earth = earth_rate_enu(m.site.latitude), up = Vector3d::UnitZ();
  const Matrix3d across = g * skew<double>(up);  // [f_n x]
  const HybridLayout& layout = m.layout;
  std::array<Matrix3d, 7> turned, moved;  // int C b and int f_n x int C b, of b = 1, w, f
  turned.fill(Matrix3d::Zero());
  moved.fill(Matrix3d::Zero());
  for (int k = 0; k < steps; ++k) {
    const Attitude a = course(begin + (k + 0.5) * h);
    const Vector3d w = a.C_nb.transpose() * (a.rate_n + earth), f = g * a.C_nb.row(2).transpose();
    const std::array<double, 7> basis{1, w.x(), w.y(), w.z(), f.x(), f.y(), f.z()};
    for (std::size_t b = 0; b < basis.size(); ++b) {
      moved[b] += h * across * (turned[b] + 0.5 * h * basis[b] * a.C_nb);
      turned[b] += h * basis[b] * a.C_nb;
    }
  }
  MatrixXd t = MatrixXd::Zero(6, layout.size());  // rows: attitude, velocity
  const double T = end - begin;
  t.block<3, 3>(0, layout.attitude()) = Matrix3d::Identity() - T * skew<double>(earth);
  t.block<3, 3>(3, layout.attitude()) = T * across;
  const auto gyro = [&](Index column, std::size_t basis, Index axis) {
    t.block<3, 1>(0, column) = -turned[basis].col(axis);
    t.block<3, 1>(3, column) = -moved[basis].col(axis);
  };
  Index lower = L::accel_matrix;
  for (Index r = 0; r < 3; ++r) {
    gyro(L::gyro_offset + r, 0, r);
    t.block<3, 1>(3, L::accel_offset + r) = turned[0].col(r);
    for (Index c = 0; c < 3; ++c) {
      gyro(L::gyro_matrix + 3 * r + c, static_cast<std::size_t>(1 + c), r);
      if (layout.g_sensitivity >= 0) gyro(layout.g_sensitivity + 3 * r + c, static_cast<std::size_t>(4 + c), r);
      if (c <= r) t.block<3, 1>(3, lower++) = turned[static_cast<std::size_t>(4 + c)].col(r);
    }
  }
  t(5, L::gravity) = g * T;
  if (layout.latitude >= 0) {
    const Vector3d by_latitude(0, -earth_rate * std::sin(m.site.latitude), earth_rate * std::cos(m.site.latitude));
    t.block<3, 1>(0, layout.latitude) = T * by_latitude;
    t.block<3, 1>(3, layout.latitude) = 0.5 * T * T * across * by_latitude;
  }
  return t;
}

/// The residuals (phi1 - what the states before make of it, 0 - velocity) are white noise's: of the attitude T N^2, and what it moves.
MotionInformation block_information(const InformationModel& m, const Course& course, double begin, double end) {
  const Index n = m.size();
  const MatrixXd t = transition(m, course, begin, end);
  MatrixXd residual(6, n + 6);
  residual.leftCols(n) = -t(Eigen::all, m.constants);
  residual.middleCols<3>(n) = -t.middleCols<3>(m.layout.attitude());
  residual.rightCols<3>().setZero();
  residual.block<3, 3>(0, n + 3).setIdentity();

  const Matrix3d C = course(0.5 * (begin + end)).C_nb, across = m.site.gravity * skew<double>(Vector3d(Vector3d::UnitZ()));
  const Matrix3d gyro = C * m.noise.gyro.cwiseAbs2().asDiagonal() * C.transpose(), accel = C * m.noise.accel.cwiseAbs2().asDiagonal() * C.transpose();
  const double T = end - begin;
  Eigen::Matrix<double, 6, 6> q;
  q << T * gyro, (T * T / 2) * gyro * across.transpose(), (T * T / 2) * across * gyro,
      T * accel + (T * T * T / 3) * across * gyro * across.transpose();
  const MatrixXd white = q.llt().matrixL().solve(residual);
  return white.transpose() * white;
}

/// Without three of the unknowns, which begin at `at`, whatever they are.
MatrixXd without(const MatrixXd& information, Index at) {
  const Index rest = information.rows() - at - 3;
  MatrixXd across(information.rows() - 3, 3), out(information.rows() - 3, information.rows() - 3);
  across << information.block(0, at, at, 3), information.block(at + 3, at, rest, 3);
  out << information.topLeftCorner(at, at), information.topRightCorner(at, rest), information.bottomLeftCorner(rest, at),
      information.bottomRightCorner(rest, rest);
  const Matrix3d inverse = information.block<3, 3>(at, at).inverse();
  out.noalias() -= across * (inverse * across.transpose());
  return out;
}

}  // namespace

InformationModel information_model(const HybridPlan& plan, const HybridLayout& layout, const VectorXd& prior) {
  InformationModel m{plan.site, plan.noise, layout, {}, plan.observe_motion};
  for (Index s = 0; s < layout.constants; ++s)
    if (prior[s] > 0 && (s < L::start || s >= L::start + 3)) m.constants.push_back(s);
  return m;
}

MotionInformation rest_information(const InformationModel& model, const Matrix3d& C_nb, int seconds) {
  MotionInformation doubled = block_information(
                        model,
                        [&](double) {
                          return Attitude{C_nb, Vector3d::Zero()};
                        },
                        0, 1),
                    out;
  for (int left = seconds; left > 0; left /= 2) {
    if (left % 2 == 1) out = out.size() == 0 ? doubled : joined(out, doubled);
    if (left > 1) doubled = joined(doubled, doubled);
  }
  return out;
}

MotionInformation turn_information(const InformationModel& model, const Matrix3d& C_nb, const Turn& turn) {
  const double way = std::abs(turn.angle), duration = turn_duration(way, turn.rate, turn.acceleration);
  const double ramp = std::min(turn.rate / turn.acceleration, std::sqrt(way / turn.acceleration)), top = ramp * turn.acceleration;
  const auto course = [&](double t) {
    const double from_end = duration - t;
    double angle = way, rate = 0;
    if (t <= 0)
      angle = 0;
    else if (t < ramp)
      angle = 0.5 * turn.acceleration * t * t, rate = turn.acceleration * t;
    else if (from_end >= ramp)
      angle = top * (t - 0.5 * ramp), rate = top;
    else if (from_end > 0)
      angle = way - 0.5 * turn.acceleration * from_end * from_end, rate = turn.acceleration * from_end;
    const double sign = turn.angle < 0 ? -1 : 1;
    return Attitude{rotation_about(turn.axis, sign * angle) * C_nb, sign * rate * turn.axis};
  };
  if (!model.observe_motion) return block_information(model, course, -unseen_before, duration + unseen_after);
  const auto blocks = std::max(1, static_cast<int>(std::lround(duration / 0.2)));
  MotionInformation out;
  for (int k = 0; k < blocks; ++k) {
    const MotionInformation next = block_information(model, course, k * duration / blocks, (k + 1) * duration / blocks);
    out = k == 0 ? next : joined(out, next);
  }
  return out;
}

MotionInformation joined(const MotionInformation& first, const MotionInformation& second) {
  const Index n = first.rows() - 6;
  MatrixXd both = MatrixXd::Zero(n + 9, n + 9);
  both.topLeftCorner(n + 6, n + 6) = first;
  both.topLeftCorner(n, n) += second.topLeftCorner(n, n);
  both.topRightCorner(n, 6) += second.topRightCorner(n, 6);
  both.bottomLeftCorner(6, n) += second.bottomLeftCorner(6, n);
  both.bottomRightCorner<6, 6>() += second.bottomRightCorner<6, 6>();
  return without(both, n + 3);
}

Knowledge unknown(const InformationModel& model, const VectorXd& prior) {
  const Index n = model.size();
  VectorXd sigma(n + 3);
  sigma.head(n) = prior(model.constants);
  sigma.tail<3>() << 3 * unit::deg, 3 * unit::deg, 90 * unit::deg;  // an alignment's
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

Knowledge known(const InformationModel& model, const HybridPrediction& prediction) {
  std::vector<Index> states = model.constants;
  for (Index i = 0; i < 3; ++i) states.push_back(model.layout.attitude() + i);
  const MatrixXd covariance = prediction.covariance(states, states);
  const VectorXd unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = unit.asDiagonal() * covariance * unit.asDiagonal();
  return unit.asDiagonal() * correlation.inverse() * unit.asDiagonal();
}

Knowledge after(const Knowledge& before, const MotionInformation& motion) {
  const Index n = before.rows() - 3;
  MatrixXd both = motion;
  both.topLeftCorner(n + 3, n + 3) += before;
  return without(both, n);
}

VectorXd sigma_of(const Knowledge& knowledge) {
  const Index n = knowledge.rows() - 3;
  const Eigen::LLT<MatrixXd> factor(knowledge);
  MatrixXd inverse = MatrixXd::Identity(knowledge.rows(), knowledge.rows());
  factor.matrixL().solveInPlace(inverse);
  return inverse.colwise().norm().transpose().head(n);
}

}  // namespace imulab
