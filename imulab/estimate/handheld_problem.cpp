#include "imulab/estimate/handheld_problem.hpp"

#include "imulab/earth/earth.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace imulab {

using Eigen::Index;

namespace {

/// Two unit vectors that complete the unit vector `up` to a right-handed triad.
Eigen::Matrix<double, 3, 2> tangent_basis(const Vector3d& up) {
  Index smallest;
  up.cwiseAbs().minCoeff(&smallest);
  const Vector3d first = up.cross(Vector3d::Unit(smallest)).normalized();
  Eigen::Matrix<double, 3, 2> basis;
  basis << first, up.cross(first);
  return basis;
}

/// The rotation by the smallest angle that takes unit vector a to unit vector b.
Matrix3d shortest_rotation(const Vector3d& a, const Vector3d& b) { return Eigen::Quaterniond::FromTwoVectors(a, b).toRotationMatrix(); }

bool contains_any(const std::vector<std::size_t>& sorted, std::size_t begin, std::size_t end) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), begin);
  return at != sorted.end() && *at < end;
}

const Vector3d up_n = Vector3d::UnitZ();

}  // namespace

HandheldProblem::HandheldProblem(const Recording& recording, std::vector<Rest> rests, double gravity, std::optional<double> latitude,
                                 const SampleNoise& noise, const Scaling& scaling, const SensorModel& scaled_model, const Prior& prior,
                                 std::vector<int> indices)
    : recording_(&recording), rests_(std::move(rests)), gravity_(gravity), latitude_(latitude), scaling_(scaling), model_(scaled_model), prior_(prior), indices_(std::move(indices)),
      sigma_(prior_.sigmas(indices_, gravity_)) {
  noise_ = {noise.accel.cwiseQuotient(scaling.accel_scale), noise.gyro.cwiseQuotient(scaling.gyro_scale)};
  links_.resize(rests_.empty() ? 0 : rests_.size() - 1);
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

Vector3d HandheldProblem::force_at(const Rest& rest) const {
  return model_.accel.offset + model_.accel.matrix * (rest.accel - scaling_.accel_center).cwiseQuotient(scaling_.accel_scale);
}

Vector3d HandheldProblem::earth_rate_of(std::size_t rest) const {
  const Eigen::Vector2d& h = earth_horizontal_[stretch_[rest]];
  return {h.x(), h.y(), earth_up_};
}

Matrix3d HandheldProblem::force_covariance(const Rest& rest, double spread) const {
  const Matrix3d sampling = model_.accel.matrix * noise_.accel.cwiseAbs2().asDiagonal() * model_.accel.matrix.transpose();
  return sampling / static_cast<double>(rest.range.size()) + spread * spread * Matrix3d::Identity();
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
namespace {
Index earth_column(std::size_t coefficients, bool vertical, std::size_t stretch) {
  return static_cast<Index>(coefficients + (vertical ? 1 : 0) + 2 * stretch);
}
}  // namespace

Conditions HandheldProblem::conditions(const Spreads& spreads) {
  integrate();
  follow_attitudes();
  const bool vertical = !latitude_;
  const Index unknowns = earth_column(indices_.size(), vertical, earth_horizontal_.size());
  const Index coefficients = static_cast<Index>(indices_.size()), priors = unknowns - coefficients;
  const Index rows = 4 * static_cast<Index>(rests_.size()) + 2 * static_cast<Index>(rotations()) + unknowns;

  Conditions c;
  c.value.setZero(rows);
  c.jacobian.setZero(rows, unknowns);
  c.spread_gain.setOnes(rows);
  c.kind.assign(static_cast<std::size_t>(rows), ConditionKind::prior);
  Index row = 0;
  Eigen::MatrixXd on_force;  // how the block's rows feel the error of its own rest's force
  Eigen::MatrixXd previous_on_next;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const bool linked = k < links_.size() && links_[k].usable;
    Conditions::Block block;
    block.first = row;
    block.size = linked ? 6 : 4;
    add_gravity_row(c, row, k);
    add_gyro_rows(c, row + 1, k);
    if (linked) add_rotation_rows(c, row + 4, k);

    const Vector3d force = force_at(rests_[k]), up = force.normalized();
    const Matrix3d across = (Matrix3d::Identity() - up * up.transpose()) / force.norm();
    const Matrix3d p = force_covariance(rests_[k], spreads[0]);
    on_force.setZero(block.size, 3);
    on_force.row(0) = up.transpose();
    Eigen::MatrixXd on_next = Eigen::MatrixXd::Zero(block.size, 3);
    block.covariance.setZero(block.size, block.size);
    const double n = static_cast<double>(rests_[k].range.size());
    block.covariance.block<3, 3>(1, 1) = model_.gyro.matrix * noise_.gyro.cwiseAbs2().asDiagonal() * model_.gyro.matrix.transpose() / n +
                                         spreads[1] * spreads[1] * Matrix3d::Identity();
    if (linked) {
      const Rest& next = rests_[k + 1];
      const Vector3d next_force = force_at(next), next_up = next_force.normalized();
      const Eigen::Matrix<double, 2, 3> basis = tangent_basis(next_up).transpose();
      const Matrix3d C_next = links_[k].now.C.transpose();
      on_force.bottomRows<2>() = basis * C_next * across;
      on_next.bottomRows<2>() = -basis * (Matrix3d::Identity() - next_up * next_up.transpose()) / next_force.norm();
      const Eigen::Matrix<double, 2, 3> on_rotation = basis * C_next * skew<double>(up);
      block.covariance.bottomRightCorner<2, 2>() =
          on_rotation * (links_[k].now.covariance + spreads[2] * spreads[2] * Matrix3d::Identity()) * on_rotation.transpose();
      block.covariance += on_next * force_covariance(next, spreads[0]) * on_next.transpose();
    }
    block.covariance += on_force * p * on_force.transpose();
    if (k > 0 && links_[k - 1].usable) block.coupling = on_force * p * previous_on_next.transpose();
    previous_on_next = on_next;
    row += block.size;
    c.blocks.push_back(std::move(block));
  }
  add_prior_rows(c, row, prior_, sigma_, model_, indices_);
  row += coefficients;
  // Without a usable heading the horizontal Earth rate is a vector of known length and unknown direction; without a latitude nothing but its size is known.
  for (Index i = 0; i < priors; ++i) {
    const bool is_vertical = vertical && i == 0;
    const Index horizontal = i - (vertical ? 1 : 0);
    const double sigma = latitude_ ? std::max(earth_rate * std::cos(*latitude_) / std::sqrt(2.0), 1e-3 * earth_rate) : earth_rate / std::sqrt(3.0);
    c.value[row] = is_vertical ? earth_up_ : earth_horizontal_[static_cast<std::size_t>(horizontal / 2)][horizontal % 2];
    c.jacobian(row, coefficients + i) = 1;
    Conditions::Block block;
    block.first = row++;
    block.size = 1;
    block.covariance.setConstant(1, 1, sigma * sigma);
    c.blocks.push_back(std::move(block));
  }
  c.variance.resize(rows);
  for (const Conditions::Block& block : c.blocks) c.variance.segment(block.first, block.size) = block.covariance.diagonal();
  return c;
}

/// |f| - g = 0.
void HandheldProblem::add_gravity_row(Conditions& c, Index row, std::size_t k) const {
  const Rest& rest = rests_[k];
  const Vector3d force = force_at(rest), up = force.normalized();
  const Vector3d v = (rest.accel - scaling_.accel_center).cwiseQuotient(scaling_.accel_scale);
  c.value[row] = force.norm() - gravity_;
  c.kind[static_cast<std::size_t>(row)] = ConditionKind::gravity;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& coefficient = coefficient_table()[static_cast<std::size_t>(indices_[i])];
    if (coefficient.triad != Triad::accel) continue;
    c.jacobian(row, static_cast<Index>(i)) = up[coefficient.row] * (coefficient.term == Term::offset ? 1.0 : v[coefficient.column]);
  }
}

