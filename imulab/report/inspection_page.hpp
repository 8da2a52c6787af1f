// The page of an inspection: the signals, the rests, and what was recognized.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/recording/overview.hpp"

#include <optional>
#include <string>

namespace imulab {

/// `overview`: of the readings in SI, where the recording could be read. HTML.
std::string inspection_page(const Inspection& inspection, const std::optional<Overview>& overview);

}  // namespace imulab
