#include "imulab/estimate/whole_unit_problem.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/rig/machine.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <ceres/jet.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Rows = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// The coefficients that the points can say something of.
std::vector<int> candidates(const WholeUnitPoints& points) {
  std::vector<int> indices;
  for (int k = 0; k < coefficient_count; ++k) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(k)];
    if (c.term == Term::lever_arm || (c.term == Term::thermal && !points.thermal[c.triad == Triad::accel ? 0 : 1])) continue;
    indices.push_back(k);
  }
  return indices;
}

bool same_source(const RigErrorSource& a, const RigErrorSource& b) { return a.kind == b.kind && a.axis == b.axis && a.place == b.place; }

}  // namespace

std::string CommonError::name() const {
  return rig.empty() && source.kind == RigErrorKind::zero ? "gravity" : (rig.empty() ? "" : rig + ": ") + source.name();
}

SquareSum& SquareSum::operator+=(const SquareSum& other) {
  if (N.size() == 0) return *this = other;
  N += other.N, g += other.g, c += other.c, rows += other.rows;
  return *this;
}

Solution solve(const SquareSum& sum, const Knowledge& known) {
  std::vector<Index> loose;
  for (Index i = 0; i < sum.g.size(); ++i)
    if (known.sigma[i] > 0) loose.push_back(i);
  Solution s;
  s.x = (known.sigma.array() > 0).select(0, known.offset);
  const auto n = static_cast<Index>(loose.size());
  VectorXd weight(n), pull(n);
  for (Index k = 0; k < n; ++k) {
    const Index i = loose[static_cast<std::size_t>(k)];
    weight[k] = std::isinf(known.sigma[i]) ? 0 : 1 / (known.sigma[i] * known.sigma[i]);
    pull[k] = weight[k] * (std::isinf(known.sigma[i]) ? 0 : known.offset[i]);
  }
  const VectorXd gradient = sum.g + sum.N * s.x;  // with what is held in its place
  MatrixXd normal = sum.N(loose, loose);
  normal.diagonal() += weight;
  const VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::LLT<MatrixXd> factor(scaled);
  const MatrixXd inverse = factor.solve(MatrixXd::Identity(n, n));
  // Scaled to unit diagonal, rounding alone makes pivots of 1e-14.
  if (factor.info() != Eigen::Success || !inverse.allFinite() || inverse.diagonal().maxCoeff() > 1e13)
    throw Unsupported("the points do not determine what is asked: the normal equations cannot be solved");
  const MatrixXd p = scale.asDiagonal() * inverse * scale.asDiagonal();
  s.condition = std::sqrt(scaled.norm() * inverse.norm());
  s.x(loose) = p * (pull - VectorXd(gradient(loose)));
  s.covariance = MatrixXd::Zero(sum.g.size(), sum.g.size());
  s.covariance(loose, loose) = p;
  s.chi2 = sum.at(s.x);
  s.degrees_of_freedom = sum.rows - static_cast<double>(n) + p.diagonal().dot(weight);
  return s;
}

WholeUnitProblem::WholeUnitProblem(WholeUnitPoints points, const Session& session, const SensorModel& start, const Vector6d& center)
    : points_(std::move(points)),
      session_(&session),
      model_(start),
      center_(center),
      coefficients_(candidates(points_)),
      gravity_(session.site.gravity()) {
  rate_ie_n_ = session.site.latitude ? earth_rate_enu(*session.site.latitude) : Vector3d::Zero();
  common_.push_back({"", {}, session.site.gravity_sigma(), 0});  // "gravity"
  for (const RecordingSource& source : session.recordings) {
    const RigDeclaration& rig = *rig_of(session, source);
    std::vector<std::size_t>& acting = acting_.emplace_back();
    for (const RigErrorSource& error : rig_error_sources(session, source)) {
      const auto known =
          std::find_if(common_.begin() + 1, common_.end(), [&](const CommonError& c) { return c.rig == rig.name && same_source(c.source, error); });
      acting.push_back(static_cast<std::size_t>(known - common_.begin()));
      if (known == common_.end()) common_.push_back({rig.name, error, error.sigma, 0});
    }
  }
  measure_noise();
}

void WholeUnitProblem::measure_noise() {
  noise_.setZero();
  for (const WholeUnitPoint& point : points_.points) {
    const Matrix6 slope = compensation_derivatives(model_, sample(point)).raw;
    noise_ += slope.cwiseAbs2() * point.variance / static_cast<double>(points_.points.size());
  }
  for (const std::size_t triad : {0, 1}) {
    const auto& density = triad == 0 ? session_->imu.accel_noise_density : session_->imu.gyro_noise_density;
    if (!density || !(*density > 0) || points_.points.empty()) continue;
    noise_.segment<3>(static_cast<Index>(3 * triad)).setConstant(*density * *density / points_.interval_s);
  }
  noise_ = noise_.cwiseProduct(points_.correlation);
}

std::array<double, 2> WholeUnitProblem::full_scale() const {
  std::array<double, 2> full{};
  for (const WholeUnitPoint& point : points_.points) {
    const Motion m = motion(point);
    full[0] = std::max(full[0], m.force.cwiseAbs().maxCoeff());
    full[1] = std::max(full[1], m.rate.cwiseAbs().maxCoeff());
  }
  return full;
}

RigKind WholeUnitProblem::kind(const WholeUnitPoint& point) const { return rig_of(*session_, session_->recordings[point.recording])->kind; }

RawSample WholeUnitProblem::sample(const WholeUnitPoint& point) const {
  RawSample raw{point.raw.head<3>() - center_.head<3>(), point.raw.tail<3>() - center_.tail<3>()};
  if (points_.thermal[0]) raw.accel_tau = point.temperature.head<3>().array() - model_.accel.temperature->reference;
  if (points_.thermal[1]) raw.gyro_tau = point.temperature.tail<3>().array() - model_.gyro.temperature->reference;
  return raw;
}

