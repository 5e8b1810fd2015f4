// SPDX-License-Identifier: Apache-2.0
// The same for general splats: three axes, no gate.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/frame.h"
#include "tools/bench/baseline/shaders/lib/footprint_general.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer SplatBlock { GeneralSplatRecord splats[]; };
layout(std430, binding = 2) writeonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer DepthBlock { uint sortDepth[]; };  // float bits, kInvisibleKey = in no view
layout(push_constant) uniform PushBlock { SplatPush push; };

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < push.splatCount) {
        GeneralSplatRecord s = splats[index];
        bool seen = false;
        for (uint v = 0u; v < push.viewCount; ++v) {
            ViewData view = frame.views[v];
            ProjectedSplat p = dplHiddenSplat();
            Footprint f = dplProjectGeneral(view, dplToView(view, s.centre.xyz), dplRotateToView(view, s.axis1.xyz), dplRotateToView(view, s.axis2.xyz),
                                            dplRotateToView(view, s.axis3.xyz), frame.target.z);
            if (f.visible) {
                float opacity = s.centre.w * dplNearFade(f.depthM);
                if (frame.counts.w != 0u) opacity *= f.compensation;
                p = dplShow(f, opacity, frame.target.xy);
                seen = seen || p.opacity > 0.0;
            }
            projected[index * push.viewCount + v] = p;
        }
        sortDepth[index] = seen ? floatBitsToUint(dot(frame.sortAxis.xyz, s.centre.xyz)) : kInvisibleKey;
    }
}
