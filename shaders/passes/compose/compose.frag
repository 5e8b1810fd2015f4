// SPDX-License-Identifier: Apache-2.0
// Composes the picture of a view over an app's target, by the formulas of sdk/api/compose.h. The fixed blending of the pass does "over";
// for a target that encodes sRGB it decodes and encodes too. Where the picture is empty, the target keeps its bits.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/view.glsl"
#include "shaders/lib/srgb.glsl"
#include "shaders/lib/picture.glsl"
layout(location = 0) out vec4 colour;

void main() {
    uint view = dplViewIndex(push.view);
    // Metal goes on after a discard: what must not be read is not read before it.
    vec4 picture = dplComposes(view) ? dplPicture(view, dplPicturePixel()) : vec4(0.0);
    if (picture.a == 0.0) discard;
    if (push.linear != 0u) picture.rgb = dplLinearFromSrgb(min(picture.rgb / picture.a, vec3(1.0))) * picture.a;
    colour = picture;
}
