// SPDX-License-Identifier: Apache-2.0
// The part of the Metal standard library, built on GLM, that is needed to compile the shaders emitted by SPIRV-Cross as C++ and to run them
// on the CPU (msl_entry.h). This tests what shaders compute, not whether Apple's compiler accepts them.
#pragma once

#define GLM_FORCE_SWIZZLE
#define GLM_FORCE_SILENT_WARNINGS
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/packing.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "tests/metal/cpu/msl_entry.h"

namespace metal {

using uint = uint32_t;
using float2 = glm::vec2;
using float3 = glm::vec3;
using packed_float3 = glm::vec3;
using float4 = glm::vec4;
using int2 = glm::ivec2;
using int3 = glm::ivec3;
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
inline uint atomic_fetch_and_explicit(atomic_uint* a, uint v, int) {
    const uint old = *a;
    *a = old & v;
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

using bool2 = glm::bvec2;
inline bool2 operator>=(const int2& a, const int2& b) {
    return {a.x >= b.x, a.y >= b.y};
}
inline bool2 operator<(const int2& a, const int2& b) {
    return {a.x < b.x, a.y < b.y};
}
inline bool all(const bool2& v) {
    return v.x && v.y;
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
inline float4 floor(const float4& v) {
    return {std::floor(v.x), std::floor(v.y), std::floor(v.z), std::floor(v.w)};
}
inline float3 pow(const float3& a, const float3& b) {
    return {std::pow(a.x, b.x), std::pow(a.y, b.y), std::pow(a.z, b.z)};
}
inline float3 step(const float3& edge, const float3& v) {
    return {v.x < edge.x ? 0.0f : 1.0f, v.y < edge.y ? 0.0f : 1.0f, v.z < edge.z ? 0.0f : 1.0f};
}
inline float3 mix(const float3& a, const float3& b, const float3& t) {
    return a + (b - a) * t;
}
inline float exp2(float x) {
    return std::exp2(x);
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
inline float4 unpack_unorm4x8_to_float(uint bits) {
    return glm::unpackUnorm4x8(bits);
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
inline float sign(float x) {
    return x > 0 ? 1.0f : x < 0 ? -1.0f : 0.0f;
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
inline float2 clamp(const float2& v, const float2& low, const float2& high) {
    return {clamp(v.x, low.x, high.x), clamp(v.y, low.y, high.y)};
}
inline float4 clamp(const float4& v, const float4& low, const float4& high) {
    return {clamp(v.x, low.x, high.x), clamp(v.y, low.y, high.y), clamp(v.z, low.z, high.z), clamp(v.w, low.w, high.w)};
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
inline float2 min(const float2& a, const float2& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y)};
}
inline float3 min(const float3& a, const float3& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline float3 normalize(const float3& v) {
    const float s = 1.0f / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return {v.x * s, v.y * s, v.z * s};
}
}  // namespace fast
namespace precise {
inline float atan2(float y, float x) {
    return std::atan2(y, x);
}
}  // namespace precise
template <class To, class From>
inline To as_type(const From& from) {
    static_assert(sizeof(To) == sizeof(From));
    To to;
    std::memcpy(&to, &from, sizeof(To));
    return to;
}

/** The texture types of MSL. TextureShape and the arguments of read() differ. */
template <class T>
struct texture2d : msl::TextureArgument<msl::TextureShape::Flat> {
    float4 read(uint2 at, uint lod = 0) const { return texel(at, 0, 0); }
};
template <class T>
struct texture2d_array : msl::TextureArgument<msl::TextureShape::Array> {
    float4 read(uint2 at, uint layer, uint lod = 0) const { return texel(at, layer, 0); }
};
template <class T>
struct texture2d_ms : msl::TextureArgument<msl::TextureShape::FlatSamples> {
    float4 read(uint2 at, uint number) const { return texel(at, 0, number); }
};
template <class T>
struct texture2d_ms_array : msl::TextureArgument<msl::TextureShape::ArraySamples> {
    float4 read(uint2 at, uint layer, uint number) const { return texel(at, layer, number); }
};

/** The fragment goes on, as in Metal, but changes no attachment. What it reads from then on is checked too. */
inline void discard_fragment() {
    msl::running.discarded = true;
}
inline float2 get_sample_position(uint number) {
    return msl::kSamplePlaces[number & 3];
}

template <class T, size_t Num>
struct spvUnsafeArray {
    T elements[Num ? Num : 1];
    T& operator[](size_t at) { return elements[at]; }
    constexpr const T& operator[](size_t at) const { return elements[at]; }
};

}  // namespace metal

#define kernel
#define vertex
#define fragment
#define device
#define thread
#define constant const
#define threadgroup  // to_cpp.cmake has replaced it by `static` where it declares a variable
