#include "imulab/estimate/rests/handheld_problem.hpp"

#include "imulab/earth/earth.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;
using kernel::Rest;

namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// Rows: two unit vectors that complete the unit vector `up` to a right-handed triad.
Matrix23 tangent_basis(const Vector3d& up) {
  Index smallest;
  up.cwiseAbs().minCoeff(&smallest);
  const Vector3d first = up.cross(Vector3d::Unit(smallest)).normalized();
  Matrix23 basis;
  basis << first.transpose(), up.cross(first).transpose();
  return basis;
}

/// The rotation by the smallest angle that takes unit vector a to unit vector b.
Matrix3d shortest_rotation(const Vector3d& a, const Vector3d& b) { return Eigen::Quaterniond::FromTwoVectors(a, b).toRotationMatrix(); }

/// d normalized(v) / d v
Matrix3d direction_derivative(const Vector3d& v) {
  const Vector3d unit = v.normalized();
  return (Matrix3d::Identity() - unit * unit.transpose()) / v.norm();
}

bool contains_any(const std::vector<std::size_t>& sorted, std::size_t begin, std::size_t end) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), begin);
  return at != sorted.end() && *at < end;
}

const Vector3d up_n = Vector3d::UnitZ();

}  // namespace

HandheldProblem::HandheldProblem(const Recording& recording, const kernel::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices)
    : RestProblem(start, site, std::move(indices)), recording_(&recording), links_(rests_.empty() ? 0 : rests_.size() - 1) {
  if (latitude_) earth_up_ = earth_rate * std::sin(*latitude_);
  relink();
}

void HandheldProblem::relink() {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const std::size_t begin = rests_[k].range.end, end = rests_[k + 1].range.begin;
    // A gap before sample `end` itself is missing motion too. Rests that adjoin have no rotation between them.
    links_[k].usable = !links_[k].refused && !contains_any(recording_->gaps, begin, end + 1) && !contains_any(recording_->saturated, begin, end);
  }
  set_stretches();
}

void HandheldProblem::set_stretches() {
  stretch_.assign(rests_.size(), 0);
  for (std::size_t k = 1; k < rests_.size(); ++k) stretch_[k] = stretch_[k - 1] + (links_[k - 1].usable ? 0 : 1);
  earth_horizontal_.assign(rests_.empty() ? 0 : stretch_.back() + 1, Eigen::Vector2d::Zero());
}

std::size_t HandheldProblem::rotations() const {
  return static_cast<std::size_t>(std::count_if(links_.begin(), links_.end(), [](const Link& link) { return link.usable; }));
}

Vector3d HandheldProblem::earth_rate_of(std::size_t rest) const {
  const Eigen::Vector2d& h = earth_horizontal_[stretch_[rest]];
  return {h.x(), h.y(), earth_up_};
}

void HandheldProblem::integrate() {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    Link& link = links_[k];
    if (!link.usable) continue;
    if (link.at) {  // a small step follows from the derivatives: the second-order part of 1e-4 rad is below 1e-8 rad
      const Vector3d angle = link.rotation.change(link.at->gyro, link.at->g_sensitivity, model_.gyro, model_.g_sensitivity);
      if (angle.norm() < 1e-4 && (model_.accel.matrix - link.at->accel.matrix).norm() + (model_.accel.offset - link.at->accel.offset).norm() < 1e-3 * gravity_) {
        link.now.C = rotation_exp(angle) * link.rotation.C;
        continue;
      }
    }
    link.rotation = link.now = integrate_rotation(*recording_, {rests_[k].range.end, rests_[k + 1].range.begin}, model_, scaling_, noise_.gyro);
    link.at = model_;
  }
}

void HandheldProblem::follow_attitudes() {
  C_nb_.resize(rests_.size());
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const Vector3d up = force_at(rests_[k]).normalized();
    Matrix3d carried = Matrix3d::Identity();
    if (k > 0 && links_[k - 1].usable)  // the gyros turn against inertial space, and n turns with the Earth meanwhile
      carried = rotation_exp(-links_[k - 1].now.duration_s * earth_rate_of(k - 1)) * C_nb_[k - 1] * links_[k - 1].now.C;
    C_nb_[k] = shortest_rotation(carried * up, up_n) * carried;  // the accelerometers level it, the gyros keep its heading
  }
}

// Places of the unknowns: coefficients, then (without latitude) the vertical Earth rate, then two for each stretch.
Index HandheldProblem::earth_column(std::size_t stretch) const { return static_cast<Index>(indices_.size() + (latitude_ ? 0 : 1) + 2 * stretch); }

