# SPDX-License-Identifier: Apache-2.0
# Install components, and the Debian packages that cpack makes of them. A plain build has two components, doppel_sdk and doppel_tool.
# With DOPPEL_PACKAGES each Debian package is a component of its name; tools/release configures so.
set(doppel_library_component doppel_sdk)
set(doppel_sdk_component doppel_sdk)
set(doppel_tools_component doppel_tool)
set(doppel_viewer_component doppel_tool)
if(NOT DOPPEL_PACKAGES)
  return()
endif()
set(doppel_library_component libdoppel${PROJECT_VERSION_MAJOR})
set(doppel_sdk_component libdoppel-dev)
set(doppel_tools_component doppel-tools)
set(doppel_viewer_component doppel-viewer)

include(GNUInstallDirs)
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(system)  # deb12, ubuntu24.04
foreach(field ID VERSION_ID)
  file(STRINGS /etc/os-release line REGEX "^${field}=")
  string(REGEX REPLACE "^${field}=\"?([^\"]*)\"?$" "\\1" line "${line}")
  string(APPEND system "${line}")
endforeach()
string(REPLACE "debian" "deb" system "${system}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME doppel)
set(CPACK_PACKAGE_VENDOR "The Doppel authors")
set(CPACK_PACKAGE_CONTACT "The Doppel authors <doppel@localhost.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_COMPONENTS_ALL ${doppel_library_component} ${doppel_sdk_component} ${doppel_tools_component} ${doppel_viewer_component})
set(CPACK_DEBIAN_PACKAGE_VERSION ${DOPPEL_VERSION_DEBIAN})
# The revision says for which Debian: an upgrade of the system then brings the packages of the newer one.
set(CPACK_DEBIAN_PACKAGE_RELEASE 1~${system})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/sdk/api)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

# doppel_package(NAME SECTION DEPENDS RECOMMENDS DESCRIPTION): the fields of a package, and its licences in share/doc. cpack puts the
# project's description above its own.
set(same_version "(= ${DOPPEL_VERSION_DEBIAN}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(copyrights)
function(doppel_package name section depends recommends description)
  string(TOUPPER ${name} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS "${recommends}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${description}" PARENT_SCOPE)
  set(copyright ${PROJECT_BINARY_DIR}/copyright/${name}/copyright)
  add_custom_command(OUTPUT ${copyright}
    COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/packaging/notices.py ${name} ${copyright}
    DEPENDS ${PROJECT_SOURCE_DIR}/tools/packaging/notices.py ${PROJECT_SOURCE_DIR}/NOTICE VERBATIM)
  list(APPEND copyrights ${copyright})
  set(copyrights ${copyrights} PARENT_SCOPE)
  install(FILES ${copyright} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${name})
endfunction()
doppel_package(${doppel_library_component} libs "" "libvulkan1" "The library: loads, poses and draws avatars,
on the CPU or with Vulkan, which it looks for at run time.")
doppel_package(${doppel_sdk_component} libdevel "${doppel_library_component} ${same_version}"
  "libdraco-dev, libhwy-dev, libzstd-dev, zlib1g-dev" "Headers of the C and C++ interfaces, the
static library, and files for CMake and pkg-config. The static library needs
the recommended packages.")
set(CPACK_DEBIAN_LIBDOPPEL-DEV_PACKAGE_SUGGESTS libopenxr-dev)
# It carries a library of its own (apps/doppel), so that its one file installs alone.
doppel_package(${doppel_tools_component} graphics "" "ffmpeg, colmap, python3"
  "The program doppel: from videos of a person to an
avatar, on the CPU. ffmpeg reads and writes videos, COLMAP finds cameras. No
neural network is inside: doppel setup fetches them, with Python.")
doppel_package(${doppel_viewer_component} graphics "${doppel_library_component} ${same_version}" "" "The programs doppel-viewer,
which needs a Vulkan driver, and doppel-xr, which needs an OpenXR runtime.")
add_custom_target(doppel_copyrights ALL DEPENDS ${copyrights})
string(TOUPPER ${doppel_library_component} upper)
set(CPACK_DEBIAN_${upper}_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_${upper}_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
include(CPack)
