# The warnings for all of our own targets, and the directory at which their includes start.
# The presets asan and tsan set CWM_SANITIZE (a list: address, undefined, thread).
set(CWM_SANITIZE "" CACHE STRING "Sanitizers, comma separated, as in -fsanitize=")
option(CWM_WERROR "Warnings are errors" OFF)

add_library(cwm_options INTERFACE)
target_include_directories(cwm_options INTERFACE ${PROJECT_SOURCE_DIR})
# g++ 12 warns of overlaps in std::string's operator+ that do not exist (its bug 105329), hence
# -Wno-restrict. In precompiled headers it forgets that they are system headers and warns of copies
# in std::string that are too long; the preset dev keeps these warnings.
option(CWM_PRECOMPILE "Precompile the headers of libraries" ON)
set(of_strings -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
if(NOT CWM_PRECOMPILE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(of_strings)
endif()
# g++ collects its garbage when the heap has grown to 1 GB, not each time that it has grown by a
# third: 5 to 10 % of the time to compile for a tenth more memory.
target_compile_options(cwm_options INTERFACE "$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=1048576>")
target_compile_options(cwm_options INTERFACE -Wall -Wextra -Wpedantic -Wno-psabi -Wno-restrict ${of_strings}
                       $<$<CXX_COMPILER_ID:Clang>:-Wno-unknown-warning-option>
                       $<$<BOOL:${CWM_WERROR}>:-Werror>)
# Perception is nearly half of the sanitizers' build: `./dev check` leaves it out if it has not
# changed.
option(CWM_SANITIZE_PERCEPTION "Sanitize perception as well, and run its tests so" ON)
if(CWM_SANITIZE)
  # The sanitizers' instrumentation makes g++ warn of uninitialized members in empty optionals (see
  # -Wmaybe-uninitialized in its manual); the other presets keep the warning.
  set(sanitizers -fsanitize=${CWM_SANITIZE} -fno-sanitize-recover=all)
  if(CWM_SANITIZE MATCHES "undefined")  # asan finds the same; they cost a third or more of compiling
    list(APPEND sanitizers -fno-sanitize=null,object-size,pointer-overflow)
  endif()
  target_compile_options(cwm_options INTERFACE
                         "$<$<NOT:$<BOOL:$<TARGET_PROPERTY:CWM_UNSANITIZED>>>:${sanitizers}>"
                         -fno-omit-frame-pointer $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(cwm_options INTERFACE -fsanitize=${CWM_SANITIZE})
endif()

# Instruments the code for libFuzzer's coverage; only clang can.
option(CWM_FUZZ "Build the targets of tests/fuzz for libFuzzer" OFF)
if(CWM_FUZZ)
  target_compile_options(cwm_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Unity builds: several sources are compiled at a time, because their shared headers (Eigen, gRPC,
# GoogleTest) take longer than the sources. The presets tidy and dev compile sources one by one.
option(CWM_JOIN_SOURCES "Compile a target's sources several at a time" ON)
function(cwm_join name)
  set_target_properties(${name} PROPERTIES CWM_OURS ON UNITY_BUILD ${CWM_JOIN_SOURCES} UNITY_BUILD_BATCH_SIZE 8)
endfunction()

# cwm_program(NAME SOURCES...): an executable other than a test. Its few sources are compiled one by
# one.
function(cwm_program name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE cwm_options)
  set_target_properties(${name} PROPERTIES CWM_OURS ON)
endfunction()

# cwm_apart(SOURCES...): sources that are compiled one by one, because they share a name with
# another source of their target or are compiled once for each instruction set.
function(cwm_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# cwm_library(NAME SOURCES... ): a static library with the project's options.
function(cwm_library name)
  add_library(${name} STATIC ${ARGN})
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:cwm_options>)  # not for users of the installed library
  cwm_join(${name})
  if(NOT CWM_SANITIZE_PERCEPTION AND CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/perception")
    set_property(TARGET ${name} PROPERTY CWM_UNSANITIZED ON)
  endif()
endfunction()

# cwm_light_options: for code that waits for people or for a network, and for the tests themselves;
# -O1 compiles in two thirds of the time. What they call is compiled in full.
add_library(cwm_light_options INTERFACE)
target_compile_options(cwm_light_options INTERFACE $<$<CONFIG:Release>:-O1>)

# cwm_test(NAME SOURCES a.cc ... LINK targets... [LABELS labels...] [TIMEOUT s]): one GoogleTest
# binary and one entry of ctest, run from the source directory. A test without its outside data
# skips itself.
function(cwm_test name)
  cmake_parse_arguments(TEST "" "TIMEOUT" "SOURCES;LINK;LABELS;ARGS" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  cwm_join(${name})
  target_link_libraries(${name} PRIVATE cwm_options cwm_light_options ${TEST_LINK} GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  add_test(NAME ${name} COMMAND ${name} ${TEST_ARGS} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 300)
  endif()
  if(CWM_SANITIZE)  # slower by an order of magnitude
    math(EXPR TEST_TIMEOUT "3 * ${TEST_TIMEOUT}")
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT})
  foreach(label ${TEST_LABELS})  # tests_fast, tests_concurrency: all binaries of a label
    if(NOT TARGET tests_${label})
      add_custom_target(tests_${label})
    endif()
    add_dependencies(tests_${label} ${name})
  endforeach()
endfunction()
