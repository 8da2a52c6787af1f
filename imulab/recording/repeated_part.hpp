// Readings that stand in the data twice, where a logger wrote a buffer again or files were joined that overlap.
#pragma once

#include "imulab/recording.hpp"

#include <cstddef>
#include <optional>
#include <span>

namespace imulab {

/// Samples of a recording with the same readings, to the last bit, as earlier ones of the same or of another recording.
struct RepeatedPart {
  std::size_t recording = 0, of = 0;  ///< of the recordings: which repeats which
  Range samples, earlier;
  std::size_t in_all = 0;  ///< samples of all recordings that repeat earlier ones
};

inline constexpr std::size_t least_repeated = 100;  ///< samples
/// The first such part. Finds every one of twice `least_repeated` samples and more, and shorter ones down to half of that by luck. Stretches in which
/// most readings equal the one before, or that have few different ones, do not count: an IMU without noise reads the same at every rest.
std::optional<RepeatedPart> repeated_part(std::span<const Recording> recordings);

}  // namespace imulab
