// One posed frame a triangle: corners, the columns of F, the unit normal and the polar rotation (sdk/math/binding.h); and which views may show
// its splats: those whose frustum it touches (lib/cull.glsl), for single-face splats only those on its front side, where their gate is above 0.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/cull.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer TriangleBlock { TriangleRecord triangles[]; };
layout(std430, binding = 2) readonly buffer PosedBlock { vec4 posed[]; };
layout(std430, binding = 3) writeonly buffer TriangleFrameBlock { TriangleFrame frames[]; };
layout(std430, binding = 4) buffer CountsBlock { FrameCounts counts; };
layout(push_constant) uniform PushBlock { TrianglePush push; };

shared uint groupTriangles[2];  // in view, facing
shared uint groupSplats[2];

/** The bits of TriangleFrame.v0.w. */
uint shownBy(TriangleRecord rest, TriangleFrame f, vec3 normal) {
    float reach = rest.reach * dplLargestStretch(f.f0.xyz, f.f1.xyz) * 1.0001;  // the factor: float rounding
    uint shown = 0u;
    for (uint v = 0u; v < push.viewCount; ++v) {
        if (push.cull != 0u && !dplTriangleInView(frame.views[v], f.v0.xyz, f.v1.xyz, f.v2.xyz, reach, rest.rootLevel, frame.target.xy, frame.target.z)) continue;
        shown |= kShowsFree << v;
        if (push.cull == 0u || dot(normal, frame.views[v].eyeWorld.xyz - f.v0.xyz) > 0.0) shown |= kShowsGated << v;
    }
    return shown;
}

void main() {
    uint lane = gl_LocalInvocationIndex, index = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane < 2u) groupTriangles[lane] = groupSplats[lane] = 0u;
    barrier();
    if (index < push.triangleCount) {
        TriangleRecord rest = triangles[index];
        vec4 corner0 = posed[rest.corners.x], corner1 = posed[rest.corners.y], corner2 = posed[rest.corners.z];  // w: brightness
        vec3 v0 = corner0.xyz, v1 = corner1.xyz, v2 = corner2.xyz;
        TriangleFrame f;
        f.v0 = vec4(v0, 0.0);
        f.v1 = vec4(v1, 0.0);
        f.v2 = vec4(v2, 0.0);
        f.f0 = f.f1 = f.worldFromRest0 = f.worldFromRest1 = f.worldFromRest2 = vec4(0.0);
        vec3 d1 = v1 - v0, d2 = v2 - v0, d3 = v2 - v1;
        vec3 normal = cross(d1, d2);
        float doubleArea = length(normal);
        float longest2 = max(dot(d1, d1), max(dot(d2, d2), dot(d3, d3)));
        if (rest.corners.w != 0u && doubleArea > 2.0 * kGpuMinTriangleAreaM2 && longest2 < kGpuMaxTriangleAspect * doubleArea) {
            vec3 f0 = d1 * rest.restT1.w;
            vec3 f1 = d1 * rest.restT2.w + d2 * rest.restNormal.w;
            normal /= doubleArea;
            // Polar rotation of the 2×2 map between the frames. t1 runs along d1, so m10 = t2·F0 = 0.
            vec3 t1 = normalize(d1), t2 = cross(normal, t1);
            float sine = -dot(t1, f1), cosine = dot(t1, f0) + dot(t2, f1);
            float radius = sqrt(sine * sine + cosine * cosine);
            float c = radius > 1e-12 ? cosine / radius : 1.0, s = radius > 1e-12 ? sine / radius : 0.0;
            mat3 turned = mat3(c * t1 + s * t2, c * t2 - s * t1, normal);
            mat3 worldFromRest = turned * transpose(mat3(rest.restT1.xyz, rest.restT2.xyz, rest.restNormal.xyz));
            f.v1.w = normal.x;
            f.v2.w = normal.y;
            f.f0 = vec4(f0, normal.z);
            f.f1 = vec4(f1, 0.0);
            f.worldFromRest0 = vec4(worldFromRest[0], corner0.w);
            f.worldFromRest1 = vec4(worldFromRest[1], corner1.w);
            f.worldFromRest2 = vec4(worldFromRest[2], corner2.w);
            uint shown = shownBy(rest, f, normal);
            f.v0.w = float(shown);
            uint facing = (shown != 0u ? rest.freeSplats : 0u) + (shown >= kShowsGated ? rest.gatedSplats : 0u);
            if (shown != 0u && rest.freeSplats + rest.gatedSplats != 0u) {
                atomicAdd(groupTriangles[0], 1u);
                atomicAdd(groupSplats[0], rest.freeSplats + rest.gatedSplats);
            }
            if (facing != 0u) {
                atomicAdd(groupTriangles[1], 1u);
                atomicAdd(groupSplats[1], facing);
            }
        }
        frames[index] = f;
    }
    barrier();
    if (lane == 0u && groupTriangles[0] != 0u) {
        atomicAdd(counts.trianglesInView, groupTriangles[0]);
        atomicAdd(counts.trianglesFacing, groupTriangles[1]);
        atomicAdd(counts.splatsInView, groupSplats[0]);
        atomicAdd(counts.splatsFacing, groupSplats[1]);
    }
}
