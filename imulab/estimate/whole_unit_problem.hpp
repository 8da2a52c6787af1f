// Whole-unit calibration as least squares: at every point the compensated means have to equal the motion of the machine (Dai 2011 eqs 5, 7, 10 in
// one),
//
//   e = compensate(theta; raw, temperature) - motion(eta)
//
// with theta the coefficients and eta what many points share: g and the machines' errors, each with its declared sigma.
#pragma once

#include "imulab/estimate/whole_unit_points.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <Eigen/Core>

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace imulab {

/// An error common to several points: of g, or of a machine.
struct CommonError {
  std::string rig;  ///< its name; empty: gravity
  RigErrorSource source{};
  double sigma = 0;  ///< as declared; 0: exactly known
  double value = 0;  ///< found, beyond what is declared
  std::string name() const;
};

/// A sum of squares to second order in the correction x of theta and eta: c + 2 g.x + x.N x.
struct SquareSum {
  Eigen::MatrixXd N;
  Eigen::VectorXd g;
  double c = 0;
  int rows = 0;
  SquareSum& operator+=(const SquareSum& other);
  double at(const Eigen::VectorXd& x) const { return c + 2 * g.dot(x) + x.dot(N * x); }
};

/// What is known of a parameter without the data: held at zero sigma, free at infinite sigma.
struct Knowledge {
  Eigen::VectorXd sigma, offset;  ///< offset: the known value less the current one
};
inline constexpr double free_parameter = std::numeric_limits<double>::infinity();

struct Solution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;     ///< zero for what is held
  double chi2 = 0;                ///< of the data
  double degrees_of_freedom = 0;  ///< of the data
  double condition = 0;           ///< of the normal equations scaled to unit diagonal
};
/// Least squares of the data and of what is known. Throws Unsupported where the free parameters are not determined.
Solution solve(const SquareSum& sum, const Knowledge& known);

/// One point's residuals and derivatives, divided by the Cholesky factor of its noise.
struct PointEquations {
  Vector6d residual;                                  ///< e itself: m/s^2, rad/s
  Vector6d white;                                     ///< whitened
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;  ///< whitened, all columns
  Eigen::Matrix<double, 6, 6> factor;                 ///< Cholesky factor of the noise
};

class WholeUnitProblem {
 public:
  /// `start`: of readings less `center`.
  WholeUnitProblem(WholeUnitPoints points, const Session& session, const SensorModel& start, const Vector6d& center);

  const std::vector<int>& coefficients() const { return coefficients_; }  ///< table indices of theta, in order
  const std::vector<CommonError>& common() const { return common_; }      ///< eta, after theta
  Eigen::Index size() const { return static_cast<Eigen::Index>(coefficients_.size() + common_.size()); }
  const WholeUnitPoints& points() const { return points_; }
  const SensorModel& model() const { return model_; }
  const Vector6d& center() const { return center_; }
  const Session& session() const { return *session_; }
  RigKind kind(const WholeUnitPoint& point) const;
  std::array<double, 2> full_scale() const;  ///< the largest force and rate along an axis that the machines made, m/s^2 and rad/s

  RawSample sample(const WholeUnitPoint& point) const;
  /// The machine's motion at this point, and its derivative by eta.
  Motion motion(const WholeUnitPoint& point, Eigen::Matrix<double, 6, Eigen::Dynamic>* by_common = nullptr) const;
  PointEquations equations(const WholeUnitPoint& point) const;
  /// Of the points p with p % parts == part.
  SquareSum square_sum(std::size_t part = 0, std::size_t parts = 1) const;
  void correct(const Eigen::VectorXd& x);
  void drop(std::size_t point) { points_.points.erase(points_.points.begin() + static_cast<std::ptrdiff_t>(point)); }
  /// Variances of one sample of force and rate: the session's declared densities, or the points' own scatter with the slopes of the present model.
  void measure_noise();
  const Vector6d& noise() const { return noise_; }
  void enlarge_noise(double factor) { noise_factor_ *= factor; }
  double noise_factor() const { return noise_factor_; }
  /// The machines are again as declared.
  void forget_common();
  void set_model(const SensorModel& model) { model_ = model; }

 private:
  WholeUnitPoints points_;
  const Session* session_;
  SensorModel model_;
  Vector6d center_;
  std::vector<int> coefficients_;
  std::vector<CommonError> common_;
  std::vector<std::vector<std::size_t>> acting_;  ///< by recording: indices of eta that may act
  double gravity_;
  Vector3d rate_ie_n_;
  Vector6d noise_;           ///< (m/s^2)^2, (rad/s)^2
  double noise_factor_ = 1;  ///< of the standard deviations
};

}  // namespace imulab
