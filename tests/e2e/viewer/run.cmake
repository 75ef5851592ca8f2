# cmake -DSOURCE_DIR=... -DBINARY_DIR=... -DFILE=x.ts -P run.cmake: bundles a file of this folder and lets Node's test runner run it.
include(${SOURCE_DIR}/tests/clients/web/web_tools.cmake)
get_filename_component(name ${FILE} NAME_WE)
set(ENV{NODE_PATH} ${web}/node_modules)
run(${web}/node_modules/.bin/esbuild ${CMAKE_CURRENT_LIST_DIR}/${FILE} --bundle --platform=node --format=cjs --target=node18
    --external:playwright-core --log-level=warning --outfile=${BINARY_DIR}/${name}.test.cjs)
run(node --test ${BINARY_DIR}/${name}.test.cjs)
