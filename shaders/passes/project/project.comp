// Footprint, opacity and visibility of every splat in every view; of those that some view shows the sort depth, and what the colour pass asks for: the
// direction to the splat in the rest frame of its triangle, as long as the brightness that the pose gives it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/footprint.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer CodeBlock { uint codes[]; };
layout(std430, binding = 2) readonly buffer TriangleBlock { TriangleFrame triangles[]; };
layout(std430, binding = 3) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 4) buffer VisibilityBlock { uint visibility[]; };  // sort depths: float bits, kInvisibleKey = in no view
layout(push_constant) uniform PushBlock { CodesPush push; };
#include "shaders/lib/codes.glsl"

void main() {
    SplatPlace p0 = dplPlaceOf(visibility[push.groupCount + gl_WorkGroupID.x], gl_LocalInvocationIndex);
    if (!p0.exists) return;
    uint index = p0.splat, depthSlot = 2u * push.groupCount + index, size = dplSize(p0);
    uint parent = dplParent(p0);
    bool gated = dplGated(size);
    vec4 v0 = triangles[parent].v0;
    uint shown = uint(v0.w) & (gated ? 3u * kShowsGated : 3u * kShowsFree);
    if (shown == 0u) {  // its triangle is in no view, or turned away: nothing else of it is read
        for (uint v = 0u; v < push.viewCount; ++v) projected[index * push.viewCount + v].opacity = 0.0;
        visibility[depthSlot] = kInvisibleKey;
        return;
    }
    uint place = codes[push.firstPlace + index];
    vec2 uv = dplUv(place), scale = dplScale(p0, size);
    float phi = float(place >> 22u) * kPhiCodeStep, cosine = cos(phi), sine = sin(phi);
    vec4 v1 = triangles[parent].v1, v2 = triangles[parent].v2;
    vec4 f0 = triangles[parent].f0, f1 = triangles[parent].f1;
    vec3 normal = vec3(v1.w, v2.w, f0.w);
    vec3 centre = (1.0 - uv.x - uv.y) * v0.xyz + uv.x * v1.xyz + uv.y * v2.xyz;
    vec3 axis1 = scale.x * (cosine * f0.xyz + sine * f1.xyz), axis2 = scale.y * (cosine * f1.xyz - sine * f0.xyz);
    bool seen = false;
    for (uint v = 0u; v < push.viewCount; ++v) {
        ViewData view = frame.views[v];
        ProjectedSplat p = dplHiddenSplat();
        if ((shown & ((kShowsFree | kShowsGated) << v)) != 0u) {
            Footprint f = dplProject(view, dplToView(view, centre), dplRotateToView(view, axis1), dplRotateToView(view, axis2), frame.target.z);
            if (f.visible) {
                float opacity = dplOpacity(size) * dplNearFade(f.depthM);
                if (frame.counts.w != 0u) opacity *= f.compensation;
                if (gated) opacity *= dplSingleFaceGate(normal, centre, view.eyeWorld.xyz);
                p = dplShow(f, opacity, frame.target.xy);
                if (p.opacity > 0.0) {
                    vec4 r0 = triangles[parent].worldFromRest0, r1 = triangles[parent].worldFromRest1, r2 = triangles[parent].worldFromRest2;
                    float light = r0.w + uv.x * (r1.w - r0.w) + uv.y * (r2.w - r0.w);
                    vec3 world = light * normalize(centre - view.eyeWorld.xyz);
                    p.colour.rgb = vec3(dot(r0.xyz, world), dot(r1.xyz, world), dot(r2.xyz, world));
                    seen = true;
                }
            }
        }
        projected[index * push.viewCount + v] = p;
    }
    visibility[depthSlot] = seen ? floatBitsToUint(dot(frame.sortAxis.xyz, centre)) : kInvisibleKey;
}
