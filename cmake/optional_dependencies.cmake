# Libraries for files that not every user has: used where they are found, unless IMULAB_WITH_... is OFF. A consumer of the package needs those that it was
# built with (IMULAB_BUILT_WITH), since the library is static. Name; module of pkg-config, or CMake's package; its target; what needs it.
set(IMULAB_OPTIONAL_DEPENDENCIES
    "LZ4|liblz4|PkgConfig::IMULAB_LZ4|bags compressed with LZ4"
    "ZSTD|libzstd|PkgConfig::IMULAB_ZSTD|bags compressed with Zstandard"
    "BZIP2|BZip2|BZip2::BZip2|bags compressed with bzip2"
    "SQLITE|sqlite3|PkgConfig::IMULAB_SQLITE|ROS 2 bags in SQLite, fleet stores"
    "HDF5|hdf5|PkgConfig::IMULAB_HDF5|recordings in HDF5"
    "MATIO|matio|PkgConfig::IMULAB_MATIO|recordings in MATLAB files")

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

# Links what was found to the library, and tells the sources that follow, which are units of their own. IMULAB_BUILT_WITH: the names.
function(imulab_link_optional_dependencies library)
  foreach(dependency IN LISTS IMULAB_OPTIONAL_DEPENDENCIES)
    string(REPLACE "|" ";" dependency "${dependency}")
    list(GET dependency 0 name)
    list(GET dependency 2 target)
    list(GET dependency 3 what)
    if(IMULAB_WITH_${name} AND TARGET ${target})
      target_link_libraries(${library} PRIVATE ${target})
      set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_DEFINITIONS IMULAB_WITH_${name})
      list(APPEND built_with ${name})
    else()
      message(STATUS "Without ${name}: no ${what}")
    endif()
  endforeach()
  set(IMULAB_BUILT_WITH "${built_with}" PARENT_SCOPE)
endfunction()