/// W0 + W1 v + C f - C_bn w_ie = 0. That the force turns C_bn and enters C f is of second order: w_ie and C are small.
void HandheldProblem::add_gyro_rows(Conditions& c, Index row, std::size_t k) const {
  const Rest& rest = rests_[k];
  const Vector3d force = force_at(rest);
  const Vector3d v = (rest.gyro - scaling_.gyro_center).cwiseQuotient(scaling_.gyro_scale);
  const Matrix3d C_bn = C_nb_[k].transpose();
  c.value.segment<3>(row) = model_.gyro.offset + model_.gyro.matrix * v + model_.g_sensitivity * force - C_bn * earth_rate_of(k);
  for (Index r = 0; r < 3; ++r) c.kind[static_cast<std::size_t>(row + r)] = ConditionKind::gyro_rest;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& coefficient = coefficient_table()[static_cast<std::size_t>(indices_[i])];
    if (coefficient.triad != Triad::gyro) continue;
    const double basis = coefficient.term == Term::offset ? 1.0 : coefficient.term == Term::matrix ? v[coefficient.column] : force[coefficient.column];
    c.jacobian(row + coefficient.row, static_cast<Index>(i)) = basis;
  }
  if (!latitude_) c.jacobian.block<3, 1>(row, static_cast<Index>(indices_.size())) = -C_bn.col(2);
  c.jacobian.block<3, 2>(row, earth_column(indices_.size(), !latitude_, stretch_[k])) = -C_bn.leftCols<2>();
}

