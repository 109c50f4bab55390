# install(): libraries and headers for find_package(pierce), and the command.
include(CMakePackageConfigHelpers)

set(pierce_installed pierce_core)
set(pierce_folders core)  # whose headers are all public
if(PIERCE_EMBREE)
    list(APPEND pierce_installed pierce_cpu_embree)
    # The rest of it speaks Embree, whose version is nobody else's business.
    install(FILES ${PROJECT_SOURCE_DIR}/src/cpu_embree/embree_backend.hpp
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pierce/cpu_embree)
endif()
if(PIERCE_CUDA)
    list(APPEND pierce_installed pierce_gpu_cuda)
    # The rest of it is for nvcc.
    install(FILES ${PROJECT_SOURCE_DIR}/src/gpu_cuda/cuda_backend.hpp
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pierce/gpu_cuda)
endif()
if(PIERCE_BULLET)
    list(APPEND pierce_installed pierce_bullet)
    list(APPEND pierce_folders bullet)
endif()

install(TARGETS ${pierce_installed} EXPORT pierce_targets)
install(EXPORT pierce_targets NAMESPACE pierce:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
foreach(folder IN LISTS pierce_folders)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/pierce/${folder}
            FILES_MATCHING PATTERN "*.hpp")
endforeach()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/pierce-config.cmake.in pierce-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
write_basic_package_version_file(pierce-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/pierce-config.cmake ${PROJECT_BINARY_DIR}/pierce-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/pierce)
if(PIERCE_APP)
    install(TARGETS pierce_app)
endif()
