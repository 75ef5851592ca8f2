include(${CMAKE_CURRENT_LIST_DIR}/web_tools.cmake)
run(${web}/node_modules/.bin/tsc --project clients/web)
run(${web}/node_modules/.bin/tsc --project tests/clients/web)
