// Recordings as pages: what an inspection found, and what a compensation wrote.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/results/compensation.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// `overview`: of the readings in SI, where the recording could be read. HTML.
std::string inspection_page(const Inspection& inspection, const std::optional<Overview>& overview);

/// HTML, self-contained. `missing`: pictures that cannot be drawn, and why.
std::string compensation_page(const CompensationSummary& summary, const std::vector<std::string>& missing = {});

}  // namespace imulab
