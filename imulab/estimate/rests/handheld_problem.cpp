#include "imulab/estimate/rests/handheld_problem.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/recording/turn.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

const Vector3d up_n = Vector3d::UnitZ();

/// Returns the index of the rotation's integral that is its derivative with respect to a gyro coefficient.
std::size_t integral_of(const Coefficient& c) {
  if (c.term == Term::quadratic || c.term == Term::cubic) return c.term == Term::quadratic ? 7 : 8;
  return static_cast<std::size_t>(c.term == Term::offset ? 0 : c.term == Term::matrix ? 1 + c.column : 4 + c.column);
}

}  // namespace

HandheldProblem::HandheldProblem(const Recording& recording, const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices,
                                 const std::vector<DeclaredTurn>& turns)
    : RestProblem(start, site, std::move(indices)),
      recording_(&recording),
      recorded_(start.recorded),
      links_(rests_.empty() ? 0 : rests_.size() - 1) {
  if (latitude_) earth_up_ = earth_rate * std::sin(*latitude_);
  turning_sigma_ = (noise_.sample.gyro.cwiseAbs2() + noise_.rounding.gyro.cwiseAbs2()).cwiseSqrt();
  common_rounding_ = rounding_in_common();
  stillness_ = stillness_of(recording, start.rests, model_, scaling_, turning_sigma_, noise_.rounding.gyro);
  if (stillness_.moves) {
    std::vector<RestMeans> leveled = start.rests;
    level_at_middle(recording, leveled, model_, scaling_);
    for (std::size_t k = 0; k < rests_.size(); ++k) rests_[k].accel = leveled[k].accel;
  }
  relink();
  add_turns(turns);
}

Vector3d HandheldProblem::rounding_in_common() const {
  Vector3d common = Vector3d::Zero(), low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (const Rest& rest : rests_) low = low.cwiseMin(scaling_.gyro(rest.gyro)), high = high.cwiseMax(scaling_.gyro(rest.gyro));
  for (Index j = 0; j < 3; ++j)  // if means are within a step of each other, so are the true values
    if (high[j] - low[j] <= noise_.step.gyro[j]) common[j] = noise_.rounding.gyro[j];
  return common;
}

Vector3d HandheldProblem::earth_rate_of(std::size_t rest) const {
  const Eigen::Vector2d& h = earth_horizontal_[stretch_[rest]];
  return {h.x(), h.y(), earth_up_};
}

void HandheldProblem::follow_attitudes() {
  C_nb_.resize(rests_.size());
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const Vector3d up = force_at(rests_[k]).normalized();
    Matrix3d carried = Matrix3d::Identity();
    if (k > 0 && linked(k - 1))  // gyros measure the turn relative to inertial space, while n turns with the Earth
      carried = rotation_exp(-links_[k - 1].now.duration_s * earth_rate_of(k - 1)) * C_nb_[k - 1] * links_[k - 1].now.C;
    C_nb_[k] = shortest_rotation(carried * up, up_n) * carried;  // accelerometers level it; gyros preserve its heading
  }
}

// Indices of the unknowns: coefficients, (without latitude) the vertical Earth rate, two for each stretch, three for the rounding.
Index HandheldProblem::earth_column(std::size_t stretch) const { return static_cast<Index>(indices_.size() + (latitude_ ? 0 : 1) + 2 * stretch); }

/// Without a usable heading, the horizontal Earth rate is a vector of known length and unknown direction; without a latitude, only its size is known.
kernel::Parameters HandheldProblem::parameters() const {
  const auto first = static_cast<Index>(indices_.size());
  kernel::Parameters out = RestProblem::parameters(nuisances());
  const double sigma = latitude_ ? std::max(earth_rate * std::cos(*latitude_) / std::sqrt(2.0), 1e-3 * earth_rate) : earth_rate / std::sqrt(3.0);
  out.sigma.segment(first, nuisances()).setConstant(sigma);
  if (!latitude_) out.offset[first] = -earth_up_;
  for (std::size_t s = 0; s < earth_horizontal_.size(); ++s) out.offset.segment<2>(earth_column(s)) = -earth_horizontal_[s];
  out.sigma.segment<3>(rounding_column()) = common_rounding_, out.offset.segment<3>(rounding_column()) = -rounding_;
  for (Index j = 0; j < 3; ++j)
    if (common_rounding_[j] == 0) out.role[static_cast<std::size_t>(rounding_column() + j)] = kernel::Role::fixed;
  return out;
}

