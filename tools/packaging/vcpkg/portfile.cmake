# SPDX-License-Identifier: Apache-2.0
# A vcpkg port of the SDK. Never run. Use it as an overlay port of a checkout: vcpkg install doppel --overlay-ports=tools/packaging/vcpkg
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}" OPTIONS -DDOPPEL_RECONSTRUCTION=OFF -DDOPPEL_TESTS=OFF)
vcpkg_cmake_build(TARGET doppel_installed)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/doppel)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE" "${SOURCE_PATH}/NOTICE")
