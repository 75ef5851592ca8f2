# The files that `cmake --install` installs, in the components of the packages: server, cli,
# client-dev.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

foreach(program cwm-server cwm cwm-grasp cwm-plan cwm-simulator)
  if(TARGET ${program})  # some need PCL
    set(component cli)
    if(program STREQUAL cwm-server)
      set(component server)
    endif()
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
  endif()
endforeach()

# The C++ client: find_package(cwm), cwm::client. <cwm/...> has the public headers, which need Eigen
# alone. Those of <cwm/rpc.h> keep the paths by which they include each other, below one folder.
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/cwm)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/cwm)
foreach(library client formats proto transfer)
  set_target_properties(cwm_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS cwm_${library} EXPORT cwm
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT client-dev
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${headers}/rpc)
endforeach()
target_compile_features(cwm_client INTERFACE cxx_std_20)
install(DIRECTORY clients/cpp/cwm/ DESTINATION ${headers} COMPONENT client-dev
        FILES_MATCHING PATTERN "*.h" PATTERN internal EXCLUDE)
install(FILES clients/cpp/rpc.h DESTINATION ${headers} COMPONENT client-dev)
file(GLOB client_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/clients/cpp/*.h)
list(REMOVE_ITEM client_headers ${PROJECT_SOURCE_DIR}/clients/cpp/rpc.h)
install(FILES ${client_headers} DESTINATION ${headers}/rpc/clients/cpp COMPONENT client-dev)
foreach(folder clients/formats proto/transfer)
  install(DIRECTORY ${folder}/ DESTINATION ${headers}/rpc/${folder} COMPONENT client-dev
          FILES_MATCHING PATTERN "*.h")
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/cwm/ DESTINATION ${headers}/rpc/cwm COMPONENT client-dev
        FILES_MATCHING PATTERN "*.pb.h")
install(EXPORT cwm NAMESPACE cwm:: FILE cwmTargets.cmake DESTINATION ${package} COMPONENT client-dev)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cwmConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/cwmConfig.cmake ${PROJECT_BINARY_DIR}/cwmConfigVersion.cmake
        DESTINATION ${package} COMPONENT client-dev)
