# Warnings, sanitizers and the include root, in one interface target that every target of ours links.
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

# Headers that nearly every file includes, parsed once. Executables are compiled like libraries so that they can share it.
set(CMAKE_CXX_COMPILE_OPTIONS_PIE ${CMAKE_CXX_COMPILE_OPTIONS_PIC})
add_library(doppel_pch OBJECT ${PROJECT_SOURCE_DIR}/tools/cmake/pch.cpp)
target_link_libraries(doppel_pch PRIVATE doppel_options)
target_precompile_headers(doppel_pch PRIVATE <algorithm> <cmath> <cstdint> <filesystem> <functional> <memory> <optional> <span> <sstream> <string> <vector>
  ${PROJECT_SOURCE_DIR}/sdk/math/types.h)

# doppel_library(name SOURCES a.cpp ... LINKS target ...): a static room of the house, by its folder.
function(doppel_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  if(arg_SOURCES)
    add_library(${name} STATIC ${arg_SOURCES})
    target_precompile_headers(${name} REUSE_FROM doppel_pch)
    target_link_libraries(${name} PUBLIC doppel_options ${arg_LINKS} PRIVATE ${arg_PRIVATE_LINKS})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE doppel_options ${arg_LINKS})
  endif()
endfunction()

# doppel_test(name SOURCES a.cpp ... LINKS target ... [LABELS quick|slow|vulkan|sanitize ...] [TIMEOUT s]): one GoogleTest program, one CTest entry.
# Label 'sanitize' marks the tests that the sanitizer build runs too (readers, format, reference).
if(DOPPEL_TESTS)
  find_package(GTest REQUIRED)
  add_library(doppel_test_pch OBJECT ${PROJECT_SOURCE_DIR}/tools/cmake/pch.cpp)
  target_link_libraries(doppel_test_pch PRIVATE doppel_options GTest::gtest GTest::gtest_main)
  target_precompile_headers(doppel_test_pch PRIVATE <algorithm> <cmath> <cstdint> <filesystem> <functional> <memory> <random> <span> <sstream> <string> <vector>
    <gtest/gtest.h> ${PROJECT_SOURCE_DIR}/sdk/math/types.h)
endif()

function(doppel_test name)
  cmake_parse_arguments(arg "" "TIMEOUT" "SOURCES;LINKS;LABELS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_precompile_headers(${name} REUSE_FROM doppel_test_pch)
  target_link_libraries(${name} PRIVATE doppel_options ${arg_LINKS} GTest::gtest GTest::gtest_main)
  add_test(NAME ${name} COMMAND ${name})
  if(NOT arg_LABELS)
    set(arg_LABELS quick)
  endif()
  if("sanitize" IN_LIST arg_LABELS)
    add_dependencies(sanitized_tests ${name})
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${arg_LABELS}" TIMEOUT ${arg_TIMEOUT})
endfunction()
