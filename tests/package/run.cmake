# SPDX-License-Identifier: Apache-2.0
# Installs the SDK, moves the installation, and builds and runs three consumers outside the source tree: with find_package, shared and
# static, and with pkg-config. With TOOL set, the installed `doppel` must start from the moved prefix too.
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

step(${CMAKE_COMMAND} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
     -DXR=${XR} -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
foreach(consumer consumer_c consumer_cpp consumer_static)
  step(${WORK_DIR}/build/${consumer} ${WORK_DIR}/tiny.glb)
endforeach()

file(GLOB_RECURSE pc ${WORK_DIR}/prefix/doppel.pc)
get_filename_component(pc_folder ${pc} DIRECTORY)
get_filename_component(lib_folder ${pc_folder} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_folder})
execute_process(COMMAND pkg-config --cflags --libs doppel OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags)
step(${C_COMPILER} -std=c99 ${WORK_DIR}/consumer/main.c ${flags} -Wl,-rpath,${lib_folder} -o ${WORK_DIR}/consumer_pkg_config)
step(${WORK_DIR}/consumer_pkg_config ${WORK_DIR}/tiny.glb)

if(TOOL)
  step(${WORK_DIR}/prefix/bin/doppel inspect ${WORK_DIR}/tiny.glb)
endif()
if(XR)
  step(${WORK_DIR}/prefix/bin/doppel-xr --help)
  set(ENV{XR_RUNTIME_JSON} ${WORK_DIR}/no_runtime.json)
  step(${WORK_DIR}/build/consumer_openxr)
endif()
