# Files installed beside program and library, and the .deb: tools/packaging/deb.sh configures, builds and runs cpack.
# One package holds all of it. A distribution would split it into slipdisk, libslipdisk0, libslipdisk-dev, python3-slipdisk and
# slipdisk-doc, which the package therefore provides.
set(sd_packaging ${CMAKE_CURRENT_LIST_DIR})
install(FILES LICENSE CITATION.cff README.md TYPE DOC)
# The site where it has been built (tools/docs.sh), else its sources.
set(SLIPDISK_SITE ${PROJECT_SOURCE_DIR}/build/site CACHE PATH "The documentation site, to be installed where it exists")
install(CODE "
  set(doc \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/doc/slipdisk\")
  if(EXISTS ${SLIPDISK_SITE}/index.html)
    file(INSTALL ${SLIPDISK_SITE}/ DESTINATION \"\${doc}/html\")
  else()
    file(INSTALL ${PROJECT_SOURCE_DIR}/docs DESTINATION \"\${doc}\")
  endif()")

file(STRINGS include/slipdisk/version.h sd_version_date REGEX "define SD_VERSION_DATE \"")
string(REGEX REPLACE ".*\"(.*)\".*" "\\1" sd_version_date "${sd_version_date}")
set(SLIPDISK_MAINTAINER "The slipdisk authors <authors@slipdisk.invalid>" CACHE STRING "Of the .deb: name and address")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME slipdisk)
set(CPACK_PACKAGE_CONTACT "${SLIPDISK_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "discrete-element engine for frictional disks in two dimensions")
set(CPACK_PACKAGE_DESCRIPTION
"Follows disks that touch each other and walls through a normal spring
(linear or Hertz), damped, and a tangential spring limited by friction, and
measures how they rotate, slide and dissipate: from three vibrated disks over
many steps to packings of many. Runs survive being killed and give the same
bits on any number of threads.
.
This package holds the program, the C library with its headers, the Python
package, documentation and example decks.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES TRUE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
    WORLD_EXECUTE)
set(CPACK_THREADS 0)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_PROVIDES "libslipdisk${PROJECT_VERSION_MAJOR}, libslipdisk-dev, python3-slipdisk")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-numpy, python3-h5py, python3-matplotlib, libjs-sphinxdoc")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg, xdg-utils, man-db, bash-completion")
# Programs that are linked with the library depend on a package that has it; ldconfig is told by a trigger.
file(WRITE ${PROJECT_BINARY_DIR}/debian/shlibs "libslipdisk ${PROJECT_VERSION_MAJOR} slipdisk (>= ${PROJECT_VERSION})\n")
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${sd_packaging}/debian/postinst ${sd_packaging}/debian/prerm ${sd_packaging}/debian/postrm
    ${PROJECT_BINARY_DIR}/debian/shlibs ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
configure_file(${sd_packaging}/finish.cmake.in ${PROJECT_BINARY_DIR}/finish.cmake @ONLY)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_BINARY_DIR}/finish.cmake)
include(CPack)
