// The conditions of a handheld calibration: gravity and the Earth's rate at every rest, and the direction of gravity across every rotation.
#pragma once

#include "imulab/estimate/rests/problem.hpp"
#include "imulab/estimate/rests/stillness.hpp"
#include "imulab/estimate/rests/turns.hpp"
#include "imulab/navigation/integration/integrated_rotation.hpp"

#include <optional>
#include <vector>

namespace imulab::rests {

/// Unknowns: the coefficients `indices` of the scaled model, then the Earth's rate in east-north-up axes: its vertical part if the latitude is
/// unknown, and for each stretch of rests linked by rotations its horizontal part, relative to an arbitrary heading of the first rest. Then the
/// gyros' rounding if all rests share it: equal rates within one step are rounded in the same way, which does not average out.
class HandheldProblem : public RestProblem {
 public:
  /// Uses a turn if it is the only one between two rests. Throws Error if the gyros of `start.model` contradict a turn.
  HandheldProblem(const Recording& recording, const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices,
                  const std::vector<DeclaredTurn>& turns = {});

  Conditions conditions(const Spreads& spreads);
  kernel::Parameters parameters() const;
  Eigen::VectorXd longest_step() const;
  void correct(const Eigen::VectorXd& correction);
  /// Returns every rest, then every rotation.
  std::vector<SuspectRows> suspects(const Conditions& conditions) const;
  /// Leaves out a rotation, or a rest (the rotations before and after it become one).
  void drop(std::size_t suspect);
  /// Restricts the estimate to the rests until release().
  void leave_out_rotations();
  void release();

  /// Moves the problem to the same latitude on the other side of the equator.
  void mirror_latitude() { latitude_ = -*latitude_, earth_up_ = -earth_up_; }

  /// Adds a turn about `axis` (body axes) by `angle` [rad] and a rest of `rest_s`, with the noise of the other rests, to compute the information of a
  /// future rest. The problem must not be corrected or reduced afterwards.
  void extend(const Vector3d& axis, double angle, double rest_s);
  /// Returns the up direction at the last rest in body axes.
  Vector3d last_up() const { return force_at(rests_.back()).normalized(); }

  std::size_t rotations() const;
  std::size_t turns(bool refused = false) const;  ///< number of turns with a declared angle: used, or refused as outliers
  struct RotationRows {
    std::size_t block;   ///< block of the rest before the rotation
    Eigen::Index first;  ///< first of its rows (two of gravity, one of a declared angle), the last rows of the block
    double angle;        ///< angle of the rotation [rad]
  };
  /// Returns the rows of each rotation in `conditions`, in time order.
  std::vector<RotationRows> rotation_rows(const Conditions& conditions) const;

 private:
  struct Link {  ///< from one rest to the next
    bool usable = false;
    bool refused = false;  ///< rejected as an outlier
    std::optional<DeclaredTurn> turn{};
    IntegratedRotation rotation{};
    std::optional<SensorModel> at{};  ///< the model with which `rotation` was integrated
    IntegratedRotation now{};         ///< rotation for the present model
  };
  using ByRotation = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 3, 3>;
  /// Up before a rotation, propagated by the gyros, minus up after it, in the plane of `basis` across the latter. The derivatives refer to the force
  /// before and after the rotation; derivatives with respect to the rotation have an additional row for a declared angle.
  struct Carried {
    Vector3d difference;
    Eigen::Matrix<double, 2, 3> basis, difference_by_force, difference_by_next_force;
    ByRotation rows_by_rotation;
  };
  void relink();
  void add_turns(const std::vector<DeclaredTurn>& turns);
  void integrate();
  void follow_attitudes();
  bool linked(std::size_t rest) const { return rest < links_.size() && links_[rest].usable; }  ///< linked to the next rest
  bool turned(std::size_t rest) const { return linked(rest) && links_[rest].turn; }
  Eigen::Index rotation_rows_after(std::size_t rest) const { return (linked(rest) ? 2 : 0) + (turned(rest) ? 1 : 0); }
  Vector3d swept(const Link& link) const;
  Vector3d earth_rate_of(std::size_t rest) const;
  Carried carried(std::size_t k) const;
  void add_rest_rows(Conditions& c, Eigen::Index row, std::size_t k) const;
  void add_rotation_rows(Conditions& c, Eigen::Index row, std::size_t k) const;
  CovarianceBlock block_of(Eigen::Index row, std::size_t k, const Spreads& spreads) const;
  Eigen::Index earth_column(std::size_t stretch) const;
  Eigen::Index rounding_column() const { return earth_column(earth_horizontal_.size()); }
  IntegratedRotation integrated(const Recording& recording, Range range, const Vector3d& sigma) const;
  Eigen::VectorXd large_rate_effects() const;
  /// Returns the rotation at the present model, corrected by a small angle and by the effects.
  Matrix3d corrected(const IntegratedRotation& rotation, const Vector3d& angle) const;
  Eigen::Index nuisances() const { return rounding_column() + 3 - std::ssize(indices_); }
  Vector3d rounding_in_common() const;

  const Recording* recording_;
  std::optional<kernel::RecordedStates> recorded_;  ///< present with effects
  bool rests_alone_ = false;
  std::vector<Link> links_;           ///< links_[k] leads from rest k to rest k + 1
  std::vector<std::size_t> stretch_;  ///< index of the stretch of each rest
  std::vector<Matrix3d> C_nb_;        ///< attitude of each rest, with headings relative to the first rest of its stretch
  Stillness stillness_;
  Vector3d turning_sigma_;                ///< sigma of a gyro sample during a turn, when rounding errors are independent
  Vector3d common_rounding_;              ///< standard deviation; zero if the rests do not share the rounding
  Vector3d rounding_ = Vector3d::Zero();  ///< the shared rounding
  double earth_up_ = 0;
  std::vector<Eigen::Vector2d> earth_horizontal_;  ///< east, north, for each stretch
};

/// Returns true for parts of rests, all in one attitude, in which the temperature changes: they show the gyros' biases, and how all biases follow the
/// temperature. Throws Unsupported if the gyros do not vary.
bool sweeps_in_one_attitude(const coarse::RestStart& start, const Recording& recording);

/// Calibrates from rests and the rotations between them, in the name of a method.
CalibrationResult calibrate_with_links(const CalibrationInput& input, const CalibrationOptions& options, std::string_view method,
                                       coarse::RestStart start);

}  // namespace imulab::rests
