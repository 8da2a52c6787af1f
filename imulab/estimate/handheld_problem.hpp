// The conditions of a hand-held calibration: gravity at every rest, Earth's rate at every rest, and the direction of gravity across every rotation.
#pragma once

#include "imulab/estimate/fit.hpp"
#include "imulab/estimate/rest.hpp"
#include "imulab/estimate/scaled_model.hpp"

#include <optional>

namespace imulab {

/// Unknowns: the coefficients `indices` of the scaled model, then Earth's rate in east-north-up axes: its vertical part where the latitude is
/// unknown, and for each stretch of rests linked by rotations its horizontal part, relative to an arbitrary heading of the stretch's first rest.
class HandheldProblem {
 public:
  HandheldProblem(const Recording& recording, std::vector<Rest> rests, double gravity, std::optional<double> latitude, const SampleNoise& noise,
                  const Scaling& scaling, const SensorModel& scaled_model, const Prior& prior, std::vector<int> indices);

  Conditions conditions(const Spreads& spreads);
  Eigen::VectorXd prior_sigma() const;
  void correct(const Eigen::VectorXd& correction);
  /// Coefficients that are not determined are held at their prior value from now on.
  void pin(const std::vector<char>& determined);
  std::vector<Suspect> suspects(const Conditions& conditions) const;
  /// Leaves out a rest (the rotations before and after it become one) or a rotation.
  void drop(int suspect);
  /// Other coefficients, from the present model; those no longer estimated return to zero.
  void estimate_only(std::vector<int> indices);

  const std::vector<Rest>& rests() const { return rests_; }
  const std::vector<int>& indices() const { return indices_; }
  const SensorModel& scaled_model() const { return model_; }
  std::size_t rotations() const;
  struct RotationRows {
    std::array<Eigen::Index, 2> rows;
    double angle;  ///< by which the unit turned, rad
  };
  /// Of each rotation in `conditions`, in time order.
  std::vector<RotationRows> rotation_rows(const Conditions& conditions) const;

 private:
  struct Link {  ///< the way from a rest to the next
    bool usable = false;
    bool refused = false;             ///< dropped as an outlier
    IntegratedRotation rotation{};
    std::optional<SensorModel> at{};  ///< the model `rotation` was integrated with
    IntegratedRotation now{};         ///< at the present model
  };
  void relink();
  void integrate();
  void follow_attitudes();
  void set_stretches();
  Vector3d force_at(const Rest& rest) const;
  Vector3d earth_rate_of(std::size_t rest) const;
  void add_gravity_row(Conditions& c, Eigen::Index row, std::size_t k) const;
  void add_gyro_rows(Conditions& c, Eigen::Index row, std::size_t k) const;
  void add_rotation_rows(Conditions& c, Eigen::Index row, std::size_t k) const;
  Matrix3d force_covariance(const Rest& rest, double spread) const;

  const Recording* recording_;
  std::vector<Rest> rests_;
  double gravity_;
  std::optional<double> latitude_;
  SampleNoise noise_;  ///< scaled
  Scaling scaling_;
  SensorModel model_;
  Prior prior_;
  std::vector<int> indices_;
  Eigen::VectorXd sigma_;  ///< priors' standard deviations of the coefficients
  std::vector<Link> links_;            ///< links_[k] leads from rest k to rest k + 1
  std::vector<std::size_t> stretch_;   ///< of each rest
  std::vector<Matrix3d> C_nb_;         ///< attitude of each rest; heading relative to the stretch's first
  double earth_up_ = 0;
  std::vector<Eigen::Vector2d> earth_horizontal_;  ///< east, north, by stretch
};

}  // namespace imulab
