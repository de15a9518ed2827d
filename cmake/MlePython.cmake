# Whether the Python module is built (python/), and with which Python.
#
# Everything else of the project comes from Debian's packages, and so does the
# Python that the module is for: /usr/bin/python3, whatever stands first on
# PATH, unless Python_EXECUTABLE names another.

set(MLE_BUILD_PYTHON AUTO CACHE STRING
  "Build the Python module: ON, OFF, or AUTO: where pybind11 and Python's headers are found")
set_property(CACHE MLE_BUILD_PYTHON PROPERTY STRINGS AUTO ON OFF)

set(mle_build_python OFF)
if(MLE_BUILD_PYTHON AND MLE_BUILD_APPS AND PROJECT_IS_TOP_LEVEL)
  if(NOT DEFINED Python_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python_EXECUTABLE /usr/bin/python3)
  endif()
  set(PYBIND11_FINDPYTHON ON)
  find_package(Python 3.9 COMPONENTS Interpreter Development.Module)
  find_package(pybind11 2.9 CONFIG)
  if(Python_FOUND AND pybind11_FOUND)
    set(mle_build_python ON)
  elseif(NOT MLE_BUILD_PYTHON STREQUAL AUTO)
    message(FATAL_ERROR "MLE_BUILD_PYTHON is ON, but pybind11 or Python's headers are missing "
      "(Debian: pybind11-dev, python3-dev)")
  else()
    message(STATUS "mle: without the Python module: pybind11 or Python's headers are missing")
  endif()
endif()
