// SPDX-License-Identifier: Apache-2.0
// Writes the depth of the picture of a view into an app's depth attachment, where the picture covers enough of a pixel. The depth test of
// the pass keeps what is nearer.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/view.glsl"
#include "shaders/lib/picture.glsl"

layout(binding = 2) uniform texture2DArray sums;  // Σ α T z and Σ α T as quads draw them; tiles keep theirs behind the colours
layout(std430, binding = 3) readonly buffer MeshBlock { float mesh[]; };  // view z, infinite where there is no mesh

/** View z, metres; not above 0 where nothing is drawn. */
float dplSplatZ(uint view, ivec2 at) {
    vec2 sum;
    uint pixel = dplBufferPixel(view, at);
    if (!dplByTiles())
        sum = texelFetch(sums, dplDrawnTexel(view, at), 0).xy;
    else if (push.halfDepth != 0u)
        sum = unpackHalf2x16(tiled[push.firstDepth + pixel]);
    else
        sum = vec2(uintBitsToFloat(tiled[push.firstDepth + 2u * pixel]), uintBitsToFloat(tiled[push.firstDepth + 2u * pixel + 1u]));
    return sum.y > 0.0 ? sum.x / sum.y : 0.0;
}

void main() {
    uint view = dplViewIndex(push.view);
    float z = 0.0;
    if (dplComposes(view)) {  // not a discard: Metal goes on after it, and would read outside the buffers
        ivec2 at = dplPicturePixel();
        if (dplPicture(view, at).a >= kDepthCoverage) z = push.mesh != 0u ? mesh[dplBufferPixel(view, at)] : dplSplatZ(view, at);
    }
    if (!(z > 0.0 && z < 1e30)) discard;
    gl_FragDepth = clamp(push.scale + push.offset / z, 0.0, 1.0);
}
