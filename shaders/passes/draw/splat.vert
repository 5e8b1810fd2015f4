// SPDX-License-Identifier: Apache-2.0
// Draws one triangle for each survivor and view, farthest first, around the ellipse outside which the splat's α is below 1/255. A quad
// of two triangles would shade the pixels along its diagonal twice; on lavapipe that takes a third of the time of the draw.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/projected.glsl"
#include "shaders/lib/view.glsl"

layout(std430, binding = 0) readonly buffer CountsBlock { FrameCounts counts; };
DPL_WORDS(1, OrderBlock, order);
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat
layout(push_constant) uniform PushBlock { DrawPush push; };

layout(location = 0) flat out vec4 centreConic;   // centre px; -log₂e ½ A and -log₂e B of the conic
layout(location = 1) flat out vec4 conicOpacity;  // -log₂e ½ C, opacity, view, 0
layout(location = 2) flat out vec4 colourDepth;   // rgb, view z

// All splats are one instance: an instance with only three vertices would leave lanes of the vertex shader idle, and on lavapipe each
// instance costs as much as a draw.
uint dplSplat() { return uint(gl_VertexIndex) / 3u; }
uint dplCorner() { return uint(gl_VertexIndex) % 3u; }

void main() {
    uint view = dplViewIndex(push.view);
    // The list is sorted nearest first, with ties in splat order. Drawing it backwards gives the exact mirror of front-to-back
    // blending.
    uint splat = DPL_WORD(order, counts.visible - 1u - dplSplat()), record = kProjectedFours * (view * push.splatCount + splat);
    ProjectedSplat p = dplProjected(DPL_FOUR(projected, record), DPL_FOUR(projected, record + 1u));
    const float log2e = 1.4426950408889634;  // exp(-σ) becomes a power of two: one scaling for each splat instead of one for each pixel
    centreConic = vec4(p.centrePx, -0.5 * log2e * p.conicA, -log2e * p.conicB);
    conicOpacity = vec4(-0.5 * log2e * p.conicC, dplOpacityOf(p.opacityAndRadius), float(view), 0.0);
    colourDepth = vec4(dplUnpackColour(p.colour), p.depthM);
    vec2 size = vec2(push.targetWidthPx, push.targetHeightPx);
    SplatEllipse ellipse = dplEllipseOf(p);
    vec2 radius = vec2(ellipse.radiusXPx, ellipse.radiusYPx);
    vec2 px;
    uint corner = dplCorner();
    if (radius.x < size.x && radius.y < size.y) {
        // The smallest triangle around the unit circle, mapped to the ellipse by its radii and its correlation r. The constant under
        // the root absorbs float rounding of r.
        vec2 around = corner == 0u ? vec2(0.0, 2.0) : vec2(corner == 1u ? 1.7320509 : -1.7320509, -1.0);
        radius += 0.02;
        float r = ellipse.correlation;
        px = p.centrePx + vec2(radius.x * around.x, radius.y * (r * around.x + sqrt(1.0 - r * r + 1e-6) * around.y));
    } else {  // around the bounding box, clipped to the view
        vec2 low = clamp(p.centrePx - radius, vec2(0.0), size), high = clamp(p.centrePx + radius, vec2(0.0), size);
        px = low + 2.0 * (high - low) * vec2(corner == 1u ? 1.0 : 0.0, corner == 2u ? 1.0 : 0.0);
    }
    vec2 ndc = 2.0 * px / size - 1.0;
    gl_Position = dplShown(p.opacityAndRadius) ? vec4(ndc, 0.0, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}
