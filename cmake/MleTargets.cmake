# What every target of the project shares.

# Two traps of memory between Eigen and the packaged Ceres, which share objects:
# - -march=native, or any wider vectors: Eigen then aligns memory otherwise than
#   the copies of its templates inside Ceres, and one frees what the other took.
# - g++ -fsanitize=address: Eigen (Memory.h, __SANITIZE_ADDRESS__) then pads its
#   blocks and hands out a pointer into them, which Ceres gives to free().
#   clang++ 14 does not define that macro; the preset asan-ubsan uses it.

# Private to the project: warnings are no business of those who use it.
add_library(mle_build_flags INTERFACE)
target_compile_features(mle_build_flags INTERFACE cxx_std_20)
target_compile_options(mle_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -fno-math-errno
  $<$<BOOL:${MLE_WERROR}>:-Werror>)

# mle_add_library(NAME SOURCES … HEADERS … DEPENDS … [PRIVATE_DEPENDS …])
#
# The library mle_NAME, alias mle::NAME. HEADERS are public and are included by
# their path from the root of the project. DEPENDS are what the headers need,
# PRIVATE_DEPENDS what the sources need besides.
function(mle_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  set(target mle_${name})
  add_library(${target} ${ARG_SOURCES})
  add_library(mle::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}
    POSITION_INDEPENDENT_CODE ON)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_sources(${target} PUBLIC
    FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARG_HEADERS})
  target_link_libraries(${target}
    PUBLIC ${ARG_DEPENDS}
    PRIVATE $<BUILD_INTERFACE:mle_build_flags> ${ARG_PRIVATE_DEPENDS})
  mle_use_precompiled_headers(mle_headers ${target})
  set_property(GLOBAL APPEND PROPERTY MLE_LIBRARIES ${target})
endfunction()

# mle_add_test(NAME SOURCES … DEPENDS … [LABEL unit|reference|e2e|slow])
function(mle_add_test name)
  cmake_parse_arguments(ARG "" "LABEL" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE
    ${ARG_DEPENDS} mle_build_flags GTest::gtest GTest::gmock GTest::gtest_main)
  mle_use_precompiled_headers(mle_headers_of_tests ${name})
  mle_add_suites(${name} ${ARG_LABEL} ${ARG_SOURCES})
endfunction()

# mle_add_suites(PROGRAM LABEL SOURCE…): each suite of GoogleTest is a test of
# ctest, PROGRAM.SUITE. The tests of a suite share a process: to start one takes
# longer than most tests do. A suite counts as skipped if all of its tests do.
set(mle_all_skipped "  PASSED  . 0 tests.\n.  SKIPPED . [0-9]+ tests?, listed below:(\n.  SKIPPED . [^\n]*)+\n*$")
function(mle_add_suites program label)
  set(suites)
  list(FILTER ARGN INCLUDE REGEX "_test.cc$")
  foreach(source IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} tests REGEX "^TEST(_[FP])?\\(")
    list(TRANSFORM tests REPLACE "^TEST[_FP]*\\(([A-Za-z0-9_]+),.*" "\\1")
    list(APPEND suites ${tests})
  endforeach()
  list(REMOVE_DUPLICATES suites)
  foreach(suite IN LISTS suites)
    add_test(NAME ${program}.${suite}
      COMMAND ${program} "--gtest_filter=${suite}.*:*/${suite}.*")
    set_tests_properties(${program}.${suite} PROPERTIES
      LABELS ${label} SKIP_REGULAR_EXPRESSION "${mle_all_skipped}")
  endforeach()
endfunction()
