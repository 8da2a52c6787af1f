// The outlier filter in integers.
#include "imulab/export/c_header_filter.hpp"
#include "imulab/export/c_header_parts.hpp"

#include <string_view>

namespace imulab::firmware {

namespace {

/// As imulab_filter; distances are exact, what is usual has 16 bits behind the point.
constexpr std::string_view source =
    R"(/* imulab_filter in integers, for readings as imulab_compensate_fixed takes them. A replaced reading is rounded down to an integer. */
typedef struct {
  int32_t window[5][6];
  int64_t resolution[6], usual[6], largest[6], second[6]; /* the last three times 65536 */
  int16_t taught[6], taken, pending;
} imulab_filter_fixed;

static inline int64_t imulab_fixed_min(int64_t a, int64_t b) { return b < a ? b : a; }
static inline int64_t imulab_fixed_max(int64_t a, int64_t b) { return a < b ? b : a; }
static inline int64_t imulab_fixed_size(int64_t a) { return a < 0 ? -a : a; }

static inline void imulab_filter_fixed_init(imulab_filter_fixed* f) {
  int i, c;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 5; ++i) f->window[i][c] = 0;
    f->resolution[c] = f->usual[c] = f->largest[c] = f->second[c] = 0;
    f->taught[c] = 0;
  }
  f->taken = f->pending = 0;
}

/* As imulab_filter_push. */
static inline int imulab_filter_fixed_push(imulab_filter_fixed* f, const int32_t reading[6], int32_t out[6]) {
  int i, c, replaced = 0;
  if (f->taken < 5) ++f->taken;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 4; ++i) f->window[i][c] = f->window[i + 1][c];
    f->window[4][c] = reading[c];
    if (f->taken > 1) {
      const int64_t difference = imulab_fixed_size((int64_t)f->window[4][c] - f->window[3][c]);
      if (difference > 0 && (f->resolution[c] == 0 || difference < f->resolution[c])) f->resolution[c] = difference;
    }
  }
  if (f->pending < 2) {
    ++f->pending;
    return -1;
  }
  for (c = 0; c < 6; ++c) {
    const int32_t before2 = f->window[0][c], before = f->window[1][c], x = f->window[2][c], after = f->window[3][c], after2 = f->window[4][c];
    const int64_t one = imulab_fixed_max(imulab_fixed_min(before2, before), imulab_fixed_min(after, after2));
    const int64_t other = imulab_fixed_min(imulab_fixed_max(before2, before), imulab_fixed_max(after, after2));
    const int64_t a = imulab_fixed_min(one, other), b = imulab_fixed_max(one, other);
    const int64_t distance = imulab_fixed_max(x - b, a - x) * 65536;
    const int64_t threshold = @FACTOR@ * f->usual[c] + @RESOLUTIONS@ * 65536 * f->resolution[c];
    out[c] = x;
    if (f->taken < 5 || distance < 0) continue;
    if (f->taught[c] < @MEMORY@) ++f->taught[c];
    if (f->taught[c] > @LEARNING@) {
      /* six times the distance from the cubic */
      const int64_t unlikely = imulab_fixed_size(6 * (int64_t)x - 4 * ((int64_t)before + after) + before2 + after2) * 65536;
      f->usual[c] += (imulab_fixed_min(distance, threshold) - f->usual[c]) / f->taught[c];
      if (!(distance > threshold && unlikely > 6 * threshold)) continue;
      out[c] = (int32_t)((a + b) >> 1);
      replaced |= 1 << c;
    } else {
      f->usual[c] += distance;
      f->second[c] = imulab_fixed_max(f->second[c], imulab_fixed_min(f->largest[c], distance));
      f->largest[c] = imulab_fixed_max(f->largest[c], distance);
      if (f->taught[c] == @LEARNING@) f->usual[c] = imulab_fixed_max(f->usual[c] - f->largest[c] - f->second[c], 0) / (@LEARNING@ - 2);
    }
  }
  return replaced;
}

/* As imulab_filter_flush. */
static inline int imulab_filter_fixed_flush(imulab_filter_fixed* f, int32_t out[6]) {
  int c;
  if (f->pending == 0) return -1;
  for (c = 0; c < 6; ++c) out[c] = f->window[5 - f->pending][c];
  --f->pending;
  return 0;
}

)";

}  // namespace

std::string fixed_filter_text() { return with_filter_constants(source); }

}  // namespace imulab::firmware
