// Not Arduino: see Arduino.h beside it.
#pragma once

#include <Arduino.h>

struct TwoWire {
  int read_bytes = 0;
  void begin() {}
  void beginTransmission(uint8_t) {}
  void write(int) {}
  uint8_t endTransmission(bool = true) { return 0; }
  uint8_t requestFrom(uint8_t, uint8_t count) {
    read_bytes = 0;
    return count;
  }
  int read() { return ++read_bytes % 2 != 0 ? 0 : read_bytes / 2; }  // words 1, 2, ... 7
};
inline TwoWire Wire;
