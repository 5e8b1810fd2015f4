# SPDX-License-Identifier: Apache-2.0
# cmake -DREADELF=... -DFILES="a;b" -P check_needed.cmake: checks that these files do not link the Vulkan loader, so that
# they start on a machine without it.
foreach(file IN LISTS FILES)
  execute_process(COMMAND ${READELF} -d ${file} OUTPUT_VARIABLE output RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${READELF} could not read ${file}")
  endif()
  if(NOT output MATCHES "NEEDED.*libc\\.")
    message(FATAL_ERROR "${file}: no list of needed libraries was found in\n${output}")
  endif()
  if(output MATCHES "NEEDED[^\n]*vulkan")
    message(FATAL_ERROR "${file} needs libvulkan to start; sdk/backend/vulkan/vk_loader.cpp loads it at run time instead")
  endif()
  message(STATUS "${file} starts without libvulkan")
endforeach()