Eigen::VectorXd HandheldProblem::longest_step() const {
  Eigen::VectorXd longest = RestProblem::longest_step(nuisances());
  longest.segment(std::ssize(indices_), nuisances()).setConstant(earth_rate);
  longest.segment<3>(rounding_column()).setConstant(kernel::no_prior);
  return longest;
}

Conditions HandheldProblem::conditions(const Spreads& spreads) {
  integrate();
  follow_attitudes();
  Conditions c(static_cast<Index>(4 * rests_.size() + 2 * rotations() + turns()), rounding_column() + 3 + effects_.size());
  Index row = 0;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    c.blocks.push_back(block_of(row, k, spreads));
    add_rest_rows(c, row, k);
    if (linked(k)) add_rotation_rows(c, row + 4, k);
    row += c.blocks.back().size;
  }
  return c;
}

/// Implements Tedaldi 2014; the Earth turns during the turn of the unit.
HandheldProblem::Carried HandheldProblem::carried(std::size_t k) const {
  const IntegratedRotation& rotation = links_[k].now;
  const Vector3d force = force_at(rests_[k]), up = force.normalized(), next_force = force_at(rests_[k + 1]), next_up = next_force.normalized();
  const Matrix3d C_next = rotation.C.transpose();
  const Vector3d turned_up = up + C_nb_[k].transpose() * (rotation_exp(rotation.duration_s * earth_rate_of(k)) * up_n - up_n);
  const Matrix23 basis = tangent_basis(next_up);
  ByRotation rows_by_rotation(rotation_rows_after(k), 3);
  rows_by_rotation.topRows<2>() = basis * C_next * skew<double>(turned_up);
  if (turned(k)) rows_by_rotation.row(2) = links_[k].turn->axis_b.transpose();
  return {C_next * turned_up - next_up, basis, basis * C_next * direction_derivative(force), -basis * direction_derivative(next_force),
          rows_by_rotation};
}

/// Returns the noise of a rest's rows: force, rate, and the following rotation. Neighboring blocks share the force of the rest between them.
CovarianceBlock HandheldProblem::block_of(Index row, std::size_t k, const Spreads& spreads) const {
  CovarianceBlock block{row, 4 + rotation_rows_after(k), {}, {}};
  const Matrix3d p = force_covariance(rests_[k], spreads[0]);
  MatrixXd rows_by_force = MatrixXd::Zero(block.size, 3);
  const Vector3d up = force_at(rests_[k]).normalized();
  rows_by_force.row(0) = up.transpose();
  block.covariance.setZero(block.size, block.size);
  block.covariance.block<3, 3>(1, 1) = rate_covariance(rests_[k], spreads[1]);
  // Wander in both halves makes the mean rate differ from the Earth's.
  const double duration = static_cast<double>(rests_[k].range.size()) * recording_->interval_s;
  block.covariance.diagonal().segment<3>(1).array() += 2 * std::pow(stillness_.wander / duration, 2);
  if (linked(k)) {
    const Carried c = carried(k);
    rows_by_force.middleRows<2>(4) = c.difference_by_force;
    block.covariance.bottomRightCorner(c.rows_by_rotation.rows(), c.rows_by_rotation.rows()) =
        c.rows_by_rotation * (links_[k].now.covariance + spreads[2] * spreads[2] * Matrix3d::Identity()) * c.rows_by_rotation.transpose();
    block.covariance.block<2, 2>(4, 4) +=
        c.difference_by_next_force * force_covariance(rests_[k + 1], spreads[0]) * c.difference_by_next_force.transpose();
    if (turned(k)) {
      const double tilt = links_[k].turn->tilt_sigma(), angle = links_[k].turn->angle_sigma();
      block.covariance.diagonal().tail<3>() += Vector3d(tilt * tilt, tilt * tilt, angle * angle);
    }
  }
  block.covariance += rows_by_force * p * rows_by_force.transpose();
  if (k > 0 && linked(k - 1)) {
    block.coupling.setZero(block.size, 4 + rotation_rows_after(k - 1));
    block.coupling.middleCols<2>(4) = rows_by_force * p * carried(k - 1).difference_by_next_force.transpose();
    if (turned(k) && turned(k - 1) && links_[k].turn->axis == links_[k - 1].turn->axis)  // one turn begins where the other ended
      block.coupling(6, 6) = -std::pow(links_[k].turn->sigma, 2);
  }
  return block;
}

