// SPDX-License-Identifier: Apache-2.0
// Names what the uvec4s of a TriangleFrame hold.
uint dplShows(uvec4 corner0) { return corner0.w; }  // TriangleFrame.shows

TriangleFrame dplTriangleFrame(uvec4 corner0, uvec4 corner1, uvec4 corner2, uvec4 column0, uvec4 column1) {
    vec3 v0 = uintBitsToFloat(corner0.xyz), v1 = uintBitsToFloat(corner1.xyz), v2 = uintBitsToFloat(corner2.xyz);
    vec3 f0 = uintBitsToFloat(column0.xyz), f1 = uintBitsToFloat(column1.xyz);
    return TriangleFrame(v0.x, v0.y, v0.z, dplShows(corner0), v1.x, v1.y, v1.z, corner1.w, v2.x, v2.y, v2.z, corner2.w,
                         f0.x, f0.y, f0.z, column0.w, f1.x, f1.y, f1.z, column1.w);
}
