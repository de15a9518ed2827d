# Headers that nearly every source includes, compiled once for all of them:
# about half of what a build takes. Three times, for flags must agree: for the
# libraries (position-independent), for the commands, and for tests.
#
# Off where ccache stands before the compiler, which knows results better than
# it knows precompiled headers, and as a subproject.

set(default OFF)
if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(default ON)
endif()
option(MLE_PRECOMPILED_HEADERS "Compile the headers of Eigen and others once" ${default})

# mle_add_precompiled_headers(NAME HEADERS … DEPENDS …)
function(mle_add_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "HEADERS;DEPENDS" ${ARGN})
  if(NOT MLE_PRECOMPILED_HEADERS)
    return()
  endif()
  set(target mle_headers_of_${name})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${target}.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Carries the headers of ${name}.\n")
  add_library(${target} OBJECT ${source})
  target_link_libraries(${target} PRIVATE ${ARG_DEPENDS} mle_build_flags)
  target_precompile_headers(${target} PRIVATE ${ARG_HEADERS})
endfunction()

# mle_use_precompiled_headers(NAME TARGET…)
function(mle_use_precompiled_headers name)
  if(NOT MLE_PRECOMPILED_HEADERS)
    return()
  endif()
  foreach(target IN LISTS ARGN)
    target_precompile_headers(${target} REUSE_FROM mle_headers_of_${name})
  endforeach()
endfunction()

set(common_headers
  <algorithm> <cmath> <cstdint> <limits> <string> <string_view> <utility> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/LU> <Eigen/QR> <Eigen/SVD>
  <absl/status/status.h> <absl/status/statusor.h> <absl/strings/str_cat.h>
  <absl/strings/str_format.h> <absl/strings/str_join.h>)
set(common_packages absl::status absl::statusor absl::strings absl::str_format Eigen3::Eigen)
mle_add_precompiled_headers(libraries
  HEADERS ${common_headers} DEPENDS ${common_packages})
if(MLE_PRECOMPILED_HEADERS)
  set_target_properties(mle_headers_of_libraries PROPERTIES POSITION_INDEPENDENT_CODE ON)
endif()
if(MLE_BUILD_APPS)
  mle_add_precompiled_headers(commands
    HEADERS ${common_headers} <nlohmann/json.hpp>
    DEPENDS ${common_packages} nlohmann_json::nlohmann_json)
endif()
if(MLE_BUILD_TESTS)
  mle_add_precompiled_headers(tests
    HEADERS ${common_headers} <gmock/gmock.h> <gtest/gtest.h>
    DEPENDS ${common_packages} GTest::gtest GTest::gmock)
endif()
