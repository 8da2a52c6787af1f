// Recordings one after the other, a file each: one face of a box, one attitude, one part of a long log.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/signals.hpp"

#include <vector>

namespace imulab::inspection {

/// True for tables of different files whose columns have the same names, if these name gyros and accelerometers, or if no time is common to two of
/// them. Else they are parts of one recording, which `joined` joins by time.
bool are_pieces(const std::vector<SignalTable>& tables, const Declarations& declared = {});

/// All rows as one table, in the order of the files' first stamps. Where a file's clock does not begin after the one before, its stamps are moved
/// there: what is asked of such a table, rests and turns inside the files, does not depend on it.
SignalTable appended(std::vector<SignalTable> tables, const Declarations& declared = {});

}  // namespace imulab::inspection
