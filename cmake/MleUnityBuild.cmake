# Several sources of a target compiled as one: most of what a build takes is the
# headers of Eigen and others, anew for every source. So a target's sources are
# not to define the same name in their unnamed namespaces (scripts/lint looks).
#
# Off as a subproject. To compile each source alone, as suits ccache where one
# source changes at a time: -DMLE_UNITY_BUILD=OFF.

set(mle_builds_whole OFF)
if(PROJECT_IS_TOP_LEVEL)
  set(mle_builds_whole ON)
endif()
option(MLE_UNITY_BUILD "Compile sources of a target together" ${mle_builds_whole})
# At most so many at once: more would take more memory than time.
set(MLE_UNITY_BATCH 16 CACHE STRING "Sources that are compiled together, at most; 0: all of a library")
mark_as_advanced(MLE_UNITY_BATCH)
set(CMAKE_UNITY_BUILD_BATCH_SIZE ${MLE_UNITY_BATCH})
