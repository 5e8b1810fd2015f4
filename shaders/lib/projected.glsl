// SPDX-License-Identifier: Apache-2.0
// Packs and unpacks ProjectedSplat.
uint dplPackColour(vec3 rgb) { return uint(rgb.r * 2047.0 + 0.5) | (uint(rgb.g * 2047.0 + 0.5) << 11u) | (uint(rgb.b * 1023.0 + 0.5) << 22u); }
vec3 dplUnpackColour(uint rgb) { return vec3(float(rgb & 2047u) * (1.0 / 2047.0), float((rgb >> 11u) & 2047u) * (1.0 / 2047.0), float(rgb >> 22u) * (1.0 / 1023.0)); }

// Packs opacity and half the width. The width is rounded up: too wide costs time only. The height follows from the conic.
uint dplPackExtent(float opacity, float radiusPx) {
    float wide = radiusPx * 1.0011 + 1e-6;  // large enough for any rounding mode of the conversion to half
    return uint(clamp(opacity, 0.0, 1.0) * 65535.0 + 0.5) | (wide < 65504.0 ? packHalf2x16(vec2(0.0, wide)) : 0x7C000000u);
}
ProjectedSplat dplProjected(uvec4 place, uvec4 look) {  // from the two uvec4 of a record
    ProjectedSplat p;
    p.place = uintBitsToFloat(place);
    p.look = look;
    return p;
}
bool dplShown(uvec4 look) { return look.y >= 0x10000u; }
float dplOpacityOf(uvec4 look) { return float(look.y & 0xFFFFu) * (1.0 / 65535.0); }
// The ellipse outside which α < 1/255: half its width, half its height, and the correlation r. In units of the half width and height
// its outline is x = r u ± √((1 - r²)(1 - u²)), with u along y.
vec3 dplEllipseOf(ProjectedSplat p) {
    float radius = unpackHalf2x16(p.look.y).y, scale = inversesqrt(p.place.z * uintBitsToFloat(p.look.x));
    return vec3(radius, radius * p.place.z * scale, clamp(-p.place.w * scale, -1.0, 1.0));
}
