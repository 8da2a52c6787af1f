// Version and build of the compiled library: `imulab --version` shows the same. The source is made by CMake (cmake/build.cpp.in).
//
// Example:
//   const Build built = build();
//   std::printf("imulab %s by %s\n", built.version.c_str(), built.compiler.c_str());
//
// What may change from one version to the next: docs/reference/extending.md, "Stability". Safe on any thread.
#pragma once

#include <string>
#include <vector>

// Of these headers; a shared library of another major or minor version has another SONAME.
#define IMULAB_VERSION_MAJOR 0
#define IMULAB_VERSION_MINOR 1
#define IMULAB_VERSION_PATCH 0

namespace imulab {

/// A library that imulab can be built without.
struct BuildOption {
  std::string name, purpose;  // "LZ4", "bags compressed with LZ4"
  bool built_with = false;
};

struct Build {
  std::string version, compiler, type, processor;  // "0.1.0", "GNU 12.2.0", "Release", "x86_64"
  std::vector<BuildOption> options;
  std::string programs;  // where programs that others run are installed: "/usr/local/libexec"
};

Build build();

}  // namespace imulab
