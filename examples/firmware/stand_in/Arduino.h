// Not Arduino: declarations of the few names that arduino.ino uses, so that a test on a computer can compile and run it. Its IMU reads 1 ... 7.
#pragma once

#include <stdint.h>

extern "C" int printf(const char* format, ...);  // no header that a compiler for boards alone has not
extern "C" int puts(const char* text);
extern "C" int putchar(int character);

struct SerialPort {
  void begin(long) {}
  void println(const char* text) { puts(text); }
  void print(float x, int digits) { printf("%.*f", digits, static_cast<double>(x)); }
  void print(char c) { putchar(c); }
};
inline SerialPort Serial;

inline void delay(unsigned long) {}
