# The tools of clients/web, which ./dev setup test installs.
set(web ${SOURCE_DIR}/clients/web)
foreach(tool tsc esbuild)
  if(NOT EXISTS ${web}/node_modules/.bin/${tool})
    message(FATAL_ERROR "${tool} is missing: ./dev setup test installs it")
  endif()
endforeach()

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${SOURCE_DIR} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()
