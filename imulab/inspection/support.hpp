// What the data can support: rests, directions, turns; and what is wrong with the readings.
#pragma once

#include "imulab/inspection/clock_quality.hpp"
#include "imulab/inspection/inspection.hpp"

namespace imulab::inspection {

/// Adds the rests, the readings' quality and the methods.
void add_support(const SignalTable& table, const TriadEvidence& triads, Inspection& result);
/// Adds what was found of the clock.
void add_clock(const ClockQuality& clock, Inspection& result);

}  // namespace imulab::inspection
