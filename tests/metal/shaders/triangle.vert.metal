// SPDX-License-Identifier: Apache-2.0
// For tests of the software device: a vertex is a place in clip space and a value; each instance draws into its own layer.
#include <metal_stdlib>
#include <simd/simd.h>

using namespace metal;

struct VertexBlock
{
    float4 fours[1];
};

struct main0_out
{
    float4 value [[user(locn0)]];
    float4 kept [[user(locn1)]];
    float4 gl_Position [[position]];
    uint gl_Layer [[render_target_array_index]];
};

vertex main0_out main0(const device VertexBlock& vertices [[buffer(0)]], uint gl_VertexIndex [[vertex_id]], uint gl_InstanceIndex [[instance_id]])
{
    main0_out out = {};
    out.gl_Position = vertices.fours[2u * gl_VertexIndex];
    out.value = vertices.fours[(2u * gl_VertexIndex) + 1u];
    out.kept = out.value;
    out.gl_Layer = gl_InstanceIndex;
    return out;
}
