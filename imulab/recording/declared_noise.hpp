// The sensor noise that an IMU declaration has: its own terms, or those of its grade.
#pragma once

#include "imulab/model/noise.hpp"
#include "imulab/recording/session.hpp"

namespace imulab {

/// Noise of one axis of each triad, SI; the same for all three axes.
struct DeclaredNoise {
  NoiseModel accel, gyro;
};

/// For each triad: the declared terms (`accel_noise`), else the grade's, of which only white noise is taken where `imu.noise` is NoiseTerms::white;
/// the white noise N is the declared density (`accel_noise_density`), else the grade's. Throws Error where there is neither a density nor a grade.
DeclaredNoise declared_noise(const ImuDeclaration& imu);

}  // namespace imulab
