/* Not Zephyr: see device.h. */
#ifndef STAND_IN_ZEPHYR_KERNEL_H
#define STAND_IN_ZEPHYR_KERNEL_H

#include <stdint.h>
#include <stdio.h>

#define printk printf
static inline int32_t k_msleep(int32_t ms) { return ms - ms; }

#endif
