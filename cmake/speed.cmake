# Quick compilation of the sources. Two things cost time: parsing the headers of Eigen, fmt and the standard library, and instantiating their templates.
# Both are done once: the headers in a precompiled header, the templates in one unit a folder (CMAKE_UNITY_BUILD, which the presets switch on).

# The precompiled header without anything else, for all that needs no more.
file(CONFIGURE OUTPUT precompiled.cpp CONTENT "")
function(imulab_add_precompiled name)
  add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(${name} PRIVATE Eigen3::Eigen fmt::fmt)
  target_precompile_headers(${name} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.hpp)
endfunction()
imulab_add_precompiled(imulab_precompiled)

# The sources of one folder are one unit, so a helper's name is unique in its folder's namespace.
function(imulab_units_by_folder target)
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    cmake_path(GET source PARENT_PATH folder)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(REPLACE "/" "_" unit "${folder}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${unit})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()
