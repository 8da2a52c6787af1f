include(${CMAKE_CURRENT_LIST_DIR}/imulabBuiltWith.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/imulabTargets.cmake)
