#include "imulab/export/c_header_parts.hpp"
#include "imulab/outlier_filter.hpp"

#include <fmt/format.h>

#include <string_view>

namespace imulab::firmware {

namespace {

/// OutlierFilter, statement by statement.
constexpr std::string_view filter_source =
    R"(/* Outliers of raw readings, replaced two samples late: spikes of one or two samples. Six readings in any order; each channel on its own. */
typedef struct {
  imulab_real window[5][6];                    /* the oldest first */
  imulab_real resolution[6];                   /* smallest difference of two readings in a row, other than zero */
  imulab_real usual[6], largest[6], second[6]; /* distance of a sample from its neighbors; while it is learned the sum, and the largest two */
  int taught[6], taken, pending; /* samples taken, up to five; those that are not given yet */
} imulab_filter;

static inline imulab_real imulab_min(imulab_real a, imulab_real b) { return b < a ? b : a; }
static inline imulab_real imulab_max(imulab_real a, imulab_real b) { return a < b ? b : a; }
static inline imulab_real imulab_size(imulab_real a) { return a < 0 ? -a : a; }

static inline void imulab_filter_init(imulab_filter* f) {
  int i, c;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 5; ++i) f->window[i][c] = 0;
    f->resolution[c] = f->usual[c] = f->largest[c] = f->second[c] = 0;
    f->taught[c] = 0;
  }
  f->taken = f->pending = 0;
}

/* Takes a sample and gives the one two earlier: its readings in `out`, and as the result the replaced channels, bit i for reading i. The first two
 * times there is none: the result is -1 and `out` stays. Until a channel has shown its noise, in @LEARNING@ windows, its readings pass as they are.
 * A reading that is no number passes, and nothing is learned from it. `out` may be `reading`. */
static inline int imulab_filter_push(imulab_filter* f, const imulab_real reading[6], imulab_real out[6]) {
  int i, c, replaced = 0;
  if (f->taken < 5) ++f->taken;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 4; ++i) f->window[i][c] = f->window[i + 1][c];
    f->window[4][c] = reading[c];
    if (f->taken > 1) {
      const imulab_real difference = imulab_size(f->window[4][c] - f->window[3][c]);
      if (difference > 0 && (!(f->resolution[c] > 0) || difference < f->resolution[c])) f->resolution[c] = difference;
    }
  }
  if (f->pending < 2) {
    ++f->pending;
    return -1;
  }
  for (c = 0; c < 6; ++c) {
    const imulab_real before2 = f->window[0][c], before = f->window[1][c], x = f->window[2][c], after = f->window[3][c], after2 = f->window[4][c];
    const imulab_real one = imulab_max(imulab_min(before2, before), imulab_min(after, after2));
    const imulab_real other = imulab_min(imulab_max(before2, before), imulab_max(after, after2));
    const imulab_real a = imulab_min(one, other), b = imulab_max(one, other); /* the middle two of the four neighbors */
    const imulab_real cubic = ((imulab_real)4 * (before + after) - (before2 + after2)) * (imulab_real)(1.0 / 6);
    const imulab_real distance = imulab_max(x - b, a - x);
    const imulab_real threshold = (imulab_real)@FACTOR@ * f->usual[c] + (imulab_real)@RESOLUTIONS@ * f->resolution[c];
    out[c] = x;
    if (f->taken < 5 || !(distance >= 0)) continue; /* between a and b: a slope */
    if (f->taught[c] < @MEMORY@) ++f->taught[c];
    if (f->taught[c] > @LEARNING@) {
      f->usual[c] += (imulab_min(distance, threshold) - f->usual[c]) / (imulab_real)f->taught[c];
      if (!(imulab_min(distance, imulab_size(x - cubic)) > threshold)) continue;
      out[c] = (imulab_real)0.5 * a + (imulab_real)0.5 * b;
      replaced |= 1 << c;
    } else { /* the largest two may be outliers */
      f->usual[c] += distance;
      f->second[c] = imulab_max(f->second[c], imulab_min(f->largest[c], distance));
      f->largest[c] = imulab_max(f->largest[c], distance);
      if (f->taught[c] == @LEARNING@) f->usual[c] = imulab_max(f->usual[c] - f->largest[c] - f->second[c], 0) / (imulab_real)(@LEARNING@ - 2);
    }
  }
  return replaced;
}

/* At the end of a recording: the last two samples as they were, in order. 0, and the sample in `out`; -1 when there is none left. Before the next
 * sample is pushed the filter needs imulab_filter_init. */
static inline int imulab_filter_flush(imulab_filter* f, imulab_real out[6]) {
  int c;
  if (f->pending == 0) return -1;
  for (c = 0; c < 6; ++c) out[c] = f->window[5 - f->pending][c];
  --f->pending;
  return 0;
}

)";

}  // namespace

std::string with_filter_constants(std::string_view source) {
  std::string out(source);
  const auto set = [&out](const std::string& name, double value) {
    for (std::size_t at = out.find(name); at != std::string::npos; at = out.find(name)) out.replace(at, name.size(), fmt::format("{:g}", value));
  };
  set("@LEARNING@", static_cast<double>(OutlierFilter::learning));
  set("@MEMORY@", OutlierFilter::memory);
  set("@FACTOR@", OutlierFilter::usual_factor);
  set("@RESOLUTIONS@", OutlierFilter::resolutions);
  return out;
}

std::string filter_text() { return with_filter_constants(filter_source); }

// The outlier filter in integers.

namespace {

/// As imulab_filter; distances are exact, what is usual has 16 bits behind the point.
constexpr std::string_view fixed_filter_source =
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

std::string fixed_filter_text() { return with_filter_constants(fixed_filter_source); }

}  // namespace imulab::firmware
