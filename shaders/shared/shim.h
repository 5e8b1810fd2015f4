// SPDX-License-Identifier: Apache-2.0
// Maps GLSL type names to C++ so that both languages read the same structs. GLSL sees nothing of this file but its guard.
#ifndef DPL_SHARED_SHIM_H
#define DPL_SHARED_SHIM_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
namespace dpl::gpu {
using uint = uint32_t;
struct alignas(8) vec2 {
    float x, y;
};
struct alignas(16) vec4 {
    float x, y, z, w;
};
struct alignas(8) uvec2 {
    uint x, y;
};
struct alignas(16) uvec4 {
    uint x, y, z, w;
};
}  // namespace dpl::gpu
#define DPL_SHARED_BEGIN namespace dpl::gpu {
#define DPL_SHARED_END }
#define DPL_CONST constexpr
#define DPL_SHARED_SIZE(type, bytes) static_assert(sizeof(type) == bytes);
#else
#define DPL_SHARED_BEGIN
#define DPL_SHARED_END
#define DPL_CONST const
#define DPL_SHARED_SIZE(type, bytes)
#endif

#endif
