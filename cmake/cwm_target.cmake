# The warnings that every target of ours is compiled with, and the directory its includes start at.
# CWM_SANITIZE (a list: address, undefined, thread) is set by the presets asan and tsan.
set(CWM_SANITIZE "" CACHE STRING "Sanitizers, comma separated, as in -fsanitize=")
option(CWM_WERROR "Warnings are errors" OFF)

add_library(cwm_options INTERFACE)
target_include_directories(cwm_options INTERFACE ${PROJECT_SOURCE_DIR})
# g++ 12 sees overlaps in std::string's operator+ that are none (its bug 105329): -Wno-restrict. In headers that are precompiled it
# no longer knows that they are the system's, and sees copies in std::string that are too long; the preset dev still asks.
option(CWM_PRECOMPILE "Precompile the headers of libraries" ON)
set(of_strings -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
if(NOT CWM_PRECOMPILE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  set(of_strings)
endif()
target_compile_options(cwm_options INTERFACE -Wall -Wextra -Wpedantic -Wno-psabi -Wno-restrict ${of_strings}
                       $<$<CXX_COMPILER_ID:Clang>:-Wno-unknown-warning-option>
                       $<$<BOOL:${CWM_WERROR}>:-Werror>)
# Perception is nearly half of what the sanitizers compile: `./dev check` leaves it out where it did not change.
option(CWM_SANITIZE_PERCEPTION "Sanitize perception as well, and run its tests so" ON)
if(CWM_SANITIZE)
  # What the sanitizers insert makes g++ see uninitialized members in optionals that hold nothing (its manual says so of
  # -Wmaybe-uninitialized); the other presets still ask.
  set(sanitizers -fsanitize=${CWM_SANITIZE} -fno-sanitize-recover=all)
  if(CWM_SANITIZE MATCHES "undefined")  # asan sees what they see, and they take a third of the time of compiling or more
    list(APPEND sanitizers -fno-sanitize=null,object-size,pointer-overflow)
  endif()
  target_compile_options(cwm_options INTERFACE
                         "$<$<NOT:$<BOOL:$<TARGET_PROPERTY:CWM_UNSANITIZED>>>:${sanitizers}>"
                         -fno-omit-frame-pointer $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(cwm_options INTERFACE -fsanitize=${CWM_SANITIZE})
endif()

# Code that tells libFuzzer where it goes; clang alone has it.
option(CWM_FUZZ "Build the targets of tests/fuzz for libFuzzer" OFF)
if(CWM_FUZZ)
  target_compile_options(cwm_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Sources are compiled several at a time, for the headers that they share (Eigen, gRPC, GoogleTest) take longer than they
# do. clang-tidy, and who changes one file at a time (the preset dev), read sources one by one.
option(CWM_JOIN_SOURCES "Compile a target's sources several at a time" ON)
function(cwm_join name)
  set_target_properties(${name} PROPERTIES CWM_OURS ON UNITY_BUILD ${CWM_JOIN_SOURCES} UNITY_BUILD_BATCH_SIZE 6)
endfunction()

# cwm_program(NAME SOURCES...): an executable that is no test; its sources are few and compiled one by one.
function(cwm_program name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE cwm_options)
  set_target_properties(${name} PROPERTIES CWM_OURS ON)
endfunction()

# cwm_apart(SOURCES...): compiled one by one all the same, for they have a name in common with another source of their target, or
# are compiled once for each set of instructions.
function(cwm_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# cwm_library(NAME SOURCES... ): a static library with the project's options.
function(cwm_library name)
  add_library(${name} STATIC ${ARGN})
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:cwm_options>)  # of no use to who links what is installed
  cwm_join(${name})
  if(NOT CWM_SANITIZE_PERCEPTION AND CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/perception")
    set_property(TARGET ${name} PROPERTY CWM_UNSANITIZED ON)
  endif()
endfunction()

# What is tested is compiled as it is for users; tests themselves need not be fast, and compile in half the time.
add_library(cwm_test_options INTERFACE)
target_compile_options(cwm_test_options INTERFACE $<$<CONFIG:Release>:-O1>)

# cwm_test(NAME SOURCES a.cc ... LINK targets... [LABELS labels...]): one GoogleTest binary; each
# binary is one entry of ctest, run from the source directory. A test that needs outside data skips itself by name.
function(cwm_test name)
  cmake_parse_arguments(TEST "" "TIMEOUT" "SOURCES;LINK;LABELS;ARGS" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  cwm_join(${name})
  target_link_libraries(${name} PRIVATE cwm_options cwm_test_options ${TEST_LINK} GTest::gmock GTest::gtest_main)
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
