/* Calibrated readings of an IMU with Zephyr's sensor API, which gives m/s^2 and rad/s:
 *   imulab export calibration.json --to c-header --input-accel m/s^2 --input-gyro rad/s -o src/imu_calibration.h */
#define IMULAB_REAL float
#include "imu_calibration.h"

#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>

static int read3(const struct device* imu, enum sensor_channel channel, float out[3]) {
  struct sensor_value v[3];
  const int problem = sensor_channel_get(imu, channel, v);
  for (int k = 0; k < 3 && problem == 0; ++k) out[k] = (float)sensor_value_to_double(&v[k]);
  return problem;
}

int main(void) {
  const struct device* const imu = DEVICE_DT_GET(DT_ALIAS(imu0));
  float accel[3], gyro[3], force[3], rate[3];
  if (!device_is_ready(imu) || imulab_selftest() != 0) return 1;
  for (; sensor_sample_fetch(imu) == 0 && read3(imu, SENSOR_CHAN_ACCEL_XYZ, accel) == 0 && read3(imu, SENSOR_CHAN_GYRO_XYZ, gyro) == 0; k_msleep(10)) {
    imulab_compensate(accel, gyro, 0, 0, force, rate);
    printk("%d %d %d um/s^2\n", (int)(force[0] * 1e6f), (int)(force[1] * 1e6f), (int)(force[2] * 1e6f));
  }
  return 1;
}
