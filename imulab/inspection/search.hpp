// The pair of triads that the data, or else the names, speak for.
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

/// Whether the names of all three columns say so.
bool has_role(const SignalTable& table, const SignalTriad& triad, Role role);

/// Which columns are which triad; nothing where neither the data nor the names tell. Open questions are added to `result`.
std::optional<TriadEvidence> find_triads(const SignalTable& table, const std::vector<std::int64_t>& time_ns, const TimeGuess& time,
                                         const DeclaredColumns& declared, const std::vector<double>& scales, Inspection& result);

}  // namespace imulab::inspection
