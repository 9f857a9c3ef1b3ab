# What `cmake --install` puts where, and the Debian package that CPack makes of it:
#   program      bin/burin, its manual page
#   development  headers in include/burin/, static libraries, the CMake package for find_package(burin)
#   python       the Python package
include(CMakePackageConfigHelpers)

install(DIRECTORY core costs selection reconstruct DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/burin
        COMPONENT development FILES_MATCHING PATTERN "*.h" PATTERN "*.inc")
install(DIRECTORY apps/run DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/burin/apps
        COMPONENT development FILES_MATCHING PATTERN "*.h")
set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/burin)
install(EXPORT burinTargets NAMESPACE burin:: DESTINATION ${config_dir} COMPONENT development)
configure_package_config_file(cmake/burinConfig.cmake.in burinConfig.cmake
                              INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(burinConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/burinConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/burinConfigVersion.cmake
        DESTINATION ${config_dir} COMPONENT development)

# The manual page comes from the option definitions: the program writes it.
add_custom_command(OUTPUT burin.1 COMMAND burin options --man > burin.1 DEPENDS burin VERBATIM)
add_custom_target(manual_page ALL DEPENDS burin.1)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/burin.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
        COMPONENT program)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "burin developers <burin@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program development python)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # what the binaries are linked with, by dpkg-shlibdeps
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME burin)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libburin-dev)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-burin)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
# The headers and libraries that burin's own headers and burinConfig.cmake want, as cmake/packages.txt
# has them.
file(STRINGS cmake/packages.txt package_lines REGEX "^lib.*-dev$|^nlohmann-json3-dev$")
list(FILTER package_lines EXCLUDE REGEX "gtest|gmock|benchmark")
list(JOIN package_lines ", " development_packages)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${development_packages}")
include(CPack)
