/* Not Zephyr: declarations of the few names that zephyr/src/main.c uses, so that a test on a computer can compile and run it. */
#ifndef STAND_IN_ZEPHYR_DEVICE_H
#define STAND_IN_ZEPHYR_DEVICE_H

#include <stdbool.h>

struct device {
  int reads;
};
static struct device stand_in_imu;
#define DT_ALIAS(name) name
#define DEVICE_DT_GET(node) (&stand_in_imu)
static inline bool device_is_ready(const struct device* device) { return device == &stand_in_imu; }

#endif
