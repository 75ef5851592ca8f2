# cmake -P generate.cmake, or included: the messages of proto/cwm/v1 as TypeScript in `generated`, made anew when
# a .proto is newer. Needs protoc, which all builds need, and what package.json names; no network.
set(web_dir ${CMAKE_CURRENT_LIST_DIR})
set(protos ${web_dir}/../../proto)
set(plugin ${web_dir}/node_modules/.bin/protoc-gen-es)
set(generated ${web_dir}/generated)
find_program(protoc protoc)
if(NOT EXISTS ${plugin} OR NOT protoc)
  message(FATAL_ERROR "protoc-gen-es or protoc is missing: ./dev setup build installs both")
endif()
file(LOCK ${web_dir}/node_modules/.generate GUARD PROCESS TIMEOUT 60)  # builds and tests make them at the same time
file(GLOB sources ${protos}/cwm/v1/*.proto)
set(stale FALSE)
foreach(source ${sources})
  get_filename_component(name ${source} NAME_WE)
  if(NOT EXISTS ${generated}/cwm/v1/${name}_pb.ts OR ${source} IS_NEWER_THAN ${generated}/cwm/v1/${name}_pb.ts)
    set(stale TRUE)
  endif()
endforeach()
if(stale)
  file(MAKE_DIRECTORY ${generated})
  execute_process(
    COMMAND ${protoc} -I ${protos} --plugin=protoc-gen-es=${plugin} --es_out=${generated}
            --es_opt=target=ts,import_extension=none ${sources}
    RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "protoc could not write the messages of proto/cwm/v1 as TypeScript")
  endif()
endif()
