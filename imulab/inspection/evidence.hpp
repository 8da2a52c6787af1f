// The evidence of an inspection: the pair of triads that the data, or else the names, speak for, and what the data can support.
#pragma once

#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/inspection/time.hpp"
#include "imulab/inspection/triads.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace imulab::inspection {

/// True if the names of all three columns give this role.
bool has_role(const SignalTable& table, const SignalTriad& triad, Role role);

/// The table, or `own` with the sums of gravity and the acceleration without it, where a filter's parts stand for the accelerometers.
const SignalTable& with_sums(const SignalTable& table, SignalTable& own);

/// Which columns are which triad; nothing where neither the data nor the names tell. Open questions are added to `result`.
std::optional<TriadEvidence> find_triads(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TimeGuess& time,
                                         const DeclaredColumns& declared, const std::vector<double>& scales, Inspection& result);

/// Adds the rests, the readings' quality and the methods.
void add_support(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TriadEvidence& triads, Inspection& result);
/// Adds what was found of the clock.
void add_clock(const ClockQuality& clock, Inspection& result);

}  // namespace imulab::inspection
