# SPDX-License-Identifier: Apache-2.0
# Warnings, sanitizers and the include root: an interface target that every target of this project links.
add_library(doppel_options INTERFACE)
target_compile_features(doppel_options INTERFACE cxx_std_20)
target_compile_options(doppel_options INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wno-missing-field-initializers -Wno-unused-parameter -ffp-contract=off>
  $<$<COMPILE_LANGUAGE:C>:-Wall -Wextra>)
target_include_directories(doppel_options INTERFACE ${PROJECT_SOURCE_DIR})
if(DOPPEL_SANITIZE)
  target_compile_options(doppel_options INTERFACE -fsanitize=${DOPPEL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(doppel_options INTERFACE -fsanitize=${DOPPEL_SANITIZE})
endif()

# Precompiled headers: headers that nearly every file includes, parsed once per kind of target. The variant with JSON costs half a second
# per file, so it is only for targets in which most files use JSON (option JSON).
# Executables are compiled with the PIC flags of libraries so that they can share a precompiled header.
# Headers in <> keep the text equal in every checkout, so that ccache finds it.
set(CMAKE_CXX_COMPILE_OPTIONS_PIE ${CMAKE_CXX_COMPILE_OPTIONS_PIC})
function(doppel_pch name)  # doppel_pch(name HEADERS ... LINKS ... OPTIONS ...)
  cmake_parse_arguments(arg "" "" "HEADERS;LINKS;OPTIONS" ${ARGN})
  add_library(${name} OBJECT ${PROJECT_SOURCE_DIR}/tools/cmake/pch.cpp)
  target_link_libraries(${name} PRIVATE doppel_options glm::glm ${arg_LINKS})
  target_compile_options(${name} PRIVATE ${arg_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${arg_HEADERS} <sdk/math/types.h>)
endfunction()
function(doppel_use_pch target pch json)
  if(json AND NOT DOPPEL_WEB)  # two of the inputs in json_once.h are one type in the libc++ of WebAssembly
    target_precompile_headers(${target} REUSE_FROM ${pch}_json)
    target_link_libraries(${target} PRIVATE doppel_json_once)
  else()
    target_precompile_headers(${target} REUSE_FROM ${pch})
  endif()
endfunction()

find_package(glm REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
set(pch_headers <algorithm> <cmath> <cstdint> <filesystem> <functional> <memory> <optional> <span> <sstream> <string> <vector>)
doppel_pch(doppel_pch HEADERS ${pch_headers})
doppel_pch(doppel_pch_json HEADERS ${pch_headers} <tools/cmake/json_once.h> LINKS nlohmann_json::nlohmann_json)
add_library(doppel_json_once STATIC ${PROJECT_SOURCE_DIR}/tools/cmake/json_once.cpp)
target_link_libraries(doppel_json_once PRIVATE doppel_options nlohmann_json::nlohmann_json)

# doppel_library(name [HOT] [JSON] SOURCES a.cpp ... LINKS target ... PRIVATE_LINKS target ...): a static library, or an interface library
# without sources. HOT: compile with -O3 in Release, each file by itself, because Highway includes a kernel's file once for each
# instruction set. JSON: use the precompiled header with JSON.
function(doppel_library name)
  cmake_parse_arguments(arg "HOT;JSON" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(arg_SOURCES)
    add_library(${name} STATIC ${arg_SOURCES})
    target_link_libraries(${name} PUBLIC doppel_options ${arg_LINKS} PRIVATE ${arg_PRIVATE_LINKS})
    if(NOT (arg_HOT AND DOPPEL_WEB))  # clang takes no header that was compiled for size into a file that is compiled for speed
      doppel_use_pch(${name} doppel_pch ${arg_JSON})
    endif()
    if(arg_HOT)
      set_target_properties(${name} PROPERTIES UNITY_BUILD OFF)
      target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O3>)
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE doppel_options ${arg_LINKS})
  endif()
endfunction()

# doppel_parts_of(target PARTS): sets PARTS to `target`, all static libraries of this project that it links, directly or not, and the object
# libraries among their sources.
function(doppel_parts_of target parts)
  set(open ${target})
  set(seen)
  set(found)
  while(open)
    list(POP_FRONT open name)
    list(APPEND seen ${name})
    get_target_property(type ${name} TYPE)
    if(type STREQUAL "INTERFACE_LIBRARY")  # has no objects
      get_target_property(links ${name} INTERFACE_LINK_LIBRARIES)
    else()
      list(APPEND found ${name})
      get_target_property(sources ${name} SOURCES)
      foreach(source ${sources})
        if(source MATCHES "^\\$<TARGET_OBJECTS:(.+)>$")
          list(APPEND found ${CMAKE_MATCH_1})
        endif()
      endforeach()
      get_target_property(links ${name} LINK_LIBRARIES)
    endif()
    foreach(link ${links})
      string(REGEX REPLACE "^\\$<[A-Z_]+:(.+)>$" "\\1" link "${link}")
      if(TARGET ${link} AND NOT link IN_LIST seen AND NOT link IN_LIST open)
        get_target_property(type ${link} TYPE)
        get_target_property(imported ${link} IMPORTED)
        if(NOT imported AND type MATCHES "^(STATIC|INTERFACE)_LIBRARY$")
          list(APPEND open ${link})
        endif()
      endif()
    endforeach()
  endwhile()
  set(${parts} ${found} PARENT_SCOPE)
endfunction()

# doppel_shader_pack(name FOLDER METAL_NAME [NAMESPACE]): a library with the compiled shaders of FOLDER/catalogue.json, and one with those
# for Metal. Their functions are in NAMESPACE (dpl). The files of tools/shaderpack are written into the current binary folder.
function(doppel_shader_pack name folder metal)
  # One run compiles the whole catalogue; the depfile lists every file that it read.
  file(GLOB shared_headers CONFIGURE_DEPENDS ${folder}/shared/*.h)
  add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/shader_pack.cpp ${CMAKE_CURRENT_BINARY_DIR}/metal_pack.cpp
      ${CMAKE_CURRENT_BINARY_DIR}/shaders.dplpack
    COMMAND shaderpack ${PROJECT_SOURCE_DIR} ${folder}/catalogue.json ${CMAKE_CURRENT_BINARY_DIR} ${ARGN}
    DEPENDS shaderpack ${folder}/catalogue.json ${shared_headers}
    DEPFILE ${CMAKE_CURRENT_BINARY_DIR}/shader_pack.d
    COMMENT "Building a shader pack: ${name} (SPIR-V, MSL, reflection)" VERBATIM)
  doppel_library(${name} SOURCES ${CMAKE_CURRENT_BINARY_DIR}/shader_pack.cpp)
  doppel_library(${metal} SOURCES ${CMAKE_CURRENT_BINARY_DIR}/metal_pack.cpp)
  if(NOT DOPPEL_METAL)
    set_target_properties(${metal} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  add_dependencies(${metal} ${name})  # one run of the shader build
endfunction()

# doppel_test(name SOURCES a.cpp ... LINKS target ... [LABELS quick|slow|vulkan|sanitize ...]): one GoogleTest program and CTest entry.
# Default: label quick. Tests labelled sanitize (readers, format, reference, software Metal device) also run in the build with sanitizers.
if(DOPPEL_TESTS)
  find_package(GTest REQUIRED)
  # Programs of all tests labelled `sanitize`. tools/test builds them with sanitizers.
  add_custom_target(sanitized_tests)
  # Programs of all tests labelled `vulkan`. tools/prove-drivers builds them.
  add_custom_target(vulkan_tests)
  set(test_pch_headers ${pch_headers} <random> <gtest/gtest.h>)
  # -O1 saves a third of a test's compile time. The code under test keeps its own optimisation level.
  set(test_options $<$<CONFIG:Release>:-O1>)
  doppel_pch(doppel_test_pch HEADERS ${test_pch_headers} LINKS GTest::gtest OPTIONS ${test_options})
  doppel_pch(doppel_test_pch_json HEADERS ${test_pch_headers} <tools/cmake/json_once.h> LINKS GTest::gtest nlohmann_json::nlohmann_json
    OPTIONS ${test_options})
endif()

function(doppel_test name)
  if(NOT DOPPEL_TESTS)
    return()
  endif()
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;LABELS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE doppel_options ${arg_LINKS} GTest::gtest GTest::gtest_main)
  list(FIND arg_LINKS nlohmann_json::nlohmann_json json_link)
  if(json_link GREATER -1)
    doppel_use_pch(${name} doppel_test_pch TRUE)
  else()
    doppel_use_pch(${name} doppel_test_pch FALSE)
  endif()
  target_compile_options(${name} PRIVATE ${test_options})
  add_test(NAME ${name} COMMAND ${name})
  if(NOT arg_LABELS)
    set(arg_LABELS quick)
  endif()
  if("sanitize" IN_LIST arg_LABELS)
    add_dependencies(sanitized_tests ${name})
  endif()
  if("vulkan" IN_LIST arg_LABELS)
    add_dependencies(vulkan_tests ${name})
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${arg_LABELS}" ENVIRONMENT "DOPPEL_SOURCE_DIR=${PROJECT_SOURCE_DIR}")
endfunction()
