// What the user can mend: one exception type whose text already says where, what, and what was expected.
#pragma once

#include <stdexcept>
#include <string>

namespace imulab {

/// The input is wrong: a file, a line, a field. The command ends with exit code 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input is well formed, but the data do not support what was asked. The command ends with exit code 1.
class Unsupported : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace imulab
