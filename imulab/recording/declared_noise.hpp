// The sensor noise that an IMU declaration has: its own terms, or those of its grade.
#pragma once

#include "imulab/model/imu_noise.hpp"
#include "imulab/recording/session.hpp"

namespace imulab {

/// For each triad: the declared terms (`accel_noise`, `accel_noise_density`), else the grade's where `imu.noise` is NoiseTerms::full, else none (0).
NoiseModels declared_terms(const ImuDeclaration& imu);

/// The same, with the grade's white noise N where no density is declared. Throws Error where there is neither a density nor a grade.
NoiseModels declared_noise(const ImuDeclaration& imu);

}  // namespace imulab
