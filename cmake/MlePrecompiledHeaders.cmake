# Headers that nearly every test includes, compiled once for all of them. Libraries
# and commands are built as a few large sources (MleUnityBuild.cmake) instead.
#
# Off where ccache stands before the compiler, which knows results better than
# it knows precompiled headers, and as a subproject.

option(MLE_PRECOMPILED_HEADERS "Compile the headers of tests once" ${mle_builds_whole})

# mle_use_precompiled_headers(TARGET…): for tests.
function(mle_use_precompiled_headers)
  if(NOT MLE_PRECOMPILED_HEADERS)
    return()
  endif()
  foreach(target IN LISTS ARGN)
    target_precompile_headers(${target} REUSE_FROM mle_headers_of_tests)
  endforeach()
endfunction()

if(MLE_BUILD_TESTS AND MLE_PRECOMPILED_HEADERS)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/mle_headers_of_tests.cc)
  file(CONFIGURE OUTPUT ${source} CONTENT "// Carries the headers of tests.\n")
  add_library(mle_headers_of_tests OBJECT ${source})
  target_link_libraries(mle_headers_of_tests PRIVATE
    absl::status absl::statusor absl::strings absl::str_format Eigen3::Eigen
    GTest::gtest GTest::gmock mle_build_flags)
  target_precompile_headers(mle_headers_of_tests PRIVATE
    <algorithm> <cmath> <cstdint> <limits> <string> <string_view> <utility> <vector>
    <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/LU> <Eigen/QR> <Eigen/SVD>
    <absl/status/status.h> <absl/status/statusor.h> <absl/strings/str_cat.h>
    <absl/strings/str_format.h> <absl/strings/str_join.h>
    <gmock/gmock.h> <gtest/gtest.h>)
endif()
