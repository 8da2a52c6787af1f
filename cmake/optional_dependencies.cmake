# Libraries that not every user needs: used where they are found, unless IMULAB_WITH_... is OFF. A program that is linked with a static library of
# imulab needs those that this one was built with. Name; module of pkg-config, or CMake's package; its target; what needs it; its Debian package;
# how pkg-config names it, or the linker; what is linked with it: the target imulab or files, or the program imulab-read.
set(IMULAB_OPTIONAL_DEPENDENCIES
    "TBB|TBB|TBB::tbb|work on several threads|libtbb-dev|tbb|imulab"
    "LZ4|liblz4|PkgConfig::IMULAB_LZ4|bags compressed with LZ4|liblz4-dev|liblz4|files"
    "ZSTD|libzstd|PkgConfig::IMULAB_ZSTD|bags compressed with Zstandard|libzstd-dev|libzstd|files"
    "BZIP2|BZip2|BZip2::BZip2|bags compressed with bzip2|libbz2-dev|-lbz2|files"
    "ARCHIVE|libarchive|PkgConfig::IMULAB_ARCHIVE|archives other than zip, and texts compressed otherwise than by gzip|libarchive-dev|libarchive|files"
    "SQLITE|sqlite3|PkgConfig::IMULAB_SQLITE|ROS 2 bags in SQLite, fleet stores|libsqlite3-dev|sqlite3|files"
    "HDF5|hdf5|PkgConfig::IMULAB_HDF5|recordings in HDF5|libhdf5-dev|hdf5|imulab-read"
    "MATIO|matio|PkgConfig::IMULAB_MATIO|recordings in MATLAB files|libmatio-dev|matio|imulab-read"
    "SECCOMP|libseccomp|PkgConfig::IMULAB_SECCOMP|sandbox of HDF5 and MATLAB files|libseccomp-dev|libseccomp|imulab-read")

macro(imulab_find_optional name module target required)
  if("${target}" MATCHES "^PkgConfig::")
    pkg_check_modules(IMULAB_${name} ${required} IMPORTED_TARGET ${module})
  else()
    find_package(${module} ${required})
  endif()
endmacro()

foreach(dependency IN LISTS IMULAB_OPTIONAL_DEPENDENCIES)
  string(REPLACE "|" ";" dependency "${dependency}")
  list(GET dependency 0 name)
  list(GET dependency 1 module)
  list(GET dependency 2 target)
  list(GET dependency 3 what)
  if(DEFINED IMULAB_BUILT_WITH)
    list(GET dependency 6 linked_with)
    if(name IN_LIST IMULAB_BUILT_WITH AND linked_with IN_LIST IMULAB_TARGETS)
      imulab_find_optional(${name} ${module} ${target} REQUIRED)
    endif()
    continue()
  endif()
  option(IMULAB_WITH_${name} "${what}" ON)
  if(IMULAB_WITH_${name})
    imulab_find_optional(${name} ${module} ${target} QUIET)
  endif()
endforeach()

# Tells the given sources, which are units of their own, what was found. IMULAB_BUILT_WITH: its names. IMULAB_BUILD_OPTIONS: rows for
# cmake/build.cpp.in. For each of imulab, files and read, X: IMULAB_X_WITH, names; IMULAB_X_OPTIONAL, targets to link; IMULAB_X_PACKAGES, Debian's;
# IMULAB_X_MODULES and IMULAB_X_LIBRARIES, for pkg-config.
macro(imulab_tell_of_optional_dependencies)
  foreach(dependency IN LISTS IMULAB_OPTIONAL_DEPENDENCIES)
    string(REPLACE "|" ";" dependency "${dependency}")
    list(GET dependency 0 name)
    list(GET dependency 2 target)
    list(GET dependency 3 what)
    list(GET dependency 4 package)
    list(GET dependency 5 linked)
    list(GET dependency 6 linked_with)
    string(REGEX REPLACE "^imulab-" "" linked_with "${linked_with}")
    string(TOUPPER "${linked_with}" linked_with)
    if(IMULAB_WITH_${name} AND TARGET ${target})
      list(APPEND IMULAB_${linked_with}_WITH ${name})
      list(APPEND IMULAB_${linked_with}_OPTIONAL ${target})
      list(APPEND IMULAB_${linked_with}_PACKAGES ${package})
      if("${linked}" MATCHES "^-l")
        string(APPEND IMULAB_${linked_with}_LIBRARIES " ${linked}")
      else()
        string(APPEND IMULAB_${linked_with}_MODULES " ${linked}")
      endif()
      if(NOT linked_with STREQUAL "READ")
        set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_DEFINITIONS IMULAB_WITH_${name})
        list(APPEND IMULAB_BUILT_WITH ${name})
      endif()
      string(APPEND IMULAB_BUILD_OPTIONS "              {\"${name}\", \"${what}\", true},\n")
    else()
      string(APPEND IMULAB_BUILD_OPTIONS "              {\"${name}\", \"${what}\", false},\n")
      message(STATUS "Without ${name}: no ${what}")
    endif()
  endforeach()
endmacro()
