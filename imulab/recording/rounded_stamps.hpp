// Stamps of an even clock that were written with few digits: 400 Hz in whole milliseconds advance by 2 and by 3 ms.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace imulab {

struct RoundedStamps {
  double step_s = 0;      ///< the stamps are whole multiples of it
  double interval_s = 0;  ///< of the clock: between the two differences that there are
};

/// Of ascending stamps; nothing where they are not rounded, or not those of an even clock. Samples may be missing.
std::optional<RoundedStamps> rounded_stamps(std::span<const std::int64_t> time_ns);

}  // namespace imulab
