# cmake -DSOURCE_DIR=... -DPAGE=report -DFORMAT=iife|esm -DTEMPLATE=x.cc.in -DOUTPUT=x.cc -P bundle.cmake: bundles main.ts,
# style.css and, where it is there, worker.ts of src/PAGE, each into one file, and puts them and index.html into the
# template as @main_js@, @style_css@, @worker_js@, @index_html@ (empty for what the page has not). Needs no network.
set(esbuild ${SOURCE_DIR}/node_modules/.bin/esbuild)
if(NOT EXISTS ${esbuild} OR NOT EXISTS ${SOURCE_DIR}/node_modules/three)
  message(FATAL_ERROR "clients/web/node_modules is missing or not complete: ./dev build installs what the pages are made "
                      "of, and ./dev setup build does so without building")
endif()
include(${CMAKE_CURRENT_LIST_DIR}/generate.cmake)
get_filename_component(directory ${OUTPUT} DIRECTORY)
set(page ${SOURCE_DIR}/src/${PAGE})
set(entries ${page}/main.ts ${page}/style.css)
if(EXISTS ${page}/worker.ts)
  list(APPEND entries ${page}/worker.ts)
endif()
file(REMOVE_RECURSE ${directory}/${PAGE})
execute_process(
  COMMAND ${esbuild} ${entries} --bundle --minify --format=${FORMAT} --target=es2020
          --charset=utf8 --legal-comments=eof --log-level=warning --outdir=${directory}/${PAGE}
  WORKING_DIRECTORY ${SOURCE_DIR} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "esbuild could not bundle clients/web/src/${PAGE}")
endif()
function(read_if_there path variable)
  set(content "")
  if(EXISTS ${path})
    file(READ ${path} content)
  endif()
  set(${variable} "${content}" PARENT_SCOPE)
endfunction()
read_if_there(${directory}/${PAGE}/main.js main_js)
read_if_there(${directory}/${PAGE}/worker.js worker_js)
read_if_there(${directory}/${PAGE}/style.css style_css)
read_if_there(${page}/index.html index_html)
configure_file(${TEMPLATE} ${OUTPUT} @ONLY)
