# Libraries that not every user needs: used where they are found, unless IMULAB_WITH_... is OFF. A consumer of the package needs those that it was
# built with (IMULAB_BUILT_WITH), since the library is static. Name; module of pkg-config, or CMake's package; its target; what needs it;
# its Debian package; how pkg-config names it, or the linker; "imulab-read" where that program alone is linked with it.
set(IMULAB_OPTIONAL_DEPENDENCIES
    "TBB|TBB|TBB::tbb|work on several threads|libtbb-dev|tbb"
    "LZ4|liblz4|PkgConfig::IMULAB_LZ4|bags compressed with LZ4|liblz4-dev|liblz4"
    "ZSTD|libzstd|PkgConfig::IMULAB_ZSTD|bags compressed with Zstandard|libzstd-dev|libzstd"
    "BZIP2|BZip2|BZip2::BZip2|bags compressed with bzip2|libbz2-dev|-lbz2"
    "SQLITE|sqlite3|PkgConfig::IMULAB_SQLITE|ROS 2 bags in SQLite, fleet stores|libsqlite3-dev|sqlite3"
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
    if(name IN_LIST IMULAB_BUILT_WITH)
      imulab_find_optional(${name} ${module} ${target} REQUIRED)
    endif()
    continue()
  endif()
  option(IMULAB_WITH_${name} "${what}" ON)
  if(IMULAB_WITH_${name})
    imulab_find_optional(${name} ${module} ${target} QUIET)
  endif()
endforeach()

# Tells the given sources, which are units of their own, what was found. IMULAB_BUILT_WITH: its names. IMULAB_OPTIONAL_TARGETS: what to link.
# IMULAB_BUILD_OPTIONS: rows for cmake/build.cpp.in. IMULAB_OPTIONAL_PACKAGES, _MODULES, _LIBRARIES: for the packages of the library.
# IMULAB_READ_WITH, IMULAB_READ_TARGETS: names and targets of imulab-read.
function(imulab_tell_of_optional_dependencies)
  foreach(dependency IN LISTS IMULAB_OPTIONAL_DEPENDENCIES)
    string(REPLACE "|" ";" dependency "${dependency}")
    list(GET dependency 0 name)
    list(GET dependency 2 target)
    list(GET dependency 3 what)
    list(GET dependency 4 package)
    list(GET dependency 5 linked)
    if(IMULAB_WITH_${name} AND TARGET ${target} AND dependency MATCHES ";imulab-read$")
      list(APPEND read_with ${name})
      list(APPEND read_targets ${target})
      string(APPEND options "              {\"${name}\", \"${what}\", true},\n")
    elseif(IMULAB_WITH_${name} AND TARGET ${target})
      list(APPEND targets ${target})
      set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_DEFINITIONS IMULAB_WITH_${name})
      list(APPEND built_with ${name})
      list(APPEND packages ${package})
      if(linked MATCHES "^-l")
        string(APPEND libraries " ${linked}")
      else()
        string(APPEND modules " ${linked}")
      endif()
      string(APPEND options "              {\"${name}\", \"${what}\", true},\n")
    else()
      string(APPEND options "              {\"${name}\", \"${what}\", false},\n")
      message(STATUS "Without ${name}: no ${what}")
    endif()
  endforeach()
  set(IMULAB_READ_WITH "${read_with}" PARENT_SCOPE)
  set(IMULAB_READ_TARGETS "${read_targets}" PARENT_SCOPE)
  set(IMULAB_BUILT_WITH "${built_with}" PARENT_SCOPE)
  set(IMULAB_OPTIONAL_TARGETS "${targets}" PARENT_SCOPE)
  set(IMULAB_BUILD_OPTIONS "${options}" PARENT_SCOPE)
  set(IMULAB_OPTIONAL_PACKAGES "${packages}" PARENT_SCOPE)
  set(IMULAB_OPTIONAL_MODULES "${modules}" PARENT_SCOPE)
  set(IMULAB_OPTIONAL_LIBRARIES "${libraries}" PARENT_SCOPE)
endfunction()
