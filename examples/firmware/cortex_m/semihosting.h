/* Output and exit of a program on a Cortex-M through its debugger or emulator (Arm, Semihosting for AArch32 and AArch64). On a computer: stdio. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#ifdef __arm__

static inline int semihosting_call(int operation, const void* argument) {
  register int r0 __asm("r0") = operation;
  register const void* r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static inline void semihosting_write(const char* text) { (void)semihosting_call(0x04, text); } /* SYS_WRITE0 */

static inline void semihosting_exit(int code) {
  const unsigned long block[2] = {0x20026, (unsigned long)code}; /* ADP_Stopped_ApplicationExit */
  (void)semihosting_call(0x20, block);                           /* SYS_EXIT_EXTENDED */
  for (;;) {
  }
}

#else

#include <stdio.h>

static inline void semihosting_write(const char* text) { fputs(text, stdout); }

#endif

/* 32 bits in hexadecimal, and a blank. */
static inline void semihosting_write_hex(unsigned long bits) {
  char text[10];
  int i;
  for (i = 0; i < 8; ++i) text[i] = "0123456789abcdef"[(bits >> (28 - 4 * i)) & 15u];
  text[8] = ' ';
  text[9] = 0;
  semihosting_write(text);
}

#endif