/// |f| - g = 0, and W0 + W1 (v - r) + C f - C_bn w_ie = 0, where r is the part of the rounding that all rests share. The dependence of C_bn and C f
/// on the force is of second order because w_ie and C are small.
void HandheldProblem::add_rest_rows(Conditions& c, Index row, std::size_t k) const {
  const Rest& rest = rests_[k];
  const Vector3d force = force_at(rest);
  const Matrix3d C_bn = C_nb_[k].transpose();
  c.value[row] = force.norm() - gravity_;
  c.value.segment<3>(row + 1) = rate_at(rest) - model_.gyro.matrix * rounding_ - C_bn * earth_rate_of(k);
  std::fill_n(c.kind.begin() + row + 1, 3, Kind::gyro_rest);
  add_derivatives(c, row, Triad::accel, rest, force.normalized().transpose());
  add_derivatives(c, row + 1, Triad::gyro, rest, Matrix3d::Identity());
  if (!latitude_) c.jacobian.block<3, 1>(row + 1, static_cast<Index>(indices_.size())) = -C_bn.col(2);
  c.jacobian.block<3, 2>(row + 1, earth_column(stretch_[k])) = -C_bn.leftCols<2>();
  c.jacobian.block<3, 3>(row + 1, rounding_column()) = -model_.gyro.matrix;
}

void HandheldProblem::add_rotation_rows(Conditions& c, Index row, std::size_t k) const {
  const IntegratedRotation& rotation = links_[k].now;
  const Carried up = carried(k);
  c.value.segment<2>(row) = up.basis * up.difference;
  std::fill_n(c.kind.begin() + row, 2, Kind::rotation);
  if (turned(k)) {  // relative to the Earth
    const Vector3d earth_b = C_nb_[k].transpose() * earth_rate_of(k);
    c.value[row + 2] = angle_beyond(*links_[k].turn, rotation_exp(-rotation.duration_s * earth_b) * rotation.C, swept(links_[k]));
    c.kind[static_cast<std::size_t>(row + 2)] = Kind::turn;
  }
  add_derivatives(c, row, Triad::accel, rests_[k], up.difference_by_force);
  add_derivatives(c, row, Triad::accel, rests_[k + 1], up.difference_by_next_force);
  const Index rows = up.rows_by_rotation.rows();
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != Triad::gyro) continue;
    c.jacobian.col(static_cast<Index>(i)).segment(row, rows) = up.rows_by_rotation * rotation.phi[integral_of(term)].col(term.row);
  }
  const Index first = rounding_column() + 3;
  Index gyro = 0;
  for (Index i = 0; i < effects_.size(); ++i)
    if (effects_.columns()[static_cast<std::size_t>(i)].effect->changes(Triad::gyro))
      c.jacobian.col(first + i).segment(row, rows) = -up.rows_by_rotation * rotation.by_effect.col(gyro++);
  const ByRotation rows_by_earth_rate = -rotation.duration_s * up.rows_by_rotation * C_nb_[k].transpose();
  if (!latitude_) c.jacobian.block(row, static_cast<Index>(indices_.size()), rows, 1) = rows_by_earth_rate.col(2);
  c.jacobian.block(row, earth_column(stretch_[k]), rows, 2) = rows_by_earth_rate.leftCols<2>();
}

void HandheldProblem::correct(const Eigen::VectorXd& correction) {
  RestProblem::correct(correction);
  if (!latitude_) earth_up_ += correction[static_cast<Index>(indices_.size())];
  for (std::size_t s = 0; s < earth_horizontal_.size(); ++s) earth_horizontal_[s] += correction.segment<2>(earth_column(s));
  rounding_ += correction.segment<3>(rounding_column());
}