/// Without a usable heading the horizontal Earth rate is a vector of known length and unknown direction; without a latitude only its size is known.
kernel::Parameters HandheldProblem::parameters() const {
  const auto first = static_cast<Index>(indices_.size());
  kernel::Parameters out = RestProblem::parameters(earth_column(earth_horizontal_.size()) - first);
  const double sigma = latitude_ ? std::max(earth_rate * std::cos(*latitude_) / std::sqrt(2.0), 1e-3 * earth_rate) : earth_rate / std::sqrt(3.0);
  out.sigma.tail(out.size() - first).setConstant(sigma);
  if (!latitude_) out.offset[first] = -earth_up_;
  for (std::size_t s = 0; s < earth_horizontal_.size(); ++s) out.offset.segment<2>(earth_column(s)) = -earth_horizontal_[s];
  return out;
}

Eigen::VectorXd HandheldProblem::longest_step() const {
  Eigen::VectorXd longest = parameters().sigma;
  longest.tail(longest.size() - static_cast<Index>(indices_.size())).setConstant(earth_rate);
  return longest;
}

Conditions HandheldProblem::conditions(const Spreads& spreads) {
  integrate();
  follow_attitudes();
  Conditions c(static_cast<Index>(4 * rests_.size() + 2 * rotations()), earth_column(earth_horizontal_.size()));
  Index row = 0;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    c.blocks.push_back(block_of(row, k, spreads));
    add_gravity_row(c, row, k);
    add_gyro_rows(c, row + 1, k);
    if (c.blocks.back().size == 6) add_rotation_rows(c, row + 4, k);
    row += c.blocks.back().size;
  }
  return c;
}

/// What an error of the next rest's force does to the rows of the rotation towards it.
Matrix23 HandheldProblem::by_next_force(std::size_t k) const {
  const Vector3d next_force = force_at(rests_[k + 1]);
  return -tangent_basis(next_force.normalized()) * direction_derivative(next_force);
}

/// The noise of a rest's rows: of its force, its rate and the rotation after it. Neighbors share the force of the rest between them.
Conditions::Block HandheldProblem::block_of(Index row, std::size_t k, const Spreads& spreads) const {
  const bool linked = k < links_.size() && links_[k].usable;
  Conditions::Block block{row, linked ? 6 : 4, {}, {}};
  const Vector3d force = force_at(rests_[k]), up = force.normalized();
  const Matrix3d p = force_covariance(rests_[k], spreads[0]);
  MatrixXd by_force = MatrixXd::Zero(block.size, 3);
  by_force.row(0) = up.transpose();
  block.covariance.setZero(block.size, block.size);
  block.covariance.block<3, 3>(1, 1) = rate_covariance(rests_[k], spreads[1]);
  if (linked) {
    const Matrix23 basis = tangent_basis(force_at(rests_[k + 1]).normalized());
    const Matrix3d C_next = links_[k].now.C.transpose();
    by_force.bottomRows<2>() = basis * C_next * direction_derivative(force);
    const Matrix23 by_rotation = basis * C_next * skew<double>(up), by_next = by_next_force(k);
    block.covariance.bottomRightCorner<2, 2>() =
        by_rotation * (links_[k].now.covariance + spreads[2] * spreads[2] * Matrix3d::Identity()) * by_rotation.transpose() +
        by_next * force_covariance(rests_[k + 1], spreads[0]) * by_next.transpose();
  }
  block.covariance += by_force * p * by_force.transpose();
  if (k > 0 && links_[k - 1].usable) {
    block.coupling.setZero(block.size, 6);
    block.coupling.rightCols<2>() = by_force * p * by_next_force(k - 1).transpose();
  }
  return block;
}

/// |f| - g = 0.
void HandheldProblem::add_gravity_row(Conditions& c, Index row, std::size_t k) const {
  const Rest& rest = rests_[k];
  const Vector3d force = force_at(rest), up = force.normalized();
  const Vector3d v = scaling_.accel(rest.accel);
  c.value[row] = force.norm() - gravity_;
  c.kind[static_cast<std::size_t>(row)] = Kind::gravity;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != Triad::accel) continue;
    c.jacobian(row, static_cast<Index>(i)) = up[term.row] * (term.term == Term::offset ? 1.0 : v[term.column]);
  }
}

/// W0 + W1 v + C f - C_bn w_ie = 0. That the force turns C_bn and enters C f is of second order: w_ie and C are small.
void HandheldProblem::add_gyro_rows(Conditions& c, Index row, std::size_t k) const {
  const Rest& rest = rests_[k];
  const Vector3d force = force_at(rest);
  const Vector3d v = scaling_.gyro(rest.gyro);
  const Matrix3d C_bn = C_nb_[k].transpose();
  c.value.segment<3>(row) = kernel::linear(model_.gyro, v) + model_.g_sensitivity * force - C_bn * earth_rate_of(k);
  for (Index r = 0; r < 3; ++r) c.kind[static_cast<std::size_t>(row + r)] = Kind::gyro_rest;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != Triad::gyro) continue;
    const double basis = term.term == Term::offset ? 1.0 : term.term == Term::matrix ? v[term.column] : force[term.column];
    c.jacobian(row + term.row, static_cast<Index>(i)) = basis;
  }
  if (!latitude_) c.jacobian.block<3, 1>(row, static_cast<Index>(indices_.size())) = -C_bn.col(2);
  c.jacobian.block<3, 2>(row, earth_column(stretch_[k])) = -C_bn.leftCols<2>();
}

