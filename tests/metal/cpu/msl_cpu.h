// SPDX-License-Identifier: Apache-2.0
// The part of the Metal standard library, built on GLM, that is needed to compile the kernels emitted by SPIRV-Cross as C++ and to run them
// on the CPU. Each thread of a threadgroup is a fiber; a barrier switches fibers. This tests what kernels compute, not whether Apple's
// compiler accepts them.
#pragma once

#define GLM_FORCE_SWIZZLE
#define GLM_FORCE_SILENT_WARNINGS
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/packing.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tuple>
#include <vector>

namespace msl {

/** Runs the `lanes` threads of one threadgroup to their end. order: 0 forward, 1 reverse, 2 shuffled with a fixed seed.
 *  Returns false when some lanes end while others wait at a barrier. Not reentrant; call from one CPU thread. */
bool runGroup(uint32_t lanes, int order, const std::function<void(uint32_t lane)>& body);
/** Switches to the next fiber. Only valid inside runGroup(). */
void barrier();

}  // namespace msl

namespace metal {

using uint = uint32_t;
using float2 = glm::vec2;
using float3 = glm::vec3;
using packed_float3 = glm::vec3;
using float4 = glm::vec4;
using int2 = glm::ivec2;
using int4 = glm::ivec4;
using uint2 = glm::uvec2;
using uint3 = glm::uvec3;
using uint4 = glm::uvec4;
using float3x3 = glm::mat3;
using atomic_uint = uint32_t;

enum class mem_flags { mem_none, mem_device, mem_threadgroup };
constexpr int memory_order_relaxed = 0;
inline void threadgroup_barrier(mem_flags) {
    msl::barrier();
}
inline uint atomic_fetch_max_explicit(atomic_uint* a, uint v, int) {
    const uint old = *a;
    *a = std::max(old, v);
    return old;
}
inline uint atomic_fetch_or_explicit(atomic_uint* a, uint v, int) {
    const uint old = *a;
    *a = old | v;
    return old;
}
inline uint atomic_fetch_min_explicit(atomic_uint* a, uint v, int) {
    const uint old = *a;
    *a = std::min(old, v);
    return old;
}
inline uint atomic_fetch_add_explicit(atomic_uint* a, uint v, int) {
    const uint old = *a;
    *a = old + v;
    return old;
}

inline float dot(const float3& a, const float3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline float dot(const float4& a, const float4& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
inline float3 cross(const float3& a, const float3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(const float3& a) {
    return std::sqrt(dot(a, a));
}
inline float3x3 transpose(const float3x3& m) {
    return glm::transpose(m);
}
inline float sqrt(float x) {
    return std::sqrt(x);
}
inline float2 sqrt(const float2& v) {
    return {std::sqrt(v.x), std::sqrt(v.y)};
}
inline float rsqrt(float x) {
    return 1.0f / std::sqrt(x);
}
inline float floor(float x) {
    return std::floor(x);
}
inline float ceil(float x) {
    return std::ceil(x);
}
inline int clamp(int x, int low, int high) {
    return std::min(std::max(x, low), high);
}
struct half2 {
    uint bits;
    half2() = default;
    explicit half2(const float2& v) : bits(glm::packHalf2x16(v)) {}
    operator float2() const { return glm::unpackHalf2x16(bits); }
};
template <class T>
T ctz(T x) {
    return x ? T(std::countr_zero(uint32_t(x))) : T(32);
}
template <class T>
T popcount(T x) {
    return T(std::popcount(uint32_t(x)));
}
inline uint32_t reverse_bits(uint32_t x) {
    uint32_t out = 0;
    for (int bit = 0; bit < 32; ++bit, x >>= 1) out = out << 1 | (x & 1);
    return out;
}
template <class T, class C>
T select(T otherwise, T value, C condition) {
    return condition ? value : otherwise;
}
inline uint pack_float_to_snorm2x16(const float2& v) {
    return glm::packSnorm2x16(v);
}
inline float2 unpack_snorm2x16_to_float(uint bits) {
    return glm::unpackSnorm2x16(bits);
}
inline uint pack_float_to_unorm4x8(const float4& v) {
    return glm::packUnorm4x8(v);
}
inline float log(float x) {
    return std::log(x);
}
inline float exp(float x) {
    return std::exp(x);
}
inline float powr(float x, float y) {
    return std::pow(x, y);
}  // newer SPIRV-Cross emits powr for pow
inline float cos(float x) {
    return std::cos(x);
}
inline float sin(float x) {
    return std::sin(x);
}
inline float abs(float x) {
    return std::fabs(x);
}
inline float2 abs(const float2& v) {
    return {std::fabs(v.x), std::fabs(v.y)};
}
inline uint min(uint a, uint b) {
    return std::min(a, b);
}
inline uint max(uint a, uint b) {
    return std::max(a, b);
}
namespace fast {
inline float clamp(float x, float low, float high) {
    return std::min(std::max(x, low), high);
}
inline float3 clamp(const float3& v, const float3& low, const float3& high) {
    return {clamp(v.x, low.x, high.x), clamp(v.y, low.y, high.y), clamp(v.z, low.z, high.z)};
}
inline float max(float a, float b) {
    return std::max(a, b);
}
inline float2 max(const float2& a, const float2& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y)};
}
inline float min(float a, float b) {
    return std::min(a, b);
}
inline float3 normalize(const float3& v) {
    const float s = 1.0f / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return {v.x * s, v.y * s, v.z * s};
}
}  // namespace fast
template <class To, class From>
inline To as_type(const From& from) {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof(To));
    return to;
}
template <class T, size_t Num>
struct spvUnsafeArray {
    T elements[Num ? Num : 1];
    T& operator[](size_t at) { return elements[at]; }
    constexpr const T& operator[](size_t at) const { return elements[at]; }
};

}  // namespace metal

namespace msl {

struct Thread {
    void* const* buffers;  // in the order of the kernel's parameters
    uint32_t lane = 0;
    glm::uvec3 position{0};  // in the grid or of the threadgroup, as the kernel declares
};

template <class Parameter>
struct Argument;  // builtins are passed by value, buffers by reference
template <class T>
struct Argument<T&> {
    static T& get(Thread& t) { return *static_cast<std::remove_const_t<T>*>(*t.buffers++); }
};
template <>
struct Argument<uint32_t> {
    static uint32_t get(Thread& t) { return t.lane; }
};
template <>
struct Argument<glm::uvec3> {
    static glm::uvec3 get(Thread& t) { return t.position; }
};

/** Runs `groups` threadgroups of `lanes` threads. The kernel's uint3 is thread_position_in_grid if `global`, else
 *  threadgroup_position_in_grid. Returns false as runGroup() does. */
template <class... Parameters>
bool dispatch(void (*kernel)(Parameters...), void* const* buffers, uint32_t groups, uint32_t lanes, bool global, int order) {
    bool fine = true;
    for (uint32_t i = 0; i < groups; ++i) {
        const uint32_t group = order == 1 ? groups - 1 - i : i;
        fine &= runGroup(lanes, order, [&](uint32_t lane) {
            Thread thread{buffers, lane, {global ? group * lanes + lane : group, 0, 0}};
            std::tuple<Parameters...> arguments{Argument<Parameters>::get(thread)...};  // braces guarantee evaluation from left to right
            std::apply(kernel, arguments);
        });
    }
    return fine;
}

}  // namespace msl

#define kernel
#define device
#define thread
#define constant const
#define threadgroup  // to_cpp.cmake has replaced it by `static` where it declares a variable
