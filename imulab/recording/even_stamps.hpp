// Stamps that scatter about an even clock. A sensor samples evenly; a serial line, a busy computer or a coarse clock stamps its samples late.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <cstdint>
#include <optional>
#include <span>

namespace imulab {

/// stamp i = first_ns + i * interval_s, late by up to a few intervals.
struct EvenClock {
  double first_ns = 0, interval_s = 0;
  double scatter_s = 0;  ///< RMS of the stamps about it

  std::int64_t stamp_ns(std::size_t i) const;
};

/// The clock along the earliest stamps (a stamp can be late, not early); empty where the stamps do not support it: fewer than 200, samples missing,
/// or earliest stamps of fifty that stray by more than a quarter of an interval from one line (a clock that wanders).
std::optional<EvenClock> even_clock(std::span<const std::int64_t> time_ns);

/// The clock that is to replace the recording's stamps: if that is wanted, or by itself where they scatter by more than a twentieth of an interval.
/// Throws Error where it is wanted and the stamps do not support it.
std::optional<EvenClock> replacing_clock(const Recording& recording, Stamps wanted);

/// The recording with the stamps of that clock. Increments were divided by the nominal interval: by the clock's instead where that one was not
/// declared, but the median of stamps that scatter.
Recording with_even_stamps(Recording recording, const EvenClock& clock, bool interval_declared = true);

}  // namespace imulab
