// The page of extrinsics.
#pragma once

#include "imulab/extrinsics.hpp"
#include "imulab/model/conclusion.hpp"

#include <string>

namespace imulab {

/// Where the IMUs are, with pictures of their axes, and the rates of each over those of the first.
std::string extrinsics_page(const Extrinsics& extrinsics, const Conclusion& conclusion);

}  // namespace imulab