Motion WholeUnitProblem::motion(const WholeUnitPoint& point, Rows* by_common) const {
  using T = ceres::Jet<double, 8>;  // gravity, tilt, rate, mount, radius
  std::array<std::size_t, 8> index{};
  std::array<T, 8> value;
  for (int k = 0; k < 8; ++k) value[static_cast<std::size_t>(k)] = T(0, k);
  value[0].a = common_[0].value;
  const Mount mount = mount_of(point.step);
  for (const std::size_t i : acting_[point.recording]) {
    const RigErrorSource& source = common_[i].source;
    std::size_t slot = 0;
    if (source.kind == RigErrorKind::tilt) slot = 1 + source.axis;
    if (source.kind == RigErrorKind::rate) slot = 3;
    if (source.kind == RigErrorKind::mount && source.place == mount) slot = 4 + source.axis;
    if (source.kind == RigErrorKind::radius && source.place == mount) slot = 7;
    if (slot == 0) continue;
    index[slot] = i;
    value[slot].a = source.known + common_[i].value;
  }
  MachineErrors<T> errors;
  errors.tilt << value[1], value[2];
  errors.rate = value[3];
  errors.mount << value[4], value[5], value[6];
  errors.radius = value[7];
  const SteadyMotion<T> m = steady_motion<T>(point.step, errors, {gravity_ + value[0], rate_ie_n_});
  Motion motion;
  if (by_common) *by_common = Rows::Zero(6, static_cast<Index>(common_.size()));
  for (int i = 0; i < 3; ++i) {
    motion.force[i] = m.force[i].a, motion.rate[i] = m.rate[i].a;
    for (int k = 0; by_common && k < 8; ++k) {
      if (k > 0 && index[static_cast<std::size_t>(k)] == 0) continue;
      (*by_common)(i, static_cast<Index>(index[static_cast<std::size_t>(k)])) = m.force[i].v[k];
      (*by_common)(3 + i, static_cast<Index>(index[static_cast<std::size_t>(k)])) = m.rate[i].v[k];
    }
  }
  return motion;
}

PointEquations WholeUnitProblem::equations(const WholeUnitPoint& point) const {
  const CompensationDerivatives d = compensation_derivatives(model_, sample(point));
  Rows by_common;
  const Motion truth = motion(point, &by_common);
  PointEquations out;
  out.residual << d.motion.force - truth.force, d.motion.rate - truth.rate;

  const double n = static_cast<double>(point.samples);
  Matrix6 noise = d.temperature * points_.thermal_variance.asDiagonal() * d.temperature.transpose() / n;
  noise.diagonal() += noise_ / n;
  // A coarsely quantised or dead channel shows none; a part in 1e8 of the full range keeps the weights finite.
  noise.diagonal() += Vector6d::Constant(1e-16).cwiseProduct((Vector6d() << Vector3d::Constant(gravity_ * gravity_), Vector3d::Ones()).finished());
  if (const double kept = horizontal_remainder(point.step); kept > 0) {
    const double tilt = rig_of(*session_, session_->recordings[point.recording])->zero.value;
    const Vector3d up = mount_attitude(mount_of(point.step)).row(2);
    const Matrix3d horizontal = Matrix3d::Identity() - up * up.transpose();
    noise.topLeftCorner<3, 3>() += std::pow(kept * gravity_ * tilt * std::sqrt(2.0), 2) * horizontal;
    const double earth = rate_ie_n_.head<2>().norm(), radius = *std::max_element(point.step.radius.begin(), point.step.radius.end());
    noise.bottomRightCorner<3, 3>() += std::pow(kept * earth, 2) * horizontal;
    noise.topLeftCorner<3, 3>() += std::pow(kept * 2 * point.step.rate * radius * earth, 2) * (up * up.transpose());  // Coriolis
  }
  noise *= noise_factor_ * noise_factor_;
  const Eigen::LLT<Matrix6> factor(noise);
  out.factor = factor.matrixL();
  out.jacobian.resize(6, size());
  for (std::size_t k = 0; k < coefficients_.size(); ++k) out.jacobian.col(static_cast<Index>(k)) = d.coefficients.col(coefficients_[k]);
  out.jacobian.rightCols(static_cast<Index>(common_.size())) = -by_common;
  factor.matrixL().solveInPlace(out.jacobian);
  out.white = factor.matrixL().solve(out.residual);
  return out;
}

SquareSum WholeUnitProblem::square_sum(std::size_t part, std::size_t parts) const {
  SquareSum sum{MatrixXd::Zero(size(), size()), VectorXd::Zero(size()), 0, 0};
  for (std::size_t p = part; p < points_.points.size(); p += parts) {
    const PointEquations e = equations(points_.points[p]);
    sum.N.selfadjointView<Eigen::Lower>().rankUpdate(e.jacobian.transpose());
    sum.g += e.jacobian.transpose() * e.white;
    sum.c += e.white.squaredNorm();
    sum.rows += 6;
  }
  sum.N = sum.N.selfadjointView<Eigen::Lower>();
  return sum;
}

void WholeUnitProblem::forget_common() {
  for (CommonError& error : common_) error.value = 0;
}

void WholeUnitProblem::correct(const VectorXd& x) {
  for (std::size_t k = 0; k < coefficients_.size(); ++k)
    set_coefficient(model_, coefficients_[k], coefficient_value(model_, coefficients_[k]) + x[static_cast<Index>(k)]);
  for (std::size_t k = 0; k < common_.size(); ++k) common_[k].value += x[static_cast<Index>(coefficients_.size() + k)];
}

}  // namespace imulab
