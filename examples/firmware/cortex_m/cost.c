/* Instructions and stack of one function of an exported header, on QEMU with -icount shift=0, where the clock advances with each instruction.
 *   CALIBRATION: the header, exported with --fixed-point --q15
 *   FLASH_ONLY, if defined: the function alone, for its size
 *   TRACE, if defined: as much as the filters learn from, then one call that cycles.awk counts
 *   WHAT: 0 nothing, 1 imulab_compensate, 2 imulab_filter_push, 3 imulab_out_of_range, 4 imulab_compensate_fixed, 5 imulab_filter_fixed_push,
 *         6 imulab_compensate_q15 */
#include CALIBRATION
#include "semihosting.h"

enum { runs = 256, known_loops = 10000, paint = 0x5AFE5AFE };

/* Readings near zero: noise. Not constant, so that nothing is computed by the compiler. */
imulab_real readings[16][6];
imulab_real temperatures[6];
imulab_real out[6];
int32_t integers[16][6], integer_temperatures[6], integer_out[6];
int16_t short_readings[6], short_temperatures[6], short_out[6];
imulab_filter filter;
imulab_filter_fixed fixed_filter;
int result, next;

__attribute__((noinline)) void measured(void) {
#if WHAT == 1
  imulab_compensate(readings[0], readings[0] + 3, temperatures, temperatures + 3, out, out + 3);
#elif WHAT == 2
  result = imulab_filter_push(&filter, readings[next++ & 15], out);
#elif WHAT == 3
  result = imulab_out_of_range(temperatures, temperatures + 3);
#elif WHAT == 4
  imulab_compensate_fixed(integers[0], integers[0] + 3, integer_temperatures, integer_temperatures + 3, integer_out, integer_out + 3);
#elif WHAT == 5
  result = imulab_filter_fixed_push(&fixed_filter, integers[next++ & 15], integer_out);
#elif WHAT == 6
  imulab_compensate_q15(short_readings, short_readings + 3, short_temperatures, short_temperatures + 3, short_out, short_out + 3);
#else
  __asm volatile("");
#endif
}

__attribute__((noinline)) void known_end(void) { __asm volatile(""); }

#ifdef FLASH_ONLY

int main(void) {
  measured();
  return 0;
}

#else

static volatile uint32_t* const systick = (volatile uint32_t*)0xE000E010; /* control, reload, current */
extern uint32_t stack_limit[];

static void begin(void) {
  systick[1] = 0xFFFFFF;
  systick[2] = 0;
  systick[0] = 5; /* the processor's clock, no interrupt */
}

static uint32_t end(void) { return 0xFFFFFF - systick[2]; }

/* Ticks of 3 * known_loops instructions: subtract, branch, and a no-operation. */
static uint32_t ticks_of_known_loop(void) {
  uint32_t n = known_loops;
  begin();
  __asm volatile(".syntax unified\n1: nop\n subs %0, #1\n bne 1b" : "+l"(n) : : "cc");
  return end();
}

static uint32_t painted_stack(void) {
  uint32_t *p, *top;
  __asm volatile("mov %0, sp" : "=r"(top));
  for (p = stack_limit; p < top; ++p) *p = paint; /* nothing lives below the stack's end: there are no interrupts */
  measured();
  for (p = stack_limit; p < top && *p == paint; ++p) {
  }
  return (uint32_t)top - (uint32_t)p;
}

static void write_decimal(const char* what, uint32_t number) {
  char text[12];
  int at = 11;
  text[at] = 0;
  do {
    text[--at] = (char)('0' + number % 10);
    number /= 10;
  } while (number != 0);
  semihosting_write(what);
  semihosting_write(text + at);
}

int main(void) {
  uint32_t random = 1, known, ticks, stack;
  int i, k;
  for (i = 0; i < 16; ++i)
    for (k = 0; k < 6; ++k) {
      random = random * 1664525u + 1013904223u;
      integers[i][k] = (int32_t)(random >> 20);
      readings[i][k] = (imulab_real)integers[i][k] * (imulab_real)0.001;
    }
  for (i = 0; i < 6; ++i) {
    temperatures[i] = (imulab_real)25.5;
    integer_temperatures[i] = 1000000;
    short_readings[i] = (int16_t)integers[0][i];
    short_temperatures[i] = 4000;
  }
  imulab_filter_init(&filter);
  imulab_filter_fixed_init(&fixed_filter);
#ifdef TRACE
  for (i = 0; WHAT >= 1 && i < (WHAT == 2 || WHAT == 5 ? 100 : 1); ++i) measured();
  known_end();
  return 0;
#endif
  for (i = 0; i < 200; ++i) measured();
  stack = painted_stack();
  known = ticks_of_known_loop();
  begin();
  for (i = 0; i < runs; ++i) measured();
  ticks = end();
  write_decimal("", (uint32_t)((uint64_t)ticks * 3 * known_loops / known / runs));
  write_decimal(" ", stack);
  semihosting_write("\n");
  return 0;
}

#endif
