// Version and build of the compiled library, as in `imulab --version`. CMake generates the source (cmake/build.cpp.in).
//
// Example:
//   const Build built = build();
//   std::printf("imulab %s by %s\n", built.version.c_str(), built.compiler.c_str());
//
// docs/reference/extending.md, "Stability", states what may change between versions. Safe on any thread.
#pragma once

#include <string>
#include <vector>

// Version of these headers. A shared library with another major or minor version has another SONAME.
#define IMULAB_VERSION_MAJOR 0
#define IMULAB_VERSION_MINOR 1
#define IMULAB_VERSION_PATCH 0

namespace imulab {

/// An optional library of the build.
struct BuildOption {
  std::string name, purpose;  // "LZ4", "bags compressed with LZ4"
  bool built_with = false;
};

struct Build {
  std::string version, compiler, type, processor;  // "0.1.0", "GNU 12.2.0", "Release", "x86_64"
  std::vector<BuildOption> options;
  std::string programs;  // installation folder of helper programs: "/usr/local/libexec"
};

Build build();  ///< returns the build of the compiled library

}  // namespace imulab
