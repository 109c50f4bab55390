# install(): libraries and headers for find_package(pierce) and pkg-config, and the command.
include(CMakePackageConfigHelpers)

set(pierce_installed core)
if(PIERCE_EMBREE)
    list(APPEND pierce_installed cpu_embree)
endif()
if(PIERCE_CUDA)
    list(APPEND pierce_installed gpu_cuda)
endif()
if(PIERCE_BULLET)
    list(APPEND pierce_installed bullet)
endif()
if(PIERCE_C_API)
    list(APPEND pierce_installed c_api)
endif()

list(TRANSFORM pierce_installed PREPEND pierce_ OUTPUT_VARIABLE pierce_targets)
install(TARGETS ${pierce_targets} EXPORT pierce_targets)
install(EXPORT pierce_targets NAMESPACE pierce:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
foreach(module IN LISTS pierce_installed)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/${module}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endforeach()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/pierce-config.cmake.in pierce-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
write_basic_package_version_file(pierce-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pierce-config.cmake ${PROJECT_BINARY_DIR}/pierce-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
if(PIERCE_C_API)
    # For programs in C, with pkg-config. Paths are relative, so that the folder may be moved.
    file(RELATIVE_PATH pierce_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/pierce.pc.in pierce.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/pierce.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()
if(PIERCE_APP)
    install(TARGETS pierce_app)
endif()
