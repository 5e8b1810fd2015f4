// SPDX-License-Identifier: Apache-2.0
// Packs and unpacks ProjectedSplat.
uint dplPackColour(vec3 rgb) { return uint(rgb.r * 2047.0 + 0.5) | (uint(rgb.g * 2047.0 + 0.5) << 11u) | (uint(rgb.b * 1023.0 + 0.5) << 22u); }
vec3 dplUnpackColour(uint rgb) { return vec3(float(rgb & 2047u) * (1.0 / 2047.0), float((rgb >> 11u) & 2047u) * (1.0 / 2047.0), float(rgb >> 22u) * (1.0 / 1023.0)); }

// Packs opacity and half the width. The width is rounded up: too wide costs time only. The height follows from the conic.
uint dplPackOpacityAndRadius(float opacity, float radiusPx) {
    float wide = radiusPx * 1.0011 + 1e-6;  // large enough for any rounding mode of the conversion to half
    return uint(clamp(opacity, 0.0, 1.0) * 65535.0 + 0.5) | (wide < 65504.0 ? packHalf2x16(vec2(0.0, wide)) : 0x7C000000u);
}
ProjectedSplat dplProjected(uvec4 first, uvec4 second) {  // from the two uvec4s of a record
    ProjectedSplat p;
    p.centrePx = uintBitsToFloat(first.xy);
    p.conicA = uintBitsToFloat(first.z);
    p.conicB = uintBitsToFloat(first.w);
    p.conicC = uintBitsToFloat(second.x);
    p.opacityAndRadius = second.y;
    p.colour = second.z;
    p.depthM = uintBitsToFloat(second.w);
    return p;
}
bool dplShown(uint opacityAndRadius) { return opacityAndRadius >= 0x10000u; }
float dplOpacityOf(uint opacityAndRadius) { return float(opacityAndRadius & 0xFFFFu) * (1.0 / 65535.0); }

// The ellipse outside which α < 1/255. In units of its radii its outline is x = r u ± √((1 - r²)(1 - u²)), with u along y.
struct SplatEllipse {
    float radiusXPx, radiusYPx;  // half its width and height
    float correlation;           // r
};
SplatEllipse dplEllipseOf(ProjectedSplat p) {
    float radius = unpackHalf2x16(p.opacityAndRadius).y, scale = inversesqrt(p.conicA * p.conicC);
    return SplatEllipse(radius, radius * p.conicA * scale, clamp(-p.conicB * scale, -1.0, 1.0));
}
