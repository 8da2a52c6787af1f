// What this library was built with.
#pragma once

#include <string>
#include <vector>

namespace imulab {

/// A library that imulab can be built without.
struct BuildOption {
  std::string name, purpose;  // "LZ4", "bags compressed with LZ4"
  bool built_with = false;
};

struct Build {
  std::string version, compiler, type, processor;  // "0.1.0", "GNU 12.2.0", "Release", "x86_64"
  std::vector<BuildOption> options;
};

Build build();

}  // namespace imulab
