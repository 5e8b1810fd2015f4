# SPDX-License-Identifier: Apache-2.0
# Installs the SDK, moves the installation, and builds and runs consumers outside the source tree: with find_package and with pkg-config,
# shared and static, in C and C++, and in a project without C++. What the installed files say of their use is tried as well. With TOOL set,
# the installed `doppel` must start from the moved prefix too.
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    string(JOIN " " text ${ARGN})
    message(FATAL_ERROR "failed (${result}): ${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
step(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/before --component doppel_sdk)
if(TOOL)
  step(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/before --component doppel_tool)
endif()
file(RENAME ${WORK_DIR}/before ${WORK_DIR}/prefix)
file(COPY ${CONSUMER} DESTINATION ${WORK_DIR})  # outside the source tree, so that the consumer cannot find headers by accident
step(${MAKE_AVATAR} ${WORK_DIR}/tiny.glb)

unset(ENV{LD_LIBRARY_PATH})
set(configure ${CMAKE_COMMAND} -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -DCMAKE_C_COMPILER=${C_COMPILER})
step(${configure} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/build -DXR=${XR} -DCMAKE_CXX_COMPILER=${CXX_COMPILER})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
foreach(consumer consumer_c consumer_static consumer_cpp consumer_cpp_static)
  step(${WORK_DIR}/build/${consumer} ${WORK_DIR}/tiny.glb)
endforeach()
if(NOT EXISTS ${WORK_DIR}/tiny.glb.png OR EXISTS ${CMAKE_CURRENT_BINARY_DIR}/left.png)
  message(FATAL_ERROR "the consumer in C did not write its picture beside the avatar")
endif()
step(${configure} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/build_c -DC_ONLY=ON)
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build_c)
foreach(consumer consumer_c consumer_static)
  step(${WORK_DIR}/build_c/${consumer} ${WORK_DIR}/tiny.glb)
endforeach()

# The calls of find_package in the comments of the installed doppelConfig.cmake.
file(STRINGS ${WORK_DIR}/prefix/lib/cmake/doppel/doppelConfig.cmake comments REGEX "^# find_package")
list(LENGTH comments count)
if(NOT count EQUAL 2)
  message(FATAL_ERROR "doppelConfig.cmake has ${count} comments with find_package, not 2")
endif()
set(project "cmake_minimum_required(VERSION 3.18)\nproject(comments LANGUAGES C CXX)\n")
foreach(comment ${comments})
  if(XR OR NOT comment MATCHES openxr)
    string(REGEX REPLACE "^# (find_package.*[)])$" "\\1" call "${comment}")
    string(APPEND project "${call}\n")
  endif()
endforeach()
file(WRITE ${WORK_DIR}/comments/CMakeLists.txt "${project}")
step(${configure} -S ${WORK_DIR}/comments -B ${WORK_DIR}/build_comments -DCMAKE_CXX_COMPILER=${CXX_COMPILER})

file(GLOB_RECURSE pc ${WORK_DIR}/prefix/doppel.pc)
get_filename_component(pc_folder ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
function(pkg_config package result)
  execute_process(COMMAND pkg-config --cflags --libs ${package} OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE
    COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags)
  set(${result} ${flags} PARENT_SCOPE)
endfunction()
set(compile ${C_COMPILER} -std=c99 -o ${WORK_DIR}/consumer_pkg_config)
pkg_config(doppel flags)
execute_process(COMMAND pkg-config --variable=libdir doppel OUTPUT_VARIABLE lib_folder OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
step(${compile} ${WORK_DIR}/consumer/main.c ${flags} -Wl,-rpath,${lib_folder})
step(${WORK_DIR}/consumer_pkg_config ${WORK_DIR}/tiny.glb)
# The static library, by flags before and after the source. A program that needed the shared library would not start: it has no rpath.
pkg_config(doppel-static flags)
step(${compile} ${WORK_DIR}/consumer/main.c ${flags})
step(${WORK_DIR}/consumer_pkg_config ${WORK_DIR}/tiny.glb)
step(${compile} ${flags} ${WORK_DIR}/consumer/main.c)
step(${WORK_DIR}/consumer_pkg_config ${WORK_DIR}/tiny.glb)

# Below C++20 the first error of the wrapper is its own sentence.
execute_process(COMMAND ${CXX_COMPILER} -std=c++17 -fsyntax-only -I${WORK_DIR}/prefix/include ${WORK_DIR}/consumer/main.cpp
  RESULT_VARIABLE result ERROR_VARIABLE errors)
string(REGEX MATCH "error: [^\n]*" first "${errors}")
if(result EQUAL 0 OR NOT first MATCHES "doppel.hpp needs C\\+\\+20")
  message(FATAL_ERROR "with -std=c++17 the compiler says '${first}' first")
endif()

if(TOOL)
  step(${WORK_DIR}/prefix/bin/doppel inspect ${WORK_DIR}/tiny.glb)
endif()
if(XR)
  step(${WORK_DIR}/prefix/bin/doppel-xr --help)
  set(ENV{XR_RUNTIME_JSON} ${WORK_DIR}/no_runtime.json)
  step(${WORK_DIR}/build/consumer_openxr)
endif()
