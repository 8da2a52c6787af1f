# imulab-read, which alone is linked with the libraries of HDF5 and MATLAB files.
add_library(imulab_read_sandbox OBJECT apps/imulab_read/sandbox.cpp) # of the tests, too
target_include_directories(imulab_read_sandbox PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(imulab_read_sandbox PRIVATE fmt::fmt)
if("SECCOMP" IN_LIST IMULAB_read_WITH)
  target_compile_definitions(imulab_read_sandbox PRIVATE IMULAB_WITH_SECCOMP)
  target_link_libraries(imulab_read_sandbox PUBLIC PkgConfig::IMULAB_SECCOMP)
endif()
if(NOT IMULAB_read_WITH MATCHES "HDF5|MATIO")
  return()
endif()
# It starts for each file: of the library it has what it needs, and nothing else.
set(sources ${IMULAB_SOURCES})
list(FILTER sources INCLUDE REGEX "imulab/(core/(memory|nearest_name|text|unit_expression)|recording/unit_names\
|formats/text/(file|printable|reading|reading_meter|several_files|unfinished)\
|formats/recording/(arrays/arrays|logs/binary|child/(child|child_channel|child_tables|read_program)|table))\\.cpp$")
add_executable(imulab_read apps/imulab_read/main.cpp ${sources} ${PROJECT_BINARY_DIR}/build.cpp)
target_compile_definitions(imulab_read PRIVATE IMULAB_EIGEN_ALIGNMENT=${IMULAB_EIGEN_ALIGNMENT})
target_include_directories(imulab_read PRIVATE ${PROJECT_SOURCE_DIR})
target_compile_options(imulab_read PRIVATE -Wconversion -Wsign-conversion)
target_link_options(imulab_read PRIVATE -Wl,--gc-sections -Wl,--as-needed)
target_precompile_headers(imulab_read REUSE_FROM imulab_precompiled)
set_source_files_properties(apps/imulab_read/main.cpp apps/imulab_read/matio_reader.cpp apps/imulab_read/hdf5_reader.cpp
                            PROPERTIES UNITY_GROUP apps_imulab_read)
set_target_properties(imulab_read PROPERTIES OUTPUT_NAME imulab-read RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/libexec UNITY_BUILD_MODE GROUP)
add_dependencies(imulab_command imulab_read) # they are one
# The archives of these libraries if all are installed: libhdf5 as a shared library brings thirty others, those for files on the network, and takes
# longer to start than most files to read.
foreach(name matio hdf5 sz aec) # in this order: that of MATLAB files needs HDF5
  find_library(IMULAB_ARCHIVE_${name} lib${name}.a PATHS ${IMULAB_HDF5_LIBRARY_DIRS})
  list(APPEND archives ${IMULAB_ARCHIVE_${name}})
endforeach()
foreach(reader hdf5 matio)
  string(TOUPPER ${reader} name)
  if(name IN_LIST IMULAB_read_WITH)
    target_sources(imulab_read PRIVATE apps/imulab_read/${reader}_reader.cpp)
    target_compile_definitions(imulab_read PRIVATE IMULAB_WITH_${name})
    target_include_directories(imulab_read SYSTEM PRIVATE ${IMULAB_${name}_INCLUDE_DIRS})
    list(APPEND shared PkgConfig::IMULAB_${name})
  endif()
endforeach()
if(archives MATCHES "NOTFOUND")
  target_link_libraries(imulab_read PRIVATE ${shared})
else()
  target_link_libraries(imulab_read PRIVATE ${archives} ${CMAKE_DL_LIBS} m)
endif()
target_link_libraries(imulab_read PRIVATE imulab_read_sandbox Eigen3::Eigen fmt::fmt PkgConfig::libdeflate ZLIB::ZLIB)
