# Run by CPack once the components are staged: what belongs below /etc, and what Debian wants in every package.
set(here ${CMAKE_CURRENT_LIST_DIR})
foreach(component package IN ZIP_LISTS CPACK_COMPONENTS_ALL CPACK_CWM_PACKAGES)
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  file(COPY ${here}/copyright ${here}/changelog DESTINATION ${root}/usr/share/doc/${package}
       FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  execute_process(COMMAND gzip -9n ${root}/usr/share/doc/${package}/changelog
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
configure_file(${here}/cwm-server.default ${CPACK_TEMPORARY_DIRECTORY}/server/etc/default/cwm-server
               COPYONLY)
