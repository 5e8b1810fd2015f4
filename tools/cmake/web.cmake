# SPDX-License-Identifier: Apache-2.0
# Toolchain file for WebAssembly (WASI, SIMD, one thread), with what `tools/deps web` unpacked and built.
set(CMAKE_SYSTEM_NAME Generic)  # CMake 3.25 has no WASI
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(DOPPEL_WEB ON)
set(web_root ${CMAKE_CURRENT_LIST_DIR}/../../build/toolchains/web)
if(NOT EXISTS ${web_root}/usr AND EXISTS ${web_root}.new/usr)  # while tools/deps fills the folder
  set(web_root ${web_root}.new)
endif()
set(web_llvm ${web_root}/usr/lib/llvm-19/bin)
set(CMAKE_C_COMPILER ${web_llvm}/clang)
set(CMAKE_CXX_COMPILER ${web_llvm}/clang++)
set(CMAKE_AR ${web_llvm}/llvm-ar CACHE FILEPATH "")
set(CMAKE_RANLIB ${web_llvm}/llvm-ranlib CACHE FILEPATH "")
set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_SYSROOT ${web_root}/usr)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # programs would need _start
# Debian's libc++ for wasm32 lacks threads; platform/web/lacking has what libdoppel names of them. Without an unwinder a `throw` ends the
# module (platform/web/lacking/throw.cpp); -fexceptions only lets the sources compile.
set(CMAKE_C_FLAGS_INIT "-msimd128")
set(CMAKE_CXX_FLAGS_INIT "-msimd128 -fexceptions -isystem ${CMAKE_CURRENT_LIST_DIR}/../../platform/web/lacking")
set(CMAKE_FIND_ROOT_PATH ${web_root})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
