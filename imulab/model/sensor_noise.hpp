// The noise terms of one sensor axis as samples: means over the sample's interval, each term from random streams of its own.
#pragma once

#include "imulab/core/random.hpp"
#include "imulab/model/flicker.hpp"
#include "imulab/model/noise.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace imulab {

/// Flicker is the sum of processes of model/flicker.hpp, with the power of means over the sample's interval to within 2 % from 10^5 intervals to half
/// the sample rate. It begins in its stationary state; the rate random walk begins at zero.
class AxisNoise {
 public:
  /// `purpose` names the streams, as in "gyro.x noise of recording.csv".
  AxisNoise(const NoiseModel& model, double interval_s, std::uint64_t seed, const std::string& purpose);

  /// Whether there are terms with a memory, or constant ones.
  bool slow() const;
  /// Adds turn-on bias, ramp, flicker and random walk to a whole recording, sample after sample.
  void add_slow(std::span<double> recording) const;
  /// Adds white and quantization noise to samples begin and following: any part of a recording independently.
  void add_fast(std::size_t begin, std::span<double> out) const;

 private:
  Flicker::Array stationary_draw() const;

  NoiseModel model_;
  double interval_s_;
  double bias_, ramp_;             // of this recording
  std::array<double, 4> direct_;   // of the flicker: weights of the last draws
  Flicker::Array decay_, driven_;  // of the flicker, a sample on
  RandomStream white_, quantization_, flicker_, walk_, start_;
};

}  // namespace imulab
