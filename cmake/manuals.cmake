# Manual pages and completions, which the built programs write into build/man and build/completion.
# Installing them is OPTIONAL, because a build of single targets does not make them.
set(manuals)
function(cwm_manual program section component)
  if(NOT TARGET ${program})  # some need PCL
    return()
  endif()
  set(page ${PROJECT_BINARY_DIR}/man/${program}.${section})
  add_custom_command(
    OUTPUT ${page}.gz
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/man
    COMMAND $<TARGET_FILE:${program}> --manual-page > ${page}
    COMMAND gzip -9nf ${page}
    DEPENDS ${program}
    VERBATIM)
  install(FILES ${page}.gz DESTINATION share/man/man${section} COMPONENT ${component} OPTIONAL)
  set(manuals ${manuals} ${page}.gz PARENT_SCOPE)
endfunction()
cwm_manual(cwm-server 8 server)
foreach(program cwm cwm-grasp cwm-plan cwm-simulator)
  cwm_manual(${program} 1 cli)
endforeach()

function(cwm_completion shell folder name)
  set(script ${PROJECT_BINARY_DIR}/completion/${shell}/${name})
  add_custom_command(
    OUTPUT ${script}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/completion/${shell}
    COMMAND $<TARGET_FILE:cwm> completion ${shell} > ${script}
    DEPENDS cwm
    VERBATIM)
  install(FILES ${script} DESTINATION ${folder} COMPONENT cli OPTIONAL)
  set(manuals ${manuals} ${script} PARENT_SCOPE)
endfunction()
cwm_completion(bash share/bash-completion/completions cwm)
cwm_completion(zsh share/zsh/vendor-completions _cwm)
cwm_completion(fish share/fish/vendor_completions.d cwm.fish)
add_custom_target(cwm_manuals ALL DEPENDS ${manuals})
