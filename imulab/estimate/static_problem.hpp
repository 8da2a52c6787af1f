// The conditions of a static calibration: gravity's size and Earth's rate at every rest, the attitude of each rest unknown.
#pragma once

#include "imulab/estimate/fit.hpp"
#include "imulab/estimate/rest.hpp"
#include "imulab/estimate/scaled_model.hpp"

#include <optional>

namespace imulab {

/// Each rest gives |f| = g and, with the latitude, the vertical and horizontal parts of Earth's rate:
///   up . w = w_ie sin L          (Cheng 2014 eq 12)
///   |w - up (up . w)| = w_ie cos L
class StaticProblem {
 public:
  /// `latitude`: empty to leave the gyros out.
  StaticProblem(std::vector<Rest> rests, double gravity, std::optional<double> latitude, const SampleNoise& noise, const Scaling& scaling,
                const SensorModel& scaled_model, const Prior& prior, std::vector<int> indices);

  Conditions conditions(const Spreads& spreads) const;
  const Eigen::VectorXd& prior_sigma() const { return sigma_; }
  void correct(const Eigen::VectorXd& correction);
  /// Coefficients that are not determined are held at their prior value from now on.
  void pin(const std::vector<char>& determined);
  std::vector<Suspect> suspects(const Conditions& conditions) const;
  void drop(int suspect) { rests_.erase(rests_.begin() + suspect); }

  const std::vector<Rest>& rests() const { return rests_; }
  const std::vector<int>& indices() const { return indices_; }
  const SensorModel& scaled_model() const { return model_; }

 private:
  std::vector<Rest> rests_;
  double gravity_;
  std::optional<double> latitude_;
  SampleNoise noise_;  ///< scaled
  Scaling scaling_;
  SensorModel model_;
  Prior prior_;
  std::vector<int> indices_;
  Eigen::VectorXd sigma_;  ///< priors' standard deviations
};

}  // namespace imulab
