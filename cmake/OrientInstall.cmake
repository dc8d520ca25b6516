# Installed by `cmake --install`: the program, its camera library, and the modules as libraries
# (orient::interior, orient::patchdb, orient::exterior, orient::block) with their public headers.

include(CMakePackageConfigHelpers)

# Components, each a package of OrientPackage: `orient` (the program and all that belongs to it) and
# `liborient-dev` here, `python3-orient` in python/CMakeLists.txt.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME orient)

# The program finds the camera library in ../share/orient/cameras, relative to its own folder.
install(TARGETS orient RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY data/cameras DESTINATION ${CMAKE_INSTALL_DATADIR}/orient)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME liborient-dev)
# The modules' public headers: those named here and all that they include. All others are private.
set(ORIENT_PUBLIC_HEADERS
    interior/interior.h interior/camera_choice.h
    patchdb/store/patch_database.h patchdb/store/selection.h patchdb/harvest/harvest.h
    exterior/orient_photo.h exterior/steps/predict.h exterior/principal_distance.h
    block/block.h block/bundle/adjustment.h block/ties/tie_points.h block/roll/roll.h
    core/base/error.h core/files/camera_file.h core/files/orientation_table.h)

function(orient_headers_with_theirs out)
  set(known "")
  set(open ${ARGN})
  while(open)
    list(POP_FRONT open header)
    if(header IN_LIST known)
      continue()
    endif()
    list(APPEND known ${header})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} includes REGEX "^#include \"")
    foreach(line IN LISTS includes)
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      list(APPEND open ${included})
    endforeach()
  endwhile()
  set(${out} ${known} PARENT_SCOPE)
endfunction()

orient_headers_with_theirs(headers ${ORIENT_PUBLIC_HEADERS})
# A new include in one of them may make another header public.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${headers})
foreach(header IN LISTS headers)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/orient/${folder})
endforeach()

install(TARGETS orient_base orient_geometry orient_terrain orient_raster orient_matching orient_files
                orient_measurements orient_exchange orient_interior orient_patchdb orient_exterior
                orient_ortho orient_block
        EXPORT orient_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/orient)
install(EXPORT orient_targets NAMESPACE orient:: FILE orient-targets.cmake
        DESTINATION ${package_folder})
configure_package_config_file(cmake/orient-config.cmake.in orient-config.cmake
                              INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(orient-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/orient-config.cmake
              ${PROJECT_BINARY_DIR}/orient-config-version.cmake DESTINATION ${package_folder})
