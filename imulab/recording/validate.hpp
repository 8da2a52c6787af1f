// The largest reading of any sensor.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace imulab {

/// No sensor gives more: 10,000 g, a thousand turns a second, or counts of 48 bits. `unit`: "m/s^2", "rad/s" or "count".
double largest_reading(std::string_view unit);

/// An index from 0 to 2 and a sign.
bool is_body_axis(const BodyAxis& axis);

/// Each body axis once, with its sign.
bool are_body_axes(const std::array<BodyAxis, 3>& axes);

/// Throws Error where the range is reversed or goes beyond the samples of a recording; `what` names it: "rests: range 2".
void expect_inside(const Range& range, std::size_t samples, std::string_view what);

/// Throws Error where a column has another length than the stamps, or a triad is missing: both are compensated together.
void expect_both_triads(const Recording& recording);

/// The session of these recordings: with a declaration of each in its units, where it declares none. Throws Error that lists all of it where they do
/// not match: another number than the session declares, other names, counts in place of units or the reverse.
Session declared_session(Session session, std::span<const Recording> recordings);

}  // namespace imulab
