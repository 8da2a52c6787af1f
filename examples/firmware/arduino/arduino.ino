// Calibrated readings of an MPU-6050 on I2C, 100 a second. The header comes from a calibration in counts, or with
//   imulab export calibration.json --to c-header --input-accel g --accel-counts-per-unit 16384
//     --input-gyro deg/s --gyro-counts-per-unit 131 -o imu_calibration.h
#define IMULAB_REAL float
#include "imu_calibration.h"

#include <Wire.h>

const uint8_t imu = 0x68;

void setup() {
  Serial.begin(115200);
  Wire.begin();
  Wire.beginTransmission(imu);
  Wire.write(0x6B);  // PWR_MGMT_1: wake up
  Wire.write(0);
  Wire.endTransmission();
  if (imulab_selftest() != 0) Serial.println("the compiler's arithmetic differs");
}

static int16_t word() {
  const int high = Wire.read();
  return (int16_t)(high << 8 | Wire.read());
}

void loop() {
  float accel[3], gyro[3], force[3], rate[3];
  Wire.beginTransmission(imu);
  Wire.write(0x3B);  // ACCEL_XOUT_H: three accelerometers, temperature, three gyros
  Wire.endTransmission(false);
  Wire.requestFrom(imu, (uint8_t)14);
  for (int k = 0; k < 3; ++k) accel[k] = word();
  word();
  for (int k = 0; k < 3; ++k) gyro[k] = word();
  imulab_compensate(accel, gyro, 0, 0, force, rate);
  for (int k = 0; k < 6; ++k) {
    Serial.print(k < 3 ? force[k] : rate[k - 3], 5);
    Serial.print(k < 5 ? '\t' : '\n');
  }
  delay(10);
}
