// SPDX-License-Identifier: Apache-2.0
// α of a splat at a distance from its centre in pixels, conic (A, B, C); 0 outside its 1/255 ellipse. Both fill paths ask here.
float dplSplatAlpha(vec2 d, vec3 conic, float opacity) {
    float sigma = 0.5 * (conic.x * d.x * d.x + conic.z * d.y * d.y) + conic.y * d.x * d.y;
    float alpha = min(kGpuMaxAlpha, opacity * exp(-sigma));
    return sigma >= 0.0 && alpha >= kGpuMinAlpha ? alpha : 0.0;
}
