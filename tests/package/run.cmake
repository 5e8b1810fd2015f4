# SPDX-License-Identifier: Apache-2.0
# Installs the SDK's component, builds the consumer outside the tree against it, runs it.
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    string(JOIN " " text ${ARGN})
    message(FATAL_ERROR "failed (${result}): ${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
step(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix --component doppel_sdk)
file(COPY ${CONSUMER} DESTINATION ${WORK_DIR})  # outside our tree: nothing can be found by accident
step(${MAKE_AVATAR} ${WORK_DIR}/tiny.glb)
step(${CMAKE_COMMAND} -S ${WORK_DIR}/consumer -B ${WORK_DIR}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix
     -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
step(${WORK_DIR}/build/consumer_c ${WORK_DIR}/tiny.glb)
step(${WORK_DIR}/build/consumer_cpp ${WORK_DIR}/tiny.glb)
