# SPDX-License-Identifier: Apache-2.0
# cmake -DIN=x.metal -DOUT=x.cpp -DENTRY=name -P to_cpp.cmake: converts one emitted kernel to a C++ file with a dispatch function.
file(READ ${IN} text)
# Newer SPIRV-Cross defines its array type with one overload per address space. C++ has no address spaces; msl_cpu.h has a plain definition.
string(FIND "${text}" "template<typename T, size_t Num>\nstruct spvUnsafeArray" array_begin)
if(array_begin GREATER -1)
  string(SUBSTRING "${text}" 0 ${array_begin} before)
  string(SUBSTRING "${text}" ${array_begin} -1 after)
  string(FIND "${after}" "\n};" array_end)
  math(EXPR array_end "${array_end} + 3")
  string(SUBSTRING "${after}" ${array_end} -1 after)
  set(text "${before}${after}")
endif()
string(REGEX REPLACE "\n( +)threadgroup ([a-zA-Z_0-9]+(<[^;()]*>)? [^(;]*;)" "\n\\1static \\2" text "${text}")
string(REGEX REPLACE "\\.(xyz|xy|zw|xz|yw)([^a-z_A-Z0-9])" ".\\1()\\2" text "${text}")  # GLM's swizzles are functions
if(text MATCHES "\\[\\[thread_position_in_grid\\]\\]")
  set(global true)
else()
  set(global false)
endif()
if(NOT text MATCHES "gl_WorkGroupSize[^=]*= uint3\\(([0-9]+)u")
  set(CMAKE_MATCH_1 1)  # SPIRV-Cross omits the constant for groups of one thread
endif()
file(WRITE ${OUT}.tmp "#include \"tests/metal/cpu/msl_cpu.h\"
namespace ${ENTRY}_space {
using metal::uint;
${text}
}
bool ${ENTRY}(void* const* buffers, unsigned groups, int order) {
    return msl::dispatch(${ENTRY}_space::main0, buffers, groups, ${CMAKE_MATCH_1}, ${global}, order);
}
")
file(RENAME ${OUT}.tmp ${OUT})
