# cmake -DSOURCE_DIR=... -DPAGE=report -DOUTPUT=x.cc -P bundle.cmake: bundles src/PAGE/main.ts and its style and writes
# both as a source file that holds them. Needs no network.
set(esbuild ${SOURCE_DIR}/node_modules/.bin/esbuild)
if(NOT EXISTS ${esbuild} OR NOT EXISTS ${SOURCE_DIR}/node_modules/three)
  message(FATAL_ERROR "clients/web/node_modules is missing or not complete: ./dev build installs what the pages are made "
                      "of, and ./dev setup build does so without building")
endif()
get_filename_component(directory ${OUTPUT} DIRECTORY)
execute_process(
  COMMAND ${esbuild} src/${PAGE}/main.ts src/${PAGE}/style.css --bundle --minify --format=iife --target=es2020
          --charset=utf8 --legal-comments=eof --log-level=warning --outdir=${directory}/${PAGE}
  WORKING_DIRECTORY ${SOURCE_DIR} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "esbuild could not bundle clients/web/src/${PAGE}")
endif()
file(READ ${directory}/${PAGE}/main.js script)
file(READ ${directory}/${PAGE}/style.css style)
file(WRITE ${OUTPUT}
"// Made by clients/web/bundle.cmake.
#include \"clients/web/${PAGE}_assets.h\"

#pragma GCC diagnostic ignored \"-Woverlength-strings\"

namespace cwm::web {
namespace {

constexpr char kScript[] = R\"bundled(${script})bundled\";
constexpr char kStyle[] = R\"bundled(${style})bundled\";

}  // namespace

report::PageAssets ReportAssets() {
  return {.script = {kScript, sizeof(kScript) - 1}, .style = {kStyle, sizeof(kStyle) - 1}};
}

}  // namespace cwm::web
")
