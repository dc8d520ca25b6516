# Debian packages: cpack --config build/release/CPackConfig.cmake -B DIR (docs/install.md).

set(ORIENT_PACKAGE_MAINTAINER "Orient maintainers <maintainers@orient.invalid>" CACHE STRING
    "Maintainer of the Debian packages: name <address>")

# Development packages needed to build against the installed libraries, which are static.
set(orient_dev_packages libeigen3-dev libceres-dev libgdal-dev libopencv-dev libdeflate-dev
    libspng-dev
    libfmt-dev libpugixml-dev libsqlite3-dev libsqlitecpp-dev libtbb-dev libtomlplusplus-dev
    nlohmann-json3-dev libboost-math-dev)
list(JOIN orient_dev_packages ", " orient_dev_depends)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME orient)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT ${ORIENT_PACKAGE_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
    GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL orient liborient-dev python3-orient)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_ORIENT_PACKAGE_NAME orient)
set(CPACK_DEBIAN_ORIENT_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ORIENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_ORIENT_DESCRIPTION
    "automatic orientation of scanned aerial film photos
Interior orientation from fiducial marks, exterior orientation from patches of
known ground position, bundle block adjustment and orthophotos of whole blocks
of scanned or digital aerial photos, with covariances and a report.")

set(CPACK_DEBIAN_LIBORIENT-DEV_PACKAGE_NAME liborient-dev)
set(CPACK_DEBIAN_LIBORIENT-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBORIENT-DEV_PACKAGE_DEPENDS ${orient_dev_depends})
set(CPACK_COMPONENT_LIBORIENT-DEV_DESCRIPTION
    "automatic orientation of aerial photos (libraries and headers)
Static libraries and headers of orient's modules, for find_package(orient):
interior orientation, patch database, exterior orientation, block adjustment.")

# The extension module is built for one minor version of Python 3: Debian's.
math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON3-ORIENT_PACKAGE_NAME python3-orient)
set(CPACK_DEBIAN_PYTHON3-ORIENT_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-ORIENT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON3-ORIENT_PACKAGE_DEPENDS "python3 (>= 3.${Python3_VERSION_MINOR}), \
python3 (<< 3.${next_python}), python3-numpy, orient (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON3-ORIENT_PACKAGE_SUGGESTS python3-geopandas)
set(CPACK_COMPONENT_PYTHON3-ORIENT_DESCRIPTION
    "automatic orientation of aerial film photos (Python module)
Runs orient's commands, reads their results as NumPy arrays and GeoDataFrames,
and projects between scans and ground with a photo's whole geometry.")

# Files that Debian requires in every package.
set(package_files ${PROJECT_BINARY_DIR}/package)
configure_file(cmake/package/copyright ${package_files}/copyright COPYONLY)
configure_file(cmake/package/changelog.in ${package_files}/changelog @ONLY)
execute_process(COMMAND gzip -9nkf ${package_files}/changelog COMMAND_ERROR_IS_FATAL ANY)
foreach(package orient liborient-dev python3-orient)
  install(FILES ${package_files}/copyright ${package_files}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
endforeach()

include(CPack)
