# SPDX-License-Identifier: Apache-2.0
# The version has one source, DPL_VERSION_TEXT in doppel.h, which is a semantic version such as 1.0.0-rc.1. From it come:
#   DOPPEL_VERSION           the same text: `doppel --version`, names of archives
#   DOPPEL_VERSION_NUMBERS   1.0.0: CMake's and pkg-config's version, and the library's file name, which are numbers only
#   DOPPEL_VERSION_DEBIAN    1.0.0~rc.1: Debian sorts ~ before the end of a text, so that a candidate is older than its release
# tests/structure/check_version.py holds this.
set(header ${CMAKE_CURRENT_LIST_DIR}/../../sdk/include/doppel/doppel.h)
file(STRINGS ${header} DOPPEL_VERSION REGEX "^#define DPL_VERSION_TEXT ")
string(REGEX REPLACE "^[^\"]*\"([^\"]*)\".*" "\\1" DOPPEL_VERSION "${DOPPEL_VERSION}")
if(NOT DOPPEL_VERSION MATCHES "^[0-9]+\\.[0-9]+\\.[0-9]+(-[a-z]+\\.[0-9]+)?$")
  message(FATAL_ERROR "DPL_VERSION_TEXT in ${header} is '${DOPPEL_VERSION}'; it must read like 1.0.0 or 1.0.0-rc.1")
endif()
string(REGEX REPLACE "-.*" "" DOPPEL_VERSION_NUMBERS ${DOPPEL_VERSION})
string(REPLACE "-" "~" DOPPEL_VERSION_DEBIAN ${DOPPEL_VERSION})
if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)  # cmake -P: prints them, for the test
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${DOPPEL_VERSION} ${DOPPEL_VERSION_NUMBERS} ${DOPPEL_VERSION_DEBIAN}")
else()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
endif()
