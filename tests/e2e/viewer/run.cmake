# cmake -DSOURCE_DIR=... -DBINARY_DIR=... -DFILE=x.ts [-DRUNNER=--test] -P run.cmake: bundles a file that opens the viewer's page
# and runs it with Node, RUNNER being Node's own option.
include(${SOURCE_DIR}/tests/clients/web/web_tools.cmake)
if(NOT EXISTS ${web}/node_modules/playwright-core)
  message(FATAL_ERROR "playwright-core is missing: ./dev setup test installs it")
endif()
get_filename_component(name ${FILE} NAME_WE)
set(ENV{NODE_PATH} ${web}/node_modules)
run(${web}/node_modules/.bin/esbuild ${SOURCE_DIR}/${FILE} --bundle --platform=node --format=cjs --target=node18
    --external:playwright-core --log-level=warning --outfile=${BINARY_DIR}/${name}.cjs)
run(node ${RUNNER} ${BINARY_DIR}/${name}.cjs)
