// Stamps that repeat because they were written with few digits: their rows are taken at equal spacing.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/signals.hpp"

#include <cstdint>
#include <span>

namespace imulab::inspection {

/// Where stamps repeat on rows with different readings, and advance at one rate in the large: declares the rows to be evenly spaced at it, and says
/// so. Where they do not keep one rate, it asks. Nothing where no stamps repeat, or the rows that share one are equal.
void take_even_rows(const SignalTable& table, std::span<const std::int64_t> time_ns, Inspection& result);

}  // namespace imulab::inspection
