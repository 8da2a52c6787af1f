// The build that a test program tests: the tests are compiled once, and linked with the library as it is and with the library under sanitizers.
#pragma once

#include <string>

namespace imulab {

/// The command of the same build as the library of this program.
std::string command_path();
bool under_sanitizers();

}  // namespace imulab