/// Up before the rotation, carried by the gyros, against up after it, in the plane across it (Tedaldi 2014). While the unit turns, so does the Earth.
void HandheldProblem::add_rotation_rows(Conditions& c, Index row, std::size_t k) const {
  const IntegratedRotation& rotation = links_[k].now;
  const Rest &rest = rests_[k], &next = rests_[k + 1];
  const Vector3d force = force_at(rest), up = force.normalized(), next_force = force_at(next), next_up = next_force.normalized();
  const Matrix3d C_next = rotation.C.transpose(), C_bn = C_nb_[k].transpose();
  const Vector3d turned_up = up + C_bn * (rotation_exp(rotation.duration_s * earth_rate_of(k)) * up_n - up_n);
  const Eigen::Matrix<double, 2, 3> basis = tangent_basis(next_up).transpose();
  const Eigen::Matrix<double, 2, 3> on_up = basis * C_next * (Matrix3d::Identity() - up * up.transpose()) / force.norm();
  const Eigen::Matrix<double, 2, 3> on_next_up = -basis / next_force.norm();
  const Eigen::Matrix<double, 2, 3> on_rotation = basis * C_next * skew<double>(turned_up);
  const Vector3d v = (rest.accel - scaling_.accel_center).cwiseQuotient(scaling_.accel_scale);
  const Vector3d next_v = (next.accel - scaling_.accel_center).cwiseQuotient(scaling_.accel_scale);

  c.value.segment<2>(row) = basis * (C_next * turned_up - next_up);
  for (Index r = 0; r < 2; ++r) c.kind[static_cast<std::size_t>(row + r)] = ConditionKind::rotation;
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& coefficient = coefficient_table()[static_cast<std::size_t>(indices_[i])];
    const bool offset = coefficient.term == Term::offset;
    auto target = c.jacobian.col(static_cast<Index>(i)).segment<2>(row);
    if (coefficient.triad == Triad::accel) {
      target = on_up.col(coefficient.row) * (offset ? 1.0 : v[coefficient.column]) + on_next_up.col(coefficient.row) * (offset ? 1.0 : next_v[coefficient.column]);
    } else {
      const int integral = offset ? 0 : coefficient.term == Term::matrix ? 1 + coefficient.column : 4 + coefficient.column;
      target = on_rotation * rotation.phi[static_cast<std::size_t>(integral)].col(coefficient.row);
    }
  }
  const Eigen::Matrix<double, 2, 3> on_earth = -rotation.duration_s * basis * C_next * C_bn * skew<double>(up_n);
  if (!latitude_) c.jacobian.block<2, 1>(row, static_cast<Index>(indices_.size())) = on_earth.col(2);
  c.jacobian.block<2, 2>(row, earth_column(indices_.size(), !latitude_, stretch_[k])) = on_earth.leftCols<2>();
}

Eigen::VectorXd HandheldProblem::prior_sigma() const {
  const Index unknowns = earth_column(indices_.size(), !latitude_, earth_horizontal_.size());
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(unknowns, earth_rate);
  sigma.head(sigma_.size()) = sigma_;
  return sigma;
}

void HandheldProblem::pin(const std::vector<char>& determined) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    if (!determined[i]) sigma_[static_cast<Index>(i)] *= 1e-6;
}

void HandheldProblem::correct(const Eigen::VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
  if (!latitude_) earth_up_ += correction[static_cast<Index>(indices_.size())];
  for (std::size_t s = 0; s < earth_horizontal_.size(); ++s) earth_horizontal_[s] += correction.segment<2>(earth_column(indices_.size(), !latitude_, s));
}

std::vector<HandheldProblem::RotationRows> HandheldProblem::rotation_rows(const Conditions& conditions) const {
  std::vector<RotationRows> rows;
  for (std::size_t k = 0; k < links_.size(); ++k)
    if (links_[k].usable) rows.push_back({{conditions.blocks[k].first + 4, conditions.blocks[k].first + 5}, rotation_log(links_[k].now.C).norm()});
  return rows;
}

// Suspects: every rest, then every link.
std::vector<Suspect> HandheldProblem::suspects(const Conditions& conditions) const {
  std::vector<Suspect> all;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    Suspect suspect{fmt::format("the rest at {:.1f} s", rests_[k].mid_s), {}};
    for (Index r = 0; r < conditions.blocks[k].size; ++r) suspect.rows.push_back(conditions.blocks[k].first + r);
    if (k > 0 && links_[k - 1].usable)
      for (const Index r : {4, 5}) suspect.rows.push_back(conditions.blocks[k - 1].first + r);
    all.push_back(std::move(suspect));
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    Suspect suspect{fmt::format("the rotation between {:.1f} s and {:.1f} s", rests_[k].mid_s, rests_[k + 1].mid_s), {}};
    if (links_[k].usable) suspect.rows = {conditions.blocks[k].first + 4, conditions.blocks[k].first + 5};
    all.push_back(std::move(suspect));
  }
  return all;
}

void HandheldProblem::drop(int suspect) {
  const auto k = static_cast<std::size_t>(suspect);
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

void HandheldProblem::estimate_only(std::vector<int> indices) {
  for (const int index : indices_)
    if (std::find(indices.begin(), indices.end(), index) == indices.end()) set_coefficient(model_, index, 0.0);
  indices_ = std::move(indices);
  sigma_ = prior_.sigmas(indices_, gravity_);
}

}  // namespace imulab
