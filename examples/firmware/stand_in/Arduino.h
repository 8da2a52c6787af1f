// Not Arduino: declarations of the few names that arduino.ino uses, so that a test on a computer can compile and run it. Its IMU reads 1 ... 7.
#pragma once

#include <cstdint>
#include <cstdio>

using std::int16_t;
using std::uint8_t;

struct SerialPort {
  void begin(long) {}
  void println(const char* text) { std::puts(text); }
  void print(float x, int digits) { std::printf("%.*f", digits, static_cast<double>(x)); }
  void print(char c) { std::putchar(c); }
};
inline SerialPort Serial;

inline void delay(unsigned long) {}
