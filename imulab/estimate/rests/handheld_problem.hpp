// The conditions of a handheld calibration: gravity at every rest, Earth's rate at every rest, and the direction of gravity across every rotation.
#pragma once

#include "imulab/estimate/rests/problem.hpp"
#include "imulab/estimate/rests/stillness.hpp"
#include "imulab/estimate/rests/turns.hpp"
#include "imulab/navigation/integration/integrated_rotation.hpp"

#include <optional>
#include <vector>

namespace imulab::rests {

/// Unknowns: the coefficients `indices` of the scaled model, then Earth's rate in east-north-up axes: its vertical part where the latitude is
/// unknown, and for each stretch of rests linked by rotations its horizontal part, relative to an arbitrary heading of the stretch's first rest. Then
/// the gyros' rounding where all rests share it: the same rate to within a step, rounded the same way, does not average out over the rests.
class HandheldProblem : public RestProblem {
 public:
  /// A turn counts if it is the only one between two rests. Throws Error for one that the gyros of `start.model` contradict.
  HandheldProblem(const Recording& recording, const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices,
                  const std::vector<DeclaredTurn>& turns = {});

  Conditions conditions(const Spreads& spreads);
  kernel::Parameters parameters() const;
  Eigen::VectorXd longest_step() const;
  void correct(const Eigen::VectorXd& correction);
  /// Every rest, then every rotation.
  std::vector<SuspectRows> suspects(const Conditions& conditions) const;
  /// Leaves out a rest (the rotations before and after it become one) or a rotation.
  void drop(std::size_t suspect);
  /// Estimates from the rests alone, until release().
  void leave_out_rotations();
  void release();

  /// To the same latitude on the other side of the equator.
  void mirror_latitude() { latitude_ = -*latitude_, earth_up_ = -earth_up_; }

  /// As if the unit were turned further, about `axis` (body axes) by `angle` [rad], and then rested for `rest_s`, with the noise of the others. For
  /// the information of a rest to come: not to be corrected or dropped from after this.
  void extend(const Vector3d& axis, double angle, double rest_s);
  /// Up at the last rest, body axes.
  Vector3d last_up() const { return force_at(rests_.back()).normalized(); }

  std::size_t rotations() const;
  std::size_t turns(bool refused = false) const;  ///< with a declared angle: used, or dropped as outliers
  struct RotationRows {
    std::size_t block;   ///< of the rest before it
    Eigen::Index first;  ///< of its rows: two of gravity, one of a declared angle; the last of the block
    double angle;        ///< by which the unit turned, rad
  };
  /// The rows of each rotation in `conditions`, in time order.
  std::vector<RotationRows> rotation_rows(const Conditions& conditions) const;

 private:
  struct Link {  ///< from a rest to the next
    bool usable = false;
    bool refused = false;  ///< dropped as an outlier
    std::optional<DeclaredTurn> turn{};
    IntegratedRotation rotation{};
    std::optional<SensorModel> at{};  ///< the model `rotation` was integrated with
    IntegratedRotation now{};         ///< at the present model
  };
  using ByRotation = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 3, 3>;
  /// Up before a rotation, carried by the gyros, less up after it: in the plane of `basis`, across the latter. The derivatives of
  /// that difference are by the force before and after the rotation; those by the rotation have a row more for a turn's declared angle.
  struct Carried {
    Vector3d difference;
    Eigen::Matrix<double, 2, 3> basis, difference_by_force, difference_by_next_force;
    ByRotation rows_by_rotation;
  };
  void relink();
  void add_turns(const std::vector<DeclaredTurn>& turns);
  void integrate();
  void follow_attitudes();
  bool linked(std::size_t rest) const { return rest < links_.size() && links_[rest].usable; }  ///< to the next
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
  /// The rotation at the present model, turned by a small angle and by what the effects make of it.
  Matrix3d corrected(const IntegratedRotation& rotation, const Vector3d& angle) const;
  Eigen::Index nuisances() const { return rounding_column() + 3 - std::ssize(indices_); }
  Vector3d rounding_in_common() const;

  const Recording* recording_;
  std::optional<kernel::RecordedStates> recorded_;  ///< with effects
  bool rests_alone_ = false;
  std::vector<Link> links_;           ///< links_[k] leads from rest k to rest k + 1
  std::vector<std::size_t> stretch_;  ///< of each rest
  std::vector<Matrix3d> C_nb_;        ///< attitude of each rest; heading relative to the stretch's first
  Stillness stillness_;
  Vector3d turning_sigma_;                ///< of a gyro sample while the unit turns: its rounding errors are independent then
  Vector3d common_rounding_;              ///< standard deviation; zero where the rests do not share it
  Vector3d rounding_ = Vector3d::Zero();  ///< the shared one
  double earth_up_ = 0;
  std::vector<Eigen::Vector2d> earth_horizontal_;  ///< east, north, by stretch
};

}  // namespace imulab::rests
