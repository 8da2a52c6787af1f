#include "imulab/recording/declared_noise.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/grade.hpp"

namespace imulab {

namespace {

NoiseModel noise_of(const std::optional<NoiseModel>& declared, const NoiseModel* of_grade, const std::optional<double>& density, NoiseTerms terms) {
  NoiseModel noise;
  if (declared)
    noise = *declared;
  else if (of_grade != nullptr && terms == NoiseTerms::full)
    noise = *of_grade;
  noise.N = density ? *density : of_grade->N;
  return noise;
}

}  // namespace

DeclaredNoise declared_noise(const ImuDeclaration& imu) {
  const Grade* const of = imu.grade ? &grade(*imu.grade) : nullptr;
  if (of == nullptr && !(imu.accel_noise_density && imu.gyro_noise_density))
    throw Error("the IMU's noise is not declared; expected the noise densities of accelerometers and gyros, or a grade");
  return {noise_of(imu.accel_noise, of ? &of->accel_noise : nullptr, imu.accel_noise_density, imu.noise),
          noise_of(imu.gyro_noise, of ? &of->gyro_noise : nullptr, imu.gyro_noise_density, imu.noise)};
}

}  // namespace imulab
