// Calibrated readings of an MPU-6050 on I2C, 100 a second. The header comes from a calibration in counts, or with
//   imulab export calibration.json --to c-header --input-accel g --accel-counts-per-unit 16384
//     --input-gyro deg/s --gyro-counts-per-unit 131 -o imu_calibration.h
#define IMULAB_REAL float
#include "imu_calibration.h"
#include <Wire.h>

const uint8_t imu = 0x68;

void ask(uint8_t address) { Wire.beginTransmission(imu), Wire.write(address); }

void setup() {
  Serial.begin(115200);
  Wire.begin();
  ask(0x6B), Wire.write(0), Wire.endTransmission();  // PWR_MGMT_1: wake up
  if (imulab_selftest() != 0) Serial.println("the compiler's arithmetic differs");
}

void loop() {
  float in[7], force[3], rate[3];
  ask(0x3B), Wire.endTransmission(false);  // ACCEL_XOUT_H: three accelerometers, temperature, three gyros
  Wire.requestFrom(imu, (uint8_t)14);
  for (float& reading : in) reading = (int16_t)(Wire.read() << 8), reading += Wire.read();
  imulab_compensate(in, in + 4, 0, 0, force, rate);
  for (int k = 0; k < 6; ++k) Serial.print(k < 3 ? force[k] : rate[k - 3], 5), Serial.print(k < 5 ? '\t' : '\n');
  delay(10);
}
