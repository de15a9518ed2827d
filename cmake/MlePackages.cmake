# Debian packages, by cpack: libmle0 (the libraries), libmle-dev (headers and
# CMake package), mle-tools (the commands), python3-mle (the Python package).
# scripts/package makes them.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mle)
set(CPACK_PACKAGE_VENDOR "Model Life Extension")
set(CPACK_PACKAGE_CONTACT "Model Life Extension <maintainers@mle.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL library development tools)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# What the programs are linked with, in the versions they were linked with; our
# own libraries are not packages yet when that is looked up.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
get_property(mle_libraries GLOBAL PROPERTY MLE_LIBRARIES)
set(mle_library_dirs)
foreach(target IN LISTS mle_libraries)
  get_target_property(dir ${target} BINARY_DIR)
  list(APPEND mle_library_dirs ${dir})
endforeach()
list(REMOVE_DUPLICATES mle_library_dirs)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${mle_library_dirs})

set(mle_package_version "(= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libmle${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/cmake/debian/triggers)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "${PROJECT_DESCRIPTION} (libraries)")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmle-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libmle${PROJECT_VERSION_MAJOR} ${mle_package_version}, libabsl-dev, libeigen3-dev (>= 3.4)")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
  "${PROJECT_DESCRIPTION} (headers and CMake package)")
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME mle-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS
  "libmle${PROJECT_VERSION_MAJOR} ${mle_package_version}, tzdata")
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS librsvg2-bin)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "${PROJECT_DESCRIPTION} (commands)")

if(mle_build_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  # The module is for one version of Python.
  math(EXPR mle_next_python_minor "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-mle)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "libmle${PROJECT_VERSION_MAJOR} ${mle_package_version}, \
python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), \
python3 (<< ${Python_VERSION_MAJOR}.${mle_next_python_minor}~), python3-numpy, tzdata")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS python3-pandas)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-scipy")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "${PROJECT_DESCRIPTION} (Python package)")
endif()

include(CPack)
