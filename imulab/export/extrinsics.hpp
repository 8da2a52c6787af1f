// Extrinsics in the form of other programs.
#pragma once

#include "imulab/extrinsics.hpp"

#include <span>
#include <string>
#include <string_view>

namespace imulab {

struct ExtrinsicsTarget {
  std::string_view name;  ///< as of calibrations, where these have it
  std::string (*text)(const Extrinsics& extrinsics);
};

std::span<const ExtrinsicsTarget> extrinsics_targets();
/// Throws Error for a target that holds no extrinsics, with those that do.
std::string exported_extrinsics(const Extrinsics& extrinsics, std::string_view target);

}  // namespace imulab
