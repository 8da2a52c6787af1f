// Tables of different files or topics as one: gyros in one, accelerometers in another.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/signals.hpp"

#include <vector>

namespace imulab::inspection {

/// The first table with the columns of the others at its stamps, between theirs on straight lines; rows that not all tables cover are left out. The
/// columns of the others name their table (Signal::table), and `parts` has their places and clocks. Throws Error where a table has no stamps or they
/// have no time in common.
/// `declared`: unit of time and ticks of all tables.
SignalTable joined(std::vector<SignalTable> tables, const Declarations& declared = {});

}  // namespace imulab::inspection