void HandheldProblem::extend(const Vector3d& axis, double angle, double rest_s) {
  constexpr int pieces = 40;                      // number of parts of a turn, a few degrees each
  constexpr double rate = 1.5, acceleration = 3;  // rad/s, rad/s^2, typical of a hand
  const Vector3d force = gravity_ * last_up();
  const Matrix3d to_accel = model_.accel.matrix.inverse(), to_gyro = model_.gyro.matrix.inverse();
  const double duration = turn_duration(angle, rate, acceleration), dt = duration / pieces;
  const auto turned = [&](double t) { return turn_state(angle, rate, acceleration, t).angle; };
  const auto accel_of = [&](double by) { return Vector3d(to_accel * (rotation_exp(Vector3d(-by * axis)) * force - model_.accel.offset)); };
  const auto reading_at = [&](const Vector3d& scaled, bool accel) {
    return Vector3d(accel ? scaling_.accel_center + scaling_.accel_scale.cwiseProduct(scaled)
                          : scaling_.gyro_center + scaling_.gyro_scale.cwiseProduct(scaled));
  };
  const auto gyro_of = [&](const Vector3d& rate_b, const Vector3d& accel) {
    return Vector3d(to_gyro * (rate_b - model_.gyro.offset - model_.g_sensitivity * output(model_.accel, accel)));
  };
  Recording turn;
  turn.interval_s = dt, turn.gyro_increment = true;  // every sample lasts dt
  turn.time_ns.resize(pieces);
  for (int i = 0; i < pieces; ++i) {
    const double begin = turned(i * dt), end = turned((i + 1) * dt);
    const Vector3d accel = accel_of(0.5 * (begin + end)), a = reading_at(accel, true),
                   g = reading_at(gyro_of((end - begin) / dt * axis, accel), false);
    for (std::size_t j = 0; j < 3; ++j) turn.accel[j].push_back(a[static_cast<Index>(j)]), turn.gyro[j].push_back(g[static_cast<Index>(j)]);
  }
  Link link;
  link.usable = true;
  link.rotation = link.now = integrated(turn, {0, pieces}, std::sqrt(recording_->interval_s / dt) * turning_sigma_);
  link.now.C = corrected(link.rotation, Vector3d::Zero());
  link.at = model_;
  const Vector3d accel = accel_of(angle);
  Rest rest;
  rest.observed = rests_.back().observed;
  rest.range = {0, std::max<std::size_t>(1, static_cast<std::size_t>(rest_s / recording_->interval_s))};
  rest.accel = reading_at(accel, true), rest.gyro = reading_at(gyro_of(Vector3d::Zero(), accel), false);
  rests_.push_back(rest);
  links_.push_back(link);
  stretch_.push_back(stretch_.back());
}

std::vector<HandheldProblem::RotationRows> HandheldProblem::rotation_rows(const Conditions& conditions) const {
  std::vector<RotationRows> rows;
  for (std::size_t k = 0; k < links_.size(); ++k)
    if (linked(k)) rows.push_back({k, conditions.blocks[k].first + 4, rotation_log(links_[k].now.C).norm()});
  return rows;
}

std::vector<SuspectRows> HandheldProblem::suspects(const Conditions& conditions) const {
  std::vector<SuspectRows> all = RestProblem::suspects(conditions);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    SuspectRows suspect{fmt::format("the rotation between {:.1f} s and {:.1f} s", rests_[k].mid_s - first_s_, rests_[k + 1].mid_s - first_s_),
                        {},
                        rests_[k].end_s,
                        rests_[k + 1].begin_s,
                        true};
    for (Index row = 0; row < rotation_rows_after(k); ++row) suspect.rows.push_back(conditions.blocks[k].first + 4 + row);
    std::vector<Index>& next_rest = all[k + 1].rows;  // the rotation contains the force of the next rest
    next_rest.insert(next_rest.end(), suspect.rows.begin(), suspect.rows.end());
    all.push_back(std::move(suspect));
  }
  return all;
}

void HandheldProblem::drop(std::size_t k) {
  const auto at = static_cast<std::ptrdiff_t>(k);
  if (k >= rests_.size()) {
    links_[k - rests_.size()].refused = true;
  } else {
    rests_.erase(rests_.begin() + at);
    if (!links_.empty()) links_.erase(links_.begin() + std::min(at, std::ssize(links_) - 1));
    if (k > 0 && k - 1 < links_.size()) links_[k - 1] = {};  // a new, longer rotation
  }
  relink();
}

void HandheldProblem::leave_out_rotations() {
  rests_alone_ = true;
  relink();
}

void HandheldProblem::release() {
  RestProblem::release();
  if (std::exchange(rests_alone_, false)) relink();
}

}  // namespace imulab::rests
