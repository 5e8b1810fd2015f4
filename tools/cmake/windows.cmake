# SPDX-License-Identifier: Apache-2.0
# Toolchain file for 64-bit Windows by MinGW, with what `tools/deps windows` built and unpacked.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
# Without the dots: CMake lists a library twice that it knows by two paths, and the order of libraries decides the bytes of the DLL.
get_filename_component(CMAKE_FIND_ROOT_PATH ${CMAKE_CURRENT_LIST_DIR}/../../build/toolchains/windows ABSOLUTE)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# FindVulkan wants a library. libdoppel links none: it loads vulkan-1.dll at run time.
set(Vulkan_LIBRARY vulkan-1 CACHE STRING "Not linked")
