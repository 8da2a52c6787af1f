// The latitude from gyros at rest, without any turn: the Earth's rate along gravity and across it.
#pragma once

#include "imulab/recording/rest_means.hpp"
#include "imulab/sensor_model.hpp"

#include <optional>
#include <vector>

namespace imulab::hybrid {

/// A latitude from the gyros' measurement of the Earth's rate [rad].
struct SeenLatitude {
  double value, sigma;
};

/// The uncertainty of the gyros at rest.
struct GyrosAtRest {
  double noise;          ///< lower bound [rad/s/sqrt(Hz)]
  double scale;          ///< relative standard deviation of their scales
  double g_sensitivity;  ///< g-sensitivity common to all axes [rad/s/(m/s^2)]: it resembles the Earth's rate along gravity
  double gravity;        ///< m/s^2
};

/// At rest in attitude k, with up u_k and the rate w_k: w_k . u_k = W sin L + b . u_k gives the offset b (Cheng 2014 eq 11, with known scales), and
/// |w_k - b|^2 across u_k is (W cos L)^2 plus noise. Their scatter is used if it exceeds the noise. Returns the latitude that fits both best if it is
/// five standard deviations more likely than any within `declared` +/- 3 `declared_sigma` [rad]. Returns nothing if the rests are too few, too
/// similar, or fit no latitude.
std::optional<SeenLatitude> latitude_against(double declared, double declared_sigma, const std::vector<RestMeans>& rests, const SensorModel& model,
                                             const GyrosAtRest& gyros);

}  // namespace imulab::hybrid
