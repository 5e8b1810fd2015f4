// SPDX-License-Identifier: Apache-2.0
// The picture of an avatar that a draw in an app's pass composes, as prepare left it: an image that quads filled, or a buffer that tiles
// filled. The views of a canted pair are two frames, each with an image and a buffer of its own. In a pass with multiview they are two
// draws, and each leaves the other view alone.
#extension GL_EXT_samplerless_texture_functions : require
layout(binding = 0) uniform texture2DArray drawn;
layout(std430, binding = 1) readonly buffer TiledBlock { uint tiled[]; };
layout(push_constant) uniform PushBlock { ComposePush push; };

bool dplComposes(uint view) { return (push.views >> view & 1u) != 0u; }
bool dplByTiles() { return push.tiled != 0u; }
/** Pixel of the picture. */
ivec2 dplPicturePixel() { return ivec2(gl_FragCoord.xy - vec2(push.placeX, push.placeY)); }
ivec3 dplDrawnTexel(uint view, ivec2 at) { return ivec3(at, int(view - push.drawnFrom)); }
uint dplBufferPixel(uint view, ivec2 at) {
    return ((view - push.bufferFrom) * push.heightPx + uint(at.y)) * push.widthPx + uint(at.x);
}

/** Premultiplied, display-referred, rounded to 8 bits as the picture that is read back. */
vec4 dplPicture(uint view, ivec2 at) {
    if (dplByTiles()) return unpackUnorm4x8(tiled[dplBufferPixel(view, at)]);
    vec4 codes = floor(clamp(texelFetch(drawn, dplDrawnTexel(view, at), 0), 0.0, 1.0) * 255.0 + 0.5);
    return vec4(codes.rgb, 255.0 - codes.a) / 255.0;  // alpha holds the transmittance
}
