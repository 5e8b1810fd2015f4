// SPDX-License-Identifier: Apache-2.0
// View z of an app's scene, from its depth image; infinite where nothing is there (sdk/math/scene_depth.h).
// DPL_FOUR: the image has four samples a pixel. All splats of a pixel are compared with its farthest sample, so that an edge of the scene
// hides no splat that shows beside it.
// DPL_FLAT: the image has no layers. For Metal, where that is another type.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "shaders/shared/frame.h"
layout(local_size_x = 64) in;  // kSceneGroup

#if defined(DPL_FLAT) && defined(DPL_FOUR)
layout(binding = 0) uniform texture2DMS stored;
#elif defined(DPL_FLAT)
layout(binding = 0) uniform texture2D stored;
#elif defined(DPL_FOUR)
layout(binding = 0) uniform texture2DMSArray stored;
#else
layout(binding = 0) uniform texture2DArray stored;
#endif
layout(std430, binding = 1) writeonly buffer SceneBlock { float scene[]; };
layout(push_constant) uniform PushBlock { ScenePush push; };

#ifdef DPL_FLAT
ivec2 dplTexel(ivec2 at) { return at; }
#else
ivec3 dplTexel(ivec2 at) { return ivec3(at, push.layer); }
#endif

float dplViewZ(float stored) {
    float z = push.offset / (stored - push.scale);
    return z > 0.0 ? z : uintBitsToFloat(0x7F800000u);  // behind the camera, and infinity over zero: nothing is there
}

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (pixel.x >= push.widthPx) return;
    ivec2 at = ivec2(pixel) + ivec2(push.placeX, push.placeY);
#ifdef DPL_FOUR
    ivec2 size = textureSize(stored).xy;
#else
    ivec2 size = textureSize(stored, 0).xy;
#endif
    float z = uintBitsToFloat(0x7F800000u);
    if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size))) {
#ifdef DPL_FOUR
        z = 0.0;
        for (int s = 0; s < 4; ++s) {
            float sampleZ = dplViewZ(texelFetch(stored, dplTexel(at), s).r);
            z = sampleZ > z ? sampleZ : z;  // not max(): on Metal that is fast::max, which need not know infinity
        }
#else
        z = dplViewZ(texelFetch(stored, dplTexel(at), 0).r);
#endif
    }
    scene[push.firstPixel + pixel.y * push.widthPx + pixel.x] = z;
}
