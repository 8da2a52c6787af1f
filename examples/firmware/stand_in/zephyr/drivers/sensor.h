/* Not Zephyr: see device.h. The sensor gives 1, 2, 3 m/s^2 and 4, 5, 6 rad/s, twice. */
#ifndef STAND_IN_ZEPHYR_SENSOR_H
#define STAND_IN_ZEPHYR_SENSOR_H

#include <stdint.h>
#include <zephyr/device.h>

struct sensor_value {
  int32_t val1, val2; /* val1 + val2 1e-6 */
};
enum sensor_channel { SENSOR_CHAN_ACCEL_XYZ = 3, SENSOR_CHAN_GYRO_XYZ = 7 };
static inline int sensor_sample_fetch(const struct device* device) {
  (void)device;
  return stand_in_imu.reads++ < 2 ? 0 : -5;
}
static inline int sensor_channel_get(const struct device* device, enum sensor_channel channel, struct sensor_value* value) {
  const int32_t first = channel == SENSOR_CHAN_ACCEL_XYZ ? 1 : 4;
  (void)device;
  for (int32_t k = 0; k < 3; ++k) value[k] = (struct sensor_value){first + k, 0};
  return 0;
}
static inline double sensor_value_to_double(const struct sensor_value* value) { return value->val1 + value->val2 * 1e-6; }

#endif
