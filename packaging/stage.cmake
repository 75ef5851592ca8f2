# Run by CPack after the components are staged: adds the files below /etc and those that Debian
# requires in every package.
set(here ${CMAKE_CURRENT_LIST_DIR})
foreach(component package IN ZIP_LISTS CPACK_COMPONENTS_ALL CPACK_CWM_PACKAGES)
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  set(doc ${root}/usr/share/doc/${package})
  set(readable FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  file(COPY ${here}/copyright DESTINATION ${doc} ${readable})
  configure_file(${here}/changelog ${doc}/changelog @ONLY ${readable})
  execute_process(COMMAND gzip -9n ${doc}/changelog COMMAND_ERROR_IS_FATAL ANY)
  if(component MATCHES "^(server|cli)$")  # their pages contain three.js, whose notice is required
    file(COPY_FILE ${here}/../clients/web/node_modules/three/LICENSE ${doc}/three.js.LICENSE)
    file(CHMOD ${doc}/three.js.LICENSE ${readable})
  endif()
endforeach()
configure_file(${here}/cwm-server.default ${CPACK_TEMPORARY_DIRECTORY}/server/etc/default/cwm-server
               COPYONLY)
