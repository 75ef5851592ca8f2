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

# The C++ client: find_package(cwm), cwm::client. Headers keep the paths by which they include each
# other, below one folder; <cwm/client.h> includes them all.
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/cwm)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/cwm)
foreach(library client formats proto transfer)
  set_target_properties(cwm_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS cwm_${library} EXPORT cwm
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT client-dev
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${headers})
endforeach()
target_compile_features(cwm_client INTERFACE cxx_std_20)
foreach(folder clients/cpp clients/formats proto/transfer)
  install(DIRECTORY ${folder}/ DESTINATION ${headers}/${folder} COMPONENT client-dev
          FILES_MATCHING PATTERN "*.h" PATTERN client.h EXCLUDE)
endforeach()
install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/cwm/ DESTINATION ${headers}/cwm COMPONENT client-dev
        FILES_MATCHING PATTERN "*.pb.h")
install(FILES clients/cpp/client.h DESTINATION ${headers} COMPONENT client-dev)
install(EXPORT cwm NAMESPACE cwm:: FILE cwmTargets.cmake DESTINATION ${package} COMPONENT client-dev)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cwmConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/cwmConfig.cmake ${PROJECT_BINARY_DIR}/cwmConfigVersion.cmake
        DESTINATION ${package} COMPONENT client-dev)
