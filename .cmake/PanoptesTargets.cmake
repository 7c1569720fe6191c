# SPDX-License-Identifier: BSD-3-Clause
# One folder, one CMakeLists.txt, one target.

# What every target of ours is compiled with. Contraction of floating-point products is off, so that
# a run repeats bit for bit on other machines.
add_library(panoptes_flags INTERFACE)
target_compile_features(panoptes_flags INTERFACE cxx_std_20)
target_compile_options(panoptes_flags INTERFACE
  -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  -Wcast-align -Wunused
  # g++ 12 raises these falsely on "text" + string (gcc bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-stringop-overflow>
  $<$<BOOL:${PANOPTES_WERROR}>:-Werror>)
if(PANOPTES_SANITIZE)
  target_compile_options(panoptes_flags INTERFACE
    -fsanitize=${PANOPTES_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    # Checks of every access, which make Eigen's code take half as long again to build and to run:
    # null, object-size and pointer-overflow address reports where it matters, alignment nothing else does.
    -fno-sanitize=null,object-size,alignment,pointer-overflow)
  # Eigen aligns memory by hand under the address sanitizer; libceres.a, which is not built so, does not,
  # and the linker keeps one of the two for both.
  target_compile_definitions(panoptes_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  target_link_options(panoptes_flags INTERFACE -fsanitize=${PANOPTES_SANITIZE})
endif()

option(PANOPTES_FUZZ_COVERAGE "Fuzz targets learn from the code they reach; build nothing else then" OFF)
if(PANOPTES_FUZZ_COVERAGE)
  target_compile_options(panoptes_flags INTERFACE -fsanitize-coverage=trace-pc)
endif()

# What most sources include is parsed once. A source includes what it uses all the same.
set(PANOPTES_HEADERS
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <optional> <string> <variant> <vector>
  <Eigen/Dense> <opencv2/core.hpp>)
file(CONFIGURE OUTPUT headers.cc CONTENT "// Made by CMake.\n")
add_library(panoptes_headers OBJECT ${CMAKE_CURRENT_BINARY_DIR}/headers.cc)
target_link_libraries(panoptes_headers PRIVATE panoptes_flags Eigen3::Eigen opencv_core)
target_precompile_headers(panoptes_headers PRIVATE ${PANOPTES_HEADERS})

# panoptes_library(name SOURCES ... PUBLIC ... PRIVATE ...) makes panoptes::name from this folder.
function(panoptes_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target panoptes_${name})
  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
    target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE panoptes_flags ${ARG_PRIVATE})
    target_compile_features(${target} PUBLIC cxx_std_20)
    target_precompile_headers(${target} REUSE_FROM panoptes_headers)
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${target} INTERFACE ${ARG_PUBLIC})
    target_compile_features(${target} INTERFACE cxx_std_20)
  endif()
  add_library(panoptes::${name} ALIAS ${target})
endfunction()

# panoptes_table(file macro entries...) makes `file` in the build folder of this one, to be included:
# macro(name) for each entry `name`, macro(name, trait...) for each `name:trait...`, a line each.
function(panoptes_table file macro)
  set(lines "// Made by CMake.\n")
  foreach(entry ${ARGN})
    string(REPLACE ":" ", " arguments ${entry})
    string(APPEND lines "${macro}(${arguments})\n")
  endforeach()
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${file} CONTENT "${lines}" @ONLY)
endfunction()

# What a test spends its time in are the libraries; its own code compiles a third faster so.
set(PANOPTES_TEST_FLAGS $<$<CONFIG:Release>:-O1>)

# panoptes_test(name SOURCES ... LINK ... [LABEL unit|system] [TIMEOUT seconds]) makes one test program of this folder.
function(panoptes_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LINK" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(PANOPTES_SANITIZE)  # several times slower
    math(EXPR ARG_TIMEOUT "10 * ${ARG_TIMEOUT}")
  endif()
  set(target ${name}_test)
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE panoptes_flags ${ARG_LINK} GTest::gmock GTest::gtest_main)
  target_precompile_headers(${target} REUSE_FROM panoptes_test_headers)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${target} PRIVATE PANOPTES_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_compile_options(${target} PRIVATE ${PANOPTES_TEST_FLAGS})
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 TEST_PREFIX ${name}/
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()
