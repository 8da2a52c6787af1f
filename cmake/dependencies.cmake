# Libraries that imulab links, for its own build and for every consumer of the package. The Debian packages are in dependencies.txt.
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(libdeflate REQUIRED IMPORTED_TARGET libdeflate)
find_package(yaml-cpp REQUIRED)
