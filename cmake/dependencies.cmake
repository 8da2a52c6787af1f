# Libraries that imulab links, for its own build and for every consumer of the package. The Debian packages are in dependencies.txt.
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(PkgConfig REQUIRED)
if(NOT DEFINED IMULAB_TARGETS OR "files" IN_LIST IMULAB_TARGETS) # what imulab::files links besides
  find_package(tomlplusplus REQUIRED)
  find_package(ZLIB REQUIRED)
  pkg_check_modules(libdeflate REQUIRED IMPORTED_TARGET libdeflate)
  find_package(yaml-cpp REQUIRED)
endif()
