# cwm_bundle_page(PAGE FORMAT TEMPLATE OUTPUT): a rule that makes the source file OUTPUT from TEMPLATE and the bundle of
# clients/web/src/PAGE (see bundle.cmake).
set(cwm_web_dir ${CMAKE_CURRENT_LIST_DIR})

function(cwm_bundle_page page format template output)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${cwm_web_dir}/src/*.ts ${cwm_web_dir}/src/*.css ${cwm_web_dir}/src/*.html
       ${cwm_web_dir}/../../proto/cwm/v1/*.proto)
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${cwm_web_dir} -DPAGE=${page} -DFORMAT=${format} -DTEMPLATE=${template}
            -DOUTPUT=${output} -P ${cwm_web_dir}/bundle.cmake
    DEPENDS ${sources} ${cwm_web_dir}/bundle.cmake ${cwm_web_dir}/generate.cmake ${cwm_web_dir}/package.json ${template}
    VERBATIM)
endfunction()
