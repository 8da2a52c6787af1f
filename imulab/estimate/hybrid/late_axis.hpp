// An axis whose readings come a sample after those of the others: by a filter of its own, or a register that is read too soon. In turns it looks like
// misalignments, a g-sensitivity or another latitude, and none of them fits.
#pragma once

#include "imulab/estimate/hybrid/iteration.hpp"

#include <cstddef>
#include <optional>
#include <string>

namespace imulab::hybrid {

struct LateAxis {
  std::size_t axis = 0;            ///< 0 to 2: gyros, 3 to 5: accelerometers
  int samples = 0;                 ///< late; -1: early
  double scatter = 0, before = 0;  ///< of the velocities over what the noise explains, with the axis put right and as it is
};

/// The axis that explains most of what the converged solution does not; nothing where the velocities fit, or no axis halves their scatter.
std::optional<LateAxis> late_axis(const Data& data, const Iterate& converged);

/// The recording with that axis put right.
Recording put_right(Recording recording, const LateAxis& late);

/// What it was, for the user.
std::string text_of(const LateAxis& late);

}  // namespace imulab::hybrid
