/* Start of a program on a Cortex-M: vectors, memory, the floating-point unit, main, exit. */
#include "semihosting.h"
#include <stddef.h>
#include <stdint.h>

extern uint32_t data_source[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
int main(void);

void reset(void) {
  const uint32_t* from = data_source;
  uint32_t* to;
  for (to = data_begin; to < data_end; ++to) *to = *from++;
  for (to = bss_begin; to < bss_end; ++to) *to = 0;
#ifdef __ARM_FP
  *(volatile uint32_t*)0xE000ED88 |= 0xFu << 20; /* CPACR: full access to the unit */
  __asm volatile("dsb\n isb");
#endif
  semihosting_exit(main());
}

static void fault(void) {
  semihosting_write("fault\n");
  semihosting_exit(99);
}

typedef union {
  void (*handler)(void);
  uint32_t* stack;
} vector;

__attribute__((section(".vectors"), used)) const vector vectors[16] = {
    {.stack = stack_top}, {.handler = reset}, {.handler = fault}, {.handler = fault}, {.handler = fault}, {.handler = fault}, {.handler = fault}};

/* The compiler calls these for copies of structures and arrays. */
void* memcpy(void* to, const void* from, size_t size) {
  unsigned char* t = to;
  const unsigned char* f = from;
  while (size-- != 0) {
    *t++ = *f++;
    __asm volatile("" ::: "memory"); /* or the compiler calls memcpy for this loop */
  }
  return to;
}

void* memset(void* to, int value, size_t size) {
  unsigned char* t = to;
  while (size-- != 0) {
    *t++ = (unsigned char)value;
    __asm volatile("" ::: "memory");
  }
  return to;
}