/// Up before the rotation, carried by the gyros, against up after it, in the plane across it (Tedaldi 2014). While the unit turns, so does the Earth.
void HandheldProblem::add_rotation_rows(Conditions& c, Index row, std::size_t k) const {
  const IntegratedRotation& rotation = links_[k].now;
  const Rest &rest = rests_[k], &next = rests_[k + 1];
  const Vector3d force = force_at(rest), up = force.normalized(), next_force = force_at(next), next_up = next_force.normalized();
  const Matrix3d C_next = rotation.C.transpose(), C_bn = C_nb_[k].transpose();
  const Vector3d turned_up = up + C_bn * (rotation_exp(rotation.duration_s * earth_rate_of(k)) * up_n - up_n);
  const Matrix23 basis = tangent_basis(next_up);
  const Matrix23 by_force = basis * C_next * direction_derivative(force);
  const Matrix23 by_next = -basis / next_force.norm();
  const Matrix23 by_rotation = basis * C_next * skew<double>(turned_up);
  const Vector3d v = scaling_.accel(rest.accel);
  const Vector3d next_v = scaling_.accel(next.accel);

  c.value.segment<2>(row) = basis * (C_next * turned_up - next_up);
  for (Index r = 0; r < 2; ++r) c.kind[static_cast<std::size_t>(row + r)] = Kind::rotation;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    const bool offset = term.term == Term::offset;
    auto target = c.jacobian.col(static_cast<Index>(i)).segment<2>(row);
    if (term.triad == Triad::accel) {
      target = by_force.col(term.row) * (offset ? 1.0 : v[term.column]) + by_next.col(term.row) * (offset ? 1.0 : next_v[term.column]);
    } else {
      const int integral = offset ? 0 : term.term == Term::matrix ? 1 + term.column : 4 + term.column;
      target = by_rotation * rotation.phi[static_cast<std::size_t>(integral)].col(term.row);
    }
  }
  const Matrix23 by_earth = -rotation.duration_s * basis * C_next * C_bn * skew<double>(up_n);
  if (!latitude_) c.jacobian.block<2, 1>(row, static_cast<Index>(indices_.size())) = by_earth.col(2);
  c.jacobian.block<2, 2>(row, earth_column(stretch_[k])) = by_earth.leftCols<2>();
}

void HandheldProblem::correct(const Eigen::VectorXd& correction) {
  correct_coefficients(correction);
  if (!latitude_) earth_up_ += correction[static_cast<Index>(indices_.size())];
  for (std::size_t s = 0; s < earth_horizontal_.size(); ++s) earth_horizontal_[s] += correction.segment<2>(earth_column(s));
}

std::vector<HandheldProblem::RotationRows> HandheldProblem::rotation_rows(const Conditions& conditions) const {
  std::vector<RotationRows> rows;
  for (std::size_t k = 0; k < links_.size(); ++k)
    if (links_[k].usable) rows.push_back({{conditions.blocks[k].first + 4, conditions.blocks[k].first + 5}, rotation_log(links_[k].now.C).norm()});
  return rows;
}

std::vector<SuspectRows> HandheldProblem::suspects(const Conditions& conditions) const {
  std::vector<SuspectRows> all;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    SuspectRows suspect{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}};
    for (Index r = 0; r < conditions.blocks[k].size; ++r) suspect.rows.push_back(conditions.blocks[k].first + r);
    if (k > 0 && links_[k - 1].usable)
      for (const Index r : {4, 5}) suspect.rows.push_back(conditions.blocks[k - 1].first + r);
    all.push_back(std::move(suspect));
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    SuspectRows suspect{fmt::format("the rotation between {:.1f} s and {:.1f} s", rests_[k].mid_s, rests_[k + 1].mid_s), {}};
    if (links_[k].usable) suspect.rows = {conditions.blocks[k].first + 4, conditions.blocks[k].first + 5};
    all.push_back(std::move(suspect));
  }
  return all;
}

void HandheldProblem::drop(std::size_t k) {
  if (k < rests_.size()) {
    rests_.erase(rests_.begin() + static_cast<std::ptrdiff_t>(k));
    if (!links_.empty()) {
      const std::size_t gone = std::min(k, links_.size() - 1);
      links_.erase(links_.begin() + static_cast<std::ptrdiff_t>(gone));
      if (k > 0 && k - 1 < links_.size()) links_[k - 1] = {};  // a new, longer rotation
    }
  } else {
    links_[k - rests_.size()].refused = true;
  }
  relink();
}

void HandheldProblem::estimate_only(std::vector<CoefficientIndex> indices) {
  for (const CoefficientIndex index : indices_)
    if (std::find(indices.begin(), indices.end(), index) == indices.end()) set_coefficient(model_, index, 0.0);
  indices_ = std::move(indices);
  roles_.assign(indices_.size(), kernel::Role::estimated);
}

}  // namespace imulab::rests
