// What a table's steps make an IMU sense, as a function of every error of the table and of the site, with exact derivatives.
#pragma once

#include "imulab/estimate/table_observations.hpp"
#include "imulab/model/sensor_model.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

/// Something that the true motion depends on and that is not known exactly.
struct ErrorSource {
  enum class Kind { orthogonality, zero, angle, timing, gravity, earth };
  Kind kind;
  std::string name;  ///< "orthogonality i1", "angle of the outer axis from step 3 on"
  double nominal;    ///< its known value: rad, s, m/s^2, rad/s
  double sigma;      ///< how far it may be from there; 0: known exactly
};

/// The nine constant errors of a table, by RigAxis: (o1, o2), (m1, m2), (i1, i2), and the zero errors.
struct ConstantTableErrors {
  std::array<std::array<double, 2>, 3> orthogonality{};
  std::array<double, 3> zero{};
};

class TableMotion {
 public:
  /// Uses the steps and the intervals of `plan`, not its readings.
  TableMotion(const TableObservations& plan, const RigDeclaration& rig, const Site& site);

  /// Six orthogonalities, three zero errors, then for each axis its angle error at the start, then one for each commanded move, the duration of each
  /// turn, gravity, and Earth's rate north and up.
  const std::vector<ErrorSource>& sources() const { return sources_; }
  Eigen::VectorXd nominal() const;
  Eigen::VectorXd sigma() const;
  /// The nominal errors with these constant ones.
  Eigen::VectorXd with(const ConstantTableErrors& errors) const;

  /// Six rows a step, holds first: of a hold specific force and rate, of a turn the integrals of rate and specific force.
  Eigen::VectorXd truth(const Eigen::VectorXd& errors) const;
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& errors) const;  ///< d truth / d errors

  std::size_t holds() const { return holds_; }
  std::size_t turns() const { return parts_.size() - holds_; }
  Eigen::Index rows() const { return static_cast<Eigen::Index>(6 * holds_ + 3 * turns()); }
  double begin(std::size_t part) const { return parts_[part].begin; }
  double end(std::size_t part) const { return parts_[part].end; }
  std::size_t step(std::size_t part) const { return parts_[part].step; }

 private:
  /// A part's own errors: six orthogonalities, the three axes' angle errors, that of the turning axis at the end, duration, gravity, Earth north, up.
  static constexpr int locals = 14;
  struct Part {
    std::size_t step;
    double begin, end;
    bool rest_after;
    std::array<int, locals> first, second;  ///< the sources whose sum it is; -1 for none
  };
  template <class T>
  Eigen::Matrix<T, 6, 1> truth_of(const Part& part, const std::array<T, locals>& e) const;
  std::array<double, locals> local(const Part& part, const Eigen::VectorXd& errors) const;

  std::vector<Step> steps_;
  std::vector<ErrorSource> sources_;
  std::vector<Part> parts_;  ///< holds, then turns
  std::size_t holds_ = 0;
};

/// Readings of a unit at these errors, without noise: six rows a hold, three a turn. `truth` as TableMotion gives it.
Eigen::VectorXd readings(const TableMotion& motion, const SensorModel& model, const Eigen::VectorXd& truth);

/// Covariance of the readings from white noise with these raw covariance densities, what a hold and a turn share of their samples included.
Eigen::MatrixXd noise_covariance(const TableMotion& motion, const Matrix3d& accel_density, const Matrix3d& gyro_density);

}  // namespace imulab
