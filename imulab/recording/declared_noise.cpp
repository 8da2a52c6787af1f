#include "imulab/recording/declared_noise.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/grade.hpp"

namespace imulab {

NoiseModels declared_terms(const ImuDeclaration& imu) {
  const Grade none{}, &of = imu.noise == NoiseTerms::full && imu.grade ? grade(*imu.grade) : none;
  NoiseModels noise{imu.accel_noise.value_or(of.accel_noise), imu.gyro_noise.value_or(of.gyro_noise)};
  noise.accel.N = imu.accel_noise_density.value_or(of.accel_noise.N);
  noise.gyro.N = imu.gyro_noise_density.value_or(of.gyro_noise.N);
  return noise;
}

NoiseModels declared_noise(const ImuDeclaration& imu) {
  if (!imu.grade && !(imu.accel_noise_density && imu.gyro_noise_density))
    throw Error("the IMU's noise is not declared; expected the noise densities of accelerometers and gyros, or a grade");
  NoiseModels noise = declared_terms(imu);
  if (!imu.accel_noise_density) noise.accel.N = grade(*imu.grade).accel_noise.N;
  if (!imu.gyro_noise_density) noise.gyro.N = grade(*imu.grade).gyro_noise.N;
  return noise;
}

}  // namespace imulab
