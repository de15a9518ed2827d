# Headers that nearly every source includes, compiled once: for the libraries and
# parts of commands, and with GoogleTest for the tests. What is left of the sources
# of a target is compiled together (MleUnityBuild.cmake).
#
# Off where ccache stands before the compiler, which knows results better than
# it knows precompiled headers, and as a subproject.

set(mle_precompiles ${mle_builds_whole})
if(CMAKE_CXX_COMPILER_LAUNCHER)
  set(mle_precompiles OFF)
endif()
option(MLE_PRECOMPILED_HEADERS "Compile common headers once" ${mle_precompiles})

# mle_use_precompiled_headers(CARRIER TARGET…): CARRIER is one of those below.
function(mle_use_precompiled_headers carrier)
  if(NOT MLE_PRECOMPILED_HEADERS)
    return()
  endif()
  foreach(target IN LISTS ARGN)
    target_precompile_headers(${target} REUSE_FROM ${carrier})
    get_target_property(type ${target} TYPE)
    if(carrier STREQUAL mle_headers_of_tests)
      target_compile_options(${target} PRIVATE ${mle_flags_of_tests})
    elseif(type STREQUAL EXECUTABLE)
      target_compile_options(${target} PRIVATE -fPIC) # as those headers
    endif()
  endforeach()
endfunction()

# mle_precompile_headers(CARRIER DEPENDS … HEADERS …)
function(mle_precompile_headers carrier)
  cmake_parse_arguments(ARG "" "" "DEPENDS;HEADERS" ${ARGN})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${carrier}.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Carries headers.\n")
  add_library(${carrier} OBJECT ${source})
  target_link_libraries(${carrier} PRIVATE ${ARG_DEPENDS} mle_build_flags)
  target_precompile_headers(${carrier} PRIVATE ${ARG_HEADERS})
endfunction()

# What a test does itself it does once: to optimise it takes longer than it saves.
# Only where the libraries are shared and keep to their own copies of inline
# functions (-Bsymbolic-functions): a program has one copy of each, which else may
# be the test's, and the libraries would run as slowly.
set(mle_flags_of_tests)
if(MLE_BUILD_TESTS AND BUILD_SHARED_LIBS AND CMAKE_SHARED_LINKER_FLAGS MATCHES "-Bsymbolic-functions")
  set(mle_flags_of_tests -O0)
endif()

if(MLE_PRECOMPILED_HEADERS)
  set(depends absl::status absl::statusor absl::strings absl::str_format Eigen3::Eigen)
  set(headers
    <algorithm> <cmath> <cstdint> <limits> <string> <string_view> <utility> <vector>
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/LU> <Eigen/QR> <Eigen/SVD>
    <absl/status/status.h> <absl/status/statusor.h> <absl/strings/str_cat.h>
    <absl/strings/str_format.h> <absl/strings/str_join.h>)
  mle_precompile_headers(mle_headers DEPENDS ${depends} HEADERS ${headers})
  set_target_properties(mle_headers PROPERTIES POSITION_INDEPENDENT_CODE ON)
  if(MLE_BUILD_TESTS)
    mle_precompile_headers(mle_headers_of_tests
      DEPENDS ${depends} GTest::gtest GTest::gmock nlohmann_json::nlohmann_json
      HEADERS ${headers}
        <filesystem> <fstream> <map> <memory> <random> <sstream>
        <gmock/gmock.h> <gtest/gtest.h> <nlohmann/json.hpp>)
    target_compile_options(mle_headers_of_tests PRIVATE ${mle_flags_of_tests})
  endif()
endif()
