# What the library links, for its own build and for every consumer of the package. The Debian packages are in dependencies.txt.
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(GeographicLib REQUIRED IMPORTED_TARGET geographiclib) # its Find module gives no target in Debian 12

# The libraries of some recording formats are used where they are found, unless IMULAB_WITH_... says otherwise. A package says it by what it was built with.
foreach(library HDF5 MATIO)
  set(IMULAB_${library}_REQUIRED)
  if(IMULAB_WITH_${library})
    set(IMULAB_${library}_REQUIRED REQUIRED)
  endif()
endforeach()
if(NOT DEFINED IMULAB_WITH_HDF5 OR IMULAB_WITH_HDF5)
  pkg_check_modules(hdf5 ${IMULAB_HDF5_REQUIRED} IMPORTED_TARGET hdf5)
endif()
if(NOT DEFINED IMULAB_WITH_MATIO OR IMULAB_WITH_MATIO)
  pkg_check_modules(matio ${IMULAB_MATIO_REQUIRED} IMPORTED_TARGET matio)
endif()
