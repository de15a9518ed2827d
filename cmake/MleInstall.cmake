# Install rules, so that find_package(mle) offers mle::mle, mle::sim,
# mle::control and each folder of mle/ as a target of its own.

include(CMakePackageConfigHelpers)

# The headers keep their paths from the root of the project, below a folder of
# their own: include/mle/mle/model/arx_model.h, include/mle/sim/plant.h.
set(mle_include_dir ${CMAKE_INSTALL_INCLUDEDIR}/mle)
set(mle_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/mle)

get_property(mle_libraries GLOBAL PROPERTY MLE_LIBRARIES)
foreach(target IN LISTS mle_libraries)
  get_target_property(file_sets ${target} INTERFACE_HEADER_SETS)
  set(headers)
  if(file_sets)
    set(headers FILE_SET HEADERS DESTINATION ${mle_include_dir} COMPONENT development)
  endif()
  install(TARGETS ${target} EXPORT mle-targets
    ARCHIVE COMPONENT development
    LIBRARY COMPONENT library NAMELINK_COMPONENT development
    ${headers})
endforeach()

get_property(mle_commands GLOBAL PROPERTY MLE_COMMANDS)
if(mle_commands)
  install(TARGETS ${mle_commands} RUNTIME COMPONENT tools)
  foreach(command IN LISTS mle_commands)
    set(manual ${PROJECT_BINARY_DIR}/apps/manuals/${command})
    install(FILES ${manual}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools)
    install(FILES ${manual}.bash RENAME ${command}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT tools)
  endforeach()
endif()

# The watch, every night: enabled by whoever has written /etc/mle/controllers.json.
if(mle_commands)
  install(FILES
    ${PROJECT_SOURCE_DIR}/apps/watch/units/mle-watch-serve.service
    ${PROJECT_SOURCE_DIR}/apps/watch/units/mle-watch.service
    ${PROJECT_SOURCE_DIR}/apps/watch/units/mle-watch.timer
    DESTINATION lib/systemd/system
    COMPONENT tools)
endif()

install(EXPORT mle-targets NAMESPACE mle:: DESTINATION ${mle_package_dir}
  COMPONENT development)

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/mleConfig.cmake.in
  ${PROJECT_BINARY_DIR}/mleConfig.cmake
  INSTALL_DESTINATION ${mle_package_dir})
# Before 1.0 a new minor version may change the interface.
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/mleConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/mleConfig.cmake
  ${PROJECT_BINARY_DIR}/mleConfigVersion.cmake
  DESTINATION ${mle_package_dir}
  COMPONENT development)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/mle
  COMPONENT tools)
install(FILES
  ${PROJECT_SOURCE_DIR}/LICENSE
  ${PROJECT_SOURCE_DIR}/README.md
  ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR}
  COMPONENT tools)

include(MlePackages)
