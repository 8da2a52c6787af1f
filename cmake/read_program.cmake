# imulab-read, which alone is linked with the libraries of HDF5 and MATLAB files.
add_library(imulab_read_sandbox OBJECT apps/imulab_read/sandbox.cpp) # of the tests, too
target_include_directories(imulab_read_sandbox PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(imulab_read_sandbox PRIVATE fmt::fmt)
if("SECCOMP" IN_LIST IMULAB_READ_WITH)
  target_compile_definitions(imulab_read_sandbox PRIVATE IMULAB_WITH_SECCOMP)
  target_link_libraries(imulab_read_sandbox PUBLIC PkgConfig::IMULAB_SECCOMP)
endif()
if(NOT IMULAB_READ_WITH MATCHES "HDF5|MATIO")
  return()
endif()

# Its own sources, and those of the library that they need: it starts for each file, and has nothing else in it.
set(IMULAB_READ_SOURCES ${PROJECT_SOURCE_DIR}/apps/imulab_read/main.cpp)
foreach(needed core/memory core/nearest_name core/text recording/unit_names formats/text/file formats/text/printable formats/text/reading formats/text/reading_meter
               formats/text/several_files formats/text/unfinished formats/recording/arrays/arrays formats/recording/logs/binary formats/recording/child/child
               formats/recording/child/child_channel formats/recording/child/child_tables formats/recording/child/read_program formats/recording/table)
  list(APPEND IMULAB_READ_SOURCES ${PROJECT_SOURCE_DIR}/imulab/${needed}.cpp)
endforeach()
add_executable(imulab_read ${IMULAB_READ_SOURCES})
target_compile_definitions(imulab_read PRIVATE IMULAB_EIGEN_ALIGNMENT=${IMULAB_EIGEN_ALIGNMENT})
target_include_directories(imulab_read PRIVATE ${PROJECT_SOURCE_DIR})
target_compile_options(imulab_read PRIVATE -Wconversion -Wsign-conversion)
target_link_options(imulab_read PRIVATE -Wl,--gc-sections -Wl,--as-needed)
target_precompile_headers(imulab_read REUSE_FROM imulab_precompiled)
set_target_properties(imulab_read PROPERTIES OUTPUT_NAME imulab-read RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/libexec)
add_dependencies(imulab_command imulab_read) # they are one

# As archives where these are installed: libhdf5 as a shared library brings thirty others, those for files on the network, and takes longer to start than
# most files to read.
find_library(IMULAB_MATIO_ARCHIVE libmatio.a)
find_library(IMULAB_HDF5_ARCHIVE libhdf5.a PATHS ${IMULAB_HDF5_LIBRARY_DIRS})
find_library(IMULAB_SZ_ARCHIVE libsz.a)
find_library(IMULAB_AEC_ARCHIVE libaec.a)
mark_as_advanced(IMULAB_MATIO_ARCHIVE IMULAB_HDF5_ARCHIVE IMULAB_SZ_ARCHIVE IMULAB_AEC_ARCHIVE)
foreach(name MATIO HDF5) # in this order: that of MATLAB files needs HDF5
  if(name IN_LIST IMULAB_READ_WITH)
    string(TOLOWER ${name} reader)
    target_sources(imulab_read PRIVATE ${PROJECT_SOURCE_DIR}/apps/imulab_read/${reader}_reader.cpp)
    target_compile_definitions(imulab_read PRIVATE IMULAB_WITH_${name})
    target_include_directories(imulab_read SYSTEM PRIVATE ${IMULAB_${name}_INCLUDE_DIRS})
    if(IMULAB_${name}_ARCHIVE AND IMULAB_HDF5_ARCHIVE AND IMULAB_SZ_ARCHIVE AND IMULAB_AEC_ARCHIVE)
      target_link_libraries(imulab_read PRIVATE ${IMULAB_${name}_ARCHIVE} ${IMULAB_HDF5_ARCHIVE} ${IMULAB_SZ_ARCHIVE} ${IMULAB_AEC_ARCHIVE} ${CMAKE_DL_LIBS} m)
    else()
      target_link_libraries(imulab_read PRIVATE PkgConfig::IMULAB_${name})
    endif()
  endif()
endforeach()
target_link_libraries(imulab_read PRIVATE imulab_read_sandbox Eigen3::Eigen fmt::fmt PkgConfig::libdeflate ZLIB::ZLIB)
imulab_units_by_folder(imulab_read)
target_sources(imulab_read PRIVATE ${PROJECT_BINARY_DIR}/build.cpp)
