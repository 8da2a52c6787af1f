#include "imulab/estimate/hybrid/motion_information.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/recording/turn.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using in_place::Attitude;
using in_place::AttitudeAt;

namespace {

/// Returns the information of a block. The residuals (phi1 minus its prediction from the states before, 0 - velocity) are white noise.
MotionInformation block_information(const InformationModel& m, const AttitudeAt& attitude, double begin, double end) {
  const Index n = m.size();
  const in_place::BlockSums sums = in_place::sums_of(attitude, begin, end, m.place.latitude, m.place.gravity);
  const MatrixXd t = transition(sums, m.states, m.place);
  MatrixXd residual(6, n + 6);
  residual << -t(Eigen::all, m.constants), -t.middleCols<3>(m.states.attitude()), MatrixXd::Identity(6, 3);
  const MatrixXd white = sums.covariance(m.noise, attitude(0.5 * (begin + end)).C_nb).llt().matrixL().solve(residual);
  return white.transpose() * white;
}

/// Columns of three unknowns, with a row for each other unknown.
using Across = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Returns the information about the other unknowns for any values of the three (Schur complement). A search spends most of its time here; columns
/// are faster than a product of matrices with an inner size of three.
MatrixXd without(const Matrix3d& three, const Across& across, MatrixXd others) {
  const Eigen::Matrix<double, 3, Eigen::Dynamic> part = three.inverse() * across.transpose();
  for (Index j = 0; j < others.cols(); ++j) others.col(j) -= across.col(0) * part(0, j) + across.col(1) * part(1, j) + across.col(2) * part(2, j);
  return others;
}

/// Joins several copies of the same motion.
MotionInformation repeated(MotionInformation motion, int times) {
  MotionInformation out;
  for (int left = times; left > 0; left /= 2) {
    if (left % 2 == 1) out = out.size() == 0 ? motion : joined(out, motion);
    if (left > 1) motion = joined(motion, motion);
  }
  return out;
}

}  // namespace

InformationModel::InformationModel(const Plan& plan)
    : place(plan.place), noise(plan.noise), states(plan.terms, plan.place), observe_motion(plan.observe_motion) {
  const Index start = states.first(Group::start);
  for (Index s = 0; s < states.constants(); ++s)
    if ((s < start || s >= start + 3) && states.prior[s] > 0) constants.push_back(s);
}

RestSeconds used_seconds(const InformationModel& model, int rest, bool outermost) {
  constexpr auto settling = static_cast<int>(in_place::settling_time);
  if (!model.observe_motion) return {std::max(1, rest - unseen_before - unseen_after)};
  return {std::max(1, rest - 2 * settling), outermost ? settling : 2 * settling};
}

MotionInformation rest_information(const InformationModel& model, const Matrix3d& C_nb, RestSeconds seconds) {
  const MotionInformation second = block_information(
      model, [&](double) { return Attitude{C_nb}; }, 0, 1);
  // The heading is constant up to a small fraction of the gyros' noise and the error of their integral at both ends.
  constexpr double next_to_noise = 1e-3;
  MotionInformation still = second;
  const Index before = model.size() + 2, now = model.size() + 5;
  const double weight = 1 / std::max(next_to_noise * model.noise.gyro.cwiseAbs2().mean(), 2 * std::pow(model.noise.angle, 2) / seconds.still);
  still(before, before) += weight, still(now, now) += weight;
  still(before, now) -= weight, still(now, before) -= weight;
  still = repeated(std::move(still), seconds.still);
  return seconds.settling > 0 ? joined(repeated(second, seconds.settling), still) : still;
}

MotionInformation turn_information(const InformationModel& model, const Matrix3d& C_nb, const Turn& turn) {
  const double duration = turn_duration(turn.angle, turn.rate, turn.acceleration);
  const auto attitude = [&](double t) {
    const TurnState now = turn_state(turn.angle, turn.rate, turn.acceleration, t);
    return Attitude{rotation_about(turn.axis, now.angle) * C_nb, now.rate * turn.axis};
  };
  if (!model.observe_motion) return block_information(model, attitude, -unseen_before, duration + unseen_after);
  const auto blocks = std::max(1, static_cast<int>(std::lround(duration / 0.2)));
  MotionInformation out;
  for (int k = 0; k < blocks; ++k) {
    const MotionInformation next = block_information(model, attitude, k * duration / blocks, (k + 1) * duration / blocks);
    out = k == 0 ? next : joined(out, next);
  }
  return out;
}

MotionInformation joined(const MotionInformation& first, const MotionInformation& second) {
  const Index n = first.rows() - 6;
  MatrixXd others(n + 6, n + 6);  // constants, attitude at the start of the first, attitude at the end of the second
  others.topLeftCorner(n, n) = first.topLeftCorner(n, n) + second.topLeftCorner(n, n);
  others.block(0, n, n, 3) = first.block(0, n, n, 3), others.block(n, 0, 3, n) = first.block(n, 0, 3, n);
  others.topRightCorner(n, 3) = second.topRightCorner(n, 3), others.bottomLeftCorner(3, n) = second.bottomLeftCorner(3, n);
  others.block<3, 3>(n, n) = first.block<3, 3>(n, n), others.bottomRightCorner<3, 3>() = second.bottomRightCorner<3, 3>();
  others.block<3, 3>(n, n + 3).setZero(), others.block<3, 3>(n + 3, n).setZero();
  Across across(n + 6, 3);
  across << first.topRightCorner(n, 3) + second.block(0, n, n, 3), first.block<3, 3>(n, n + 3), second.block<3, 3>(n + 3, n);
  return without(first.bottomRightCorner<3, 3>() + second.block<3, 3>(n, n), across, std::move(others));
}

Knowledge prior_knowledge(const InformationModel& model) {
  VectorXd sigma(model.size() + 3);
  sigma << model.states.prior(model.constants), model.states.prior.segment<3>(model.states.first(Group::start));
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

Knowledge knowledge_of(const InformationModel& model, const FilterPrediction& prediction) {
  std::vector<Index> states = model.constants;
  for (Index i = 0; i < 3; ++i) states.push_back(prediction.states.attitude() + i);
  const MatrixXd covariance = prediction.covariance(states, states);
  const VectorXd unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = unit.asDiagonal() * covariance * unit.asDiagonal();
  return unit.asDiagonal() * inverse_of(correlation) * unit.asDiagonal();
}

Knowledge after(const Knowledge& before, const MotionInformation& motion) {
  const Index n = before.rows() - 3;
  MatrixXd others(n + 3, n + 3);  // constants, attitude at the end
  others.topLeftCorner(n, n) = motion.topLeftCorner(n, n) + before.topLeftCorner(n, n);
  others.topRightCorner(n, 3) = motion.topRightCorner(n, 3), others.bottomLeftCorner(3, n) = motion.bottomLeftCorner(3, n);
  others.bottomRightCorner<3, 3>() = motion.bottomRightCorner<3, 3>();
  Across across(n + 3, 3);
  across << motion.block(0, n, n, 3) + before.topRightCorner(n, 3), motion.block<3, 3>(n + 3, n);
  return without(motion.block<3, 3>(n, n) + before.bottomRightCorner<3, 3>(), across, std::move(others));
}

VectorXd sigma_of(const Knowledge& knowledge) {
  const Index n = knowledge.rows() - 3;
  return Cholesky(knowledge).solve_lower(MatrixXd::Identity(knowledge.rows(), knowledge.rows())).colwise().norm().transpose().head(n);
}

}  // namespace imulab::hybrid
