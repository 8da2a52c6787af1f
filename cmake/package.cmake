# Installed files, in three parts: the command, the library for programs of your own (dev), and the Python module (python/CMakeLists.txt); and the Debian
# packages of them, which `./dev package` makes.
include(CMakePackageConfigHelpers)
set(IMULAB_HELP ${CMAKE_BINARY_DIR}/help)
add_custom_command(TARGET imulab_command POST_BUILD # manual pages and completion, from the command itself
                   COMMAND imulab_command help --man ${IMULAB_HELP}
                   COMMAND imulab_command help --completion bash > ${IMULAB_HELP}/imulab.bash
                   COMMAND imulab_command help --completion zsh > ${IMULAB_HELP}/_imulab
                   COMMAND imulab_command help --completion fish > ${IMULAB_HELP}/imulab.fish)
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON) # a package of the command does not wait for the tests

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME command)
install(TARGETS imulab_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET imulab_read)
  install(TARGETS imulab_read RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR})
endif()
install(DIRECTORY ${IMULAB_HELP}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 FILES_MATCHING PATTERN "*.1")
install(FILES ${IMULAB_HELP}/imulab.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME imulab)
install(FILES ${IMULAB_HELP}/_imulab DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
install(FILES ${IMULAB_HELP}/imulab.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/imulab RENAME copyright)
install(FILES CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/imulab)
file(GLOB boost RELATIVE /usr/share/doc /usr/share/doc/libboost1.*-dev) # the package without a version has no license of Boost
foreach(package ${boost} libeigen3-dev pybind11-dev librandom123-dev libcli11-dev nlohmann-json3-dev libjs-dygraphs libdeflate-dev libhdf5-dev libmatio-dev libaec-dev) # their code is in the programs
  install(FILES /usr/share/doc/${package}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/imulab/licenses RENAME ${package} OPTIONAL)
endforeach()

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev) # find_package(imulab) gives imulab::imulab; pkg-config knows imulab
file(RELATIVE_PATH IMULAB_PREFIX_FROM_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" IMULAB_PREFIX_FROM_PC "${IMULAB_PREFIX_FROM_PC}")
configure_file(cmake/imulab.pc.in imulab.pc @ONLY)
configure_file(cmake/imulab-files.pc.in imulab-files.pc @ONLY)
configure_file(cmake/imulabConfig.cmake.in imulabConfig.cmake @ONLY)
write_basic_package_version_file(imulabConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(TARGETS imulab EXPORT imulabTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS imulab_files EXPORT imulab_filesTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
file(GLOB IMULAB_PUBLIC_HEADERS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/imulab/*.hpp) # those in the rooms are internal
install(FILES ${IMULAB_PUBLIC_HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/imulab)
foreach(targets imulabTargets imulab_filesTargets)
  install(EXPORT ${targets} NAMESPACE imulab:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/imulab)
endforeach()
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/imulabConfig.cmake cmake/dependencies.cmake cmake/optional_dependencies.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/imulabConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/imulab)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/imulab.pc ${CMAKE_CURRENT_BINARY_DIR}/imulab-files.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libimulab-dev RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL command dev)
if(TARGET imulab_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_PACKAGE_VENDOR imulab)
set(CPACK_PACKAGE_CONTACT "imulab <imulab@users.noreply.github.com>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME imulab)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMMAND_PACKAGE_RECOMMENDS libarchive13) # it is loaded with the first archive
set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS libpq5) # a fleet store on a PostgreSQL server
set(CPACK_DEBIAN_COMMAND_DESCRIPTION "calibrates inertial measurement units, with the uncertainty of every coefficient")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libimulab-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS dependencies.txt)
function(imulab_packages variable linked) # then more of them: "a, b", of the rows of dependencies.txt that are so linked
  file(STRINGS dependencies.txt packages REGEX "# ${linked}: ")
  list(TRANSFORM packages REPLACE " .*" "")
  list(APPEND packages ${ARGN})
  list(JOIN packages ", " packages)
  set(${variable} "${packages}" PARENT_SCOPE)
endfunction()
imulab_packages(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS linked ${IMULAB_imulab_PACKAGES})
imulab_packages(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "linked by files" ${IMULAB_files_PACKAGES} imulab) # the last for imulab-read
set(CPACK_DEBIAN_DEV_DESCRIPTION "imulab as a C++ library: static library, headers, CMake and pkg-config files")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-imulab)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS imulab) # imulab-read
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "imulab as a Python module")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
include(CPack)
