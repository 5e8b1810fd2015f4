# SPDX-License-Identifier: Apache-2.0
# cmake -DIN=x.metal -DOUT=x.cpp -DENTRY=name -DSHADER=pack.name -P to_cpp.cmake: converts one emitted shader to a C++ file that describes
# it as msl::Entry and, under the name ENTRY, runs it with buffers in order.
file(READ ${IN} text)
set(original "${text}")
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
string(REGEX REPLACE "\n    ([a-zA-Z_0-9]+) ([a-zA-Z_0-9]+)\\[1\\];\n};" "\n    msl::Unsized<\\1> \\2;\n};" text "${text}")
string(REGEX REPLACE "([^a-zA-Z_0-9.])([0-9]+\\.[0-9]+(e[-+]?[0-9]+)?)" "\\1\\2f" text "${text}")  # MSL's literals are floats
string(REGEX REPLACE "([a-zA-Z_0-9]+)\\.xy \\+= ([^;]*);" "msl::addToXy(\\1, \\2);" text "${text}")
string(REGEX REPLACE "\\.(xyz|xy|zw|xz|yz|yw)([^a-z_A-Z0-9])" ".\\1()\\2" text "${text}")  # GLM's swizzles are functions
if(text MATCHES "\\.[xyzw][xyzw]+\\(\\) [-+*/]?= ")
  message(FATAL_ERROR "${IN}: assigns to a swizzle, which GLM cannot: '${CMAKE_MATCH_0}'")
endif()
file(WRITE ${OUT}.tmp "#include \"tests/metal/cpu/msl_cpu.h\"
namespace ${ENTRY}_space {
using metal::uint;
${text}
}
const msl::Entry& ${ENTRY}_entry() {
    static const msl::Entry entry = msl::makeEntry<&${ENTRY}_space::main0>(\"${SHADER}\", R\"dplmsl(${original})dplmsl\");
    return entry;
}
bool ${ENTRY}(void* const* buffers, unsigned groups, int order) { return msl::dispatchInOrder(${ENTRY}_entry(), buffers, groups, order); }
")
file(RENAME ${OUT}.tmp ${OUT})
