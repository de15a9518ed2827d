# Installs BINARY_DIR to PREFIX and nothing else: a header that is installed no
# longer must not be found there from an earlier run.
file(REMOVE_RECURSE "${PREFIX}")
execute_process(
  COMMAND ${CMAKE_COMMAND} --install "${BINARY_DIR}" --prefix "${PREFIX}"
  COMMAND_ERROR_IS_FATAL ANY)
