// The true inputs of an IMU during a table's steps, as a function of every error of the table and of the site, with exact derivatives.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/rig/table_plan.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

template <class T>
struct TablePose;

/// A quantity that the true motion depends on and that is not known exactly.
struct ErrorSource {
  enum class Kind { orthogonality, zero, angle, timing, gravity, latitude, earth };
  Kind kind;
  std::string name;  ///< of the rig's as RigErrorSource::name; "gravity", "latitude", "earth_rate.north"
  double nominal;    ///< its known value: rad, s, m/s^2, rad/s
  double sigma;      ///< its standard deviation; 0: known exactly
};

class TableMotion {
 public:
  TableMotion(const TablePlan& plan, const RigDeclaration& rig, const Site& site);

  /// The rig's error sources, then gravity, then latitude, or where there is none Earth's rate north and up.
  const std::vector<ErrorSource>& sources() const { return sources_; }
  Eigen::VectorXd nominal() const;
  Eigen::VectorXd sigma() const;

  /// Six rows a part, holds first: specific force and rate of a hold, their integrals over a turn.
  Eigen::VectorXd truth(const Eigen::VectorXd& errors) const;
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& errors) const;  ///< d truth / d errors
  /// d^2 / d errors^2 of weighted sums of the truth, one for each row of `weights`.
  std::vector<Eigen::MatrixXd> curvatures(const Eigen::VectorXd& errors, const Eigen::MatrixXd& weights) const;

  std::size_t holds() const { return holds_; }
  std::size_t parts() const { return parts_.size(); }
  std::size_t turns() const { return parts() - holds_; }
  bool is_hold(std::size_t part) const { return part < holds_; }
  Eigen::Index rows() const { return row(parts()); }
  /// The place of a part among the readings: its first row, its number of rows, and the first row of its gyros.
  Eigen::Index row(std::size_t part) const { return static_cast<Eigen::Index>(is_hold(part) ? 6 * part : 3 * (part + holds_)); }
  Eigen::Index size(std::size_t part) const { return is_hold(part) ? 6 : 3; }
  Eigen::Index gyro_row(std::size_t part) const { return row(part) + (is_hold(part) ? 3 : 0); }
  /// The reading of a constant input of 1 in a part: 1 in a hold's means, the duration in a turn's sums [s].
  double gain(std::size_t part) const { return is_hold(part) ? 1 : end(part) - begin(part); }
  /// Integral over a turn of a power of its rate, without Earth's.
  double rate_moment(std::size_t turn, int power) const;
  /// A moment within a part, with its weight in the part's reading: 1 in all of a hold, the seconds of a turn.
  struct Moment {
    double time, weight;
    Vector3d force, rate;
    Matrix3d C_bn;
  };
  /// The moments of a quadrature over a part, without errors of the table: one of a hold; of a turn so many that its rate, and the directions in the
  /// body, are almost polynomials of low degree between them.
  std::vector<Moment> moments(std::size_t part) const;
  /// The specific force at these angles of the axes [rad], without errors of the table.
  Vector3d force_at(const std::array<double, 3>& angles) const;
  /// The angle of a turn.
  double angle(std::size_t turn) const { return steps_[parts_[turn].step].angle; }
  double begin(std::size_t part) const { return parts_[part].begin; }
  double end(std::size_t part) const { return parts_[part].end; }
  std::size_t step(std::size_t part) const { return parts_[part].step; }

 private:
  /// The dependence of a part's truth: each local variable is the sum of up to two sources.
  enum Local { orthogonality = 0, tilt = 6, angle_error = 8, end_error = 11, timing = 12, gravity = 13, latitude = 14, earth = 15, locals = 17 };
  struct Part {
    std::size_t step;
    double begin, end;
    std::array<int, locals> first, second;  ///< the sources whose sum it is; RigErrorIndex::none
  };
  /// Values that all parts share.
  template <class T>
  struct Surroundings;
  template <class T>
  Surroundings<T> surroundings_of(const std::array<T, locals>& e) const;
  /// The table's pose in a hold, or before a turn.
  template <class T>
  TablePose<T> pose_of(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const;
  /// A part's motion: force and Earth's rate in body axes (before a turn), and the turn.
  template <class T>
  struct BodyMotion;
  template <class T>
  BodyMotion<T> body_motion(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const;
  template <class T>
  Eigen::Matrix<T, 6, 1> truth_of(const Part& part, const Surroundings<T>& surroundings, const std::array<T, locals>& e) const;
  std::array<double, locals> local(const Part& part, const Eigen::VectorXd& errors) const;
  Eigen::Matrix<double, 6, locals> local_jacobian(const Part& part, const std::array<double, locals>& e) const;

  std::vector<Step> steps_;
  bool latitude_known_;
  std::vector<ErrorSource> sources_;
  std::vector<Part> parts_;  ///< holds, then turns
  std::size_t holds_ = 0;
};

}  // namespace imulab
