// What a recording's stamps say of its clock, although single stamps come late: by medians over sixteen rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace imulab {

/// The rows' true interval [s] near the nominal one: a hundredth is nothing in one row, but a sixth of an interval in sixteen.
double clock_interval(const std::vector<std::int64_t>& time_ns, double nominal_s);

/// By how many intervals the clock is later from row i on than the rows before foretell: 0 for a late stamp, 1 for a lost row. Seen by at most
/// sixteen rows on either side, not before `begin` nor from `end` on.
double clock_step(const std::vector<std::int64_t>& time_ns, std::size_t i, double interval_s, std::size_t begin, std::size_t end);

}  // namespace imulab
