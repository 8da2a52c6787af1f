/* Runs a header's functions on samples and writes every bit of the results: on a computer and on a Cortex-M, to be compared.
 *   CALIBRATION: the header, exported with --fixed-point --q15
 *   SAMPLES: `sample_count`, double samples[][12], int32_t fixed_samples[][12] */
#include CALIBRATION
#include SAMPLES
#include "semihosting.h"

static void write_number(imulab_real x) {
  union {
    imulab_real number;
    uint32_t words[sizeof(imulab_real) / 4];
  } bits;
  int i;
  bits.number = x;
  if (x != x) semihosting_write("nan ");
  for (i = (int)(sizeof(imulab_real) / 4) - 1; i >= 0 && x == x; --i) semihosting_write_hex(bits.words[i]);
}

static void write_numbers(const char* what, int mark, const imulab_real* x) {
  int k;
  semihosting_write(what);
  semihosting_write_hex((unsigned long)mark);
  for (k = 0; k < 6; ++k) write_number(x[k]);
  semihosting_write("\n");
}

static void check_sample(const imulab_real* x) {
  imulab_real out[6];
  imulab_compensate(x, x + 3, x + 6, x + 9, out, out + 3);
  write_numbers("compensate ", imulab_out_of_range(x + 6, x + 9), out);
}

static void write_integers(const char* what, int mark, const int32_t* n) {
  int k;
  semihosting_write(what);
  semihosting_write_hex((unsigned long)mark);
  for (k = 0; k < 6; ++k) semihosting_write_hex((uint32_t)n[k]);
  semihosting_write("\n");
}

static void check_fixed(imulab_filter_fixed* filter, const int32_t* n) {
  int32_t out[6];
  int replaced;
  imulab_compensate_fixed(n, n + 3, n + 6, n + 9, out, out + 3);
  write_integers("fixed ", 0, out);
  replaced = imulab_filter_fixed_push(filter, n, out);
  if (replaced >= 0) write_integers("fixed filter ", replaced, out);
}

static void check_q15(const int32_t* n) {
  int16_t x[12], out[6];
  int32_t wide[6];
  int k;
  for (k = 0; k < 12; ++k)
    x[k] = (int16_t)(k < 6 ? n[k] : n[k] >> (k < 9 ? 16 - IMULAB_Q15_ACCEL_TEMPERATURE_BITS : 16 - IMULAB_Q15_GYRO_TEMPERATURE_BITS));
  imulab_compensate_q15(x, x + 3, x + 6, x + 9, out, out + 3);
  for (k = 0; k < 6; ++k) wide[k] = out[k];
  write_integers("q15 ", 0, wide);
}

int main(void) {
  static imulab_filter filter;
  static imulab_filter_fixed fixed_filter;
  imulab_real x[12], out[6];
  int i, k;
  imulab_filter_init(&filter);
  imulab_filter_fixed_init(&fixed_filter);
  for (i = 0; i < sample_count; ++i) {
    for (k = 0; k < 12; ++k) x[k] = (imulab_real)samples[i][k];
    check_sample(x);
    check_fixed(&fixed_filter, fixed_samples[i]);
    check_q15(fixed_samples[i]);
    k = imulab_filter_push(&filter, x, out);
    if (k >= 0) write_numbers("filter ", k, out);
  }
  while (imulab_filter_flush(&filter, out) == 0) write_numbers("flush ", 0, out);
  i = imulab_selftest();
  k = imulab_selftest_fixed() * 1000 + imulab_selftest_q15();
  semihosting_write("selftest ");
  semihosting_write_hex((unsigned long)i);
  semihosting_write_hex((unsigned long)k);
  semihosting_write("\n");
  return i != 0 || k != 0;
}
