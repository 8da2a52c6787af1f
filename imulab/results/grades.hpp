// The grades and systems of the literature, as tables.
#pragma once

#include <string>

namespace imulab {

/// Published grades and airliners' systems (Xu 2024), and the grades that a unit can be drawn from.
std::string grade_catalogue();

}  // namespace imulab
