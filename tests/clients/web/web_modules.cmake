include(${CMAKE_CURRENT_LIST_DIR}/web_tools.cmake)
set(ENV{NODE_PATH} ${web}/node_modules)
file(GLOB tests ${CMAKE_CURRENT_LIST_DIR}/*.test.ts)
run(${web}/node_modules/.bin/esbuild ${tests} --bundle --platform=node --format=esm --target=node18
    --out-extension:.js=.mjs --log-level=warning --outdir=${BINARY_DIR})
file(GLOB bundles ${BINARY_DIR}/*.test.mjs)
run(node --test ${bundles})
