// A file that is something else than the JSON that is expected.
#pragma once

#include "imulab/error.hpp"

namespace imulab {

/// Its text does not even begin as JSON.
class NotJson : public Error {
 public:
  using Error::Error;
};

}  // namespace imulab
