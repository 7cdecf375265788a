# Installation: program, libraries, headers, CMake package, pkg-config file, Debian package.
include(CMakePackageConfigHelpers)

install(TARGETS hebra_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS hebra_core hebra EXPORT hebra-targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/hebra DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/hebra)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} OPTIONAL)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/hebra)
install(EXPORT hebra-targets NAMESPACE hebra:: DESTINATION ${package_dir})
configure_package_config_file(cmake/hebra-config.cmake.in ${PROJECT_BINARY_DIR}/hebra-config.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/hebra-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/hebra-config.cmake ${PROJECT_BINARY_DIR}/hebra-config-version.cmake
  DESTINATION ${package_dir})

# A static libhebra needs the libraries behind it at the link of every program; a shared one brings them along.
if(BUILD_SHARED_LIBS)
  set(HEBRA_PC_REQUIRES "Requires.private")
else()
  set(HEBRA_PC_REQUIRES "Requires")
endif()
# Paths relative to the file, so that an installation may be moved.
file(RELATIVE_PATH HEBRA_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" HEBRA_PC_PREFIX "${HEBRA_PC_PREFIX}")
configure_file(cmake/hebra.pc.in hebra.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/hebra.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME hebra)
set(CPACK_PACKAGE_VENDOR "Hebra contributors")
set(CPACK_PACKAGE_CONTACT "Hebra contributors <hebra@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "ffmpeg, gnuplot-nox")
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
if(DPKG_SHLIBDEPS)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
endif()
include(CPack)
