// Where the time of a picture begins. Pictures count from the first sample: a clock that counts from 1970 would leave no digits for what happens.
#pragma once

#include <string>
#include <string_view>

namespace imulab::report {

/// A stamp in a sentence: its date where it has one, else "12.5 s".
std::string stamp_and_date(double stamp);

/// A duration in a sentence: "12.5 s", from ten minutes on with minutes: "3712 s (61.9 min)".
std::string seconds_text(double duration);

/// The label of an axis of time from this stamp: "time [s]" of zero, else "time [s] from 2023-11-14T22:13:20.010Z" or "time [s] from the start,
/// at 12.5 s".
std::string time_label(double first, std::string_view unit);

}  // namespace imulab::report
