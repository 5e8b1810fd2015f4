// SPDX-License-Identifier: Apache-2.0
// Screen footprint of a flat splat: sdk/math/projection.h line by line.
float dplSmoothstep01(float x) {
    x = clamp(x, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

bool dplIsFinite(float x) { return abs(x) < 3.0e38; }  // false for NaN too

float dplSingleFaceGate(vec3 normal, vec3 centre, vec3 eye) {
    vec3 toEye = eye - centre;
    return dplSmoothstep01(dot(normal, toEye) / (length(toEye) * kGpuGateEnd));
}

float dplNearFade(float depthM) { return dplSmoothstep01((depthM - kGpuNearM) / (kGpuNearFadeEndM - kGpuNearM)); }

vec3 dplRotateToView(ViewData view, vec3 world) {
    return vec3(dot(view.viewFromWorldRow0.xyz, world), dot(view.viewFromWorldRow1.xyz, world), dot(view.viewFromWorldRow2.xyz, world));
}

vec3 dplToView(ViewData view, vec3 world) {
    return dplRotateToView(view, world) + vec3(view.viewFromWorldRow0.w, view.viewFromWorldRow1.w, view.viewFromWorldRow2.w);
}

struct Footprint {
    vec2 centrePx;
    vec3 conic;
    vec2 variance;
    float compensation;
    float depthM;
    bool visible;
};

Footprint dplProject(ViewData view, vec3 centre, vec3 axis1, vec3 axis2, float kappa) {
    Footprint f;
    f.centrePx = vec2(0.0);
    f.conic = vec3(0.0);
    f.variance = vec2(0.0);
    f.compensation = 0.0;
    f.depthM = centre.z;
    f.visible = false;
    if (!(centre.z > kGpuNearM)) return f;
    float invZ = 1.0 / centre.z;
    vec2 slope = centre.xy * invZ;
    f.centrePx = view.focalCentrePx.xy * slope + view.focalCentrePx.zw;
    float jx = view.focalCentrePx.x * invZ, jy = view.focalCentrePx.y * invZ;
    float sx = clamp(slope.x, view.slopeLimits.x, view.slopeLimits.y), sy = clamp(slope.y, view.slopeLimits.z, view.slopeLimits.w);
    float b00 = jx * (axis1.x - sx * axis1.z), b01 = jx * (axis2.x - sx * axis2.z);
    float b10 = jy * (axis1.y - sy * axis1.z), b11 = jy * (axis2.y - sy * axis2.z);
    f.variance = vec2(b00 * b00 + b01 * b01, b10 * b10 + b11 * b11) + kappa;
    float covariance = b00 * b10 + b01 * b11;
    float detB = b00 * b11 - b01 * b10;
    float normB2 = b00 * b00 + b01 * b01 + b10 * b10 + b11 * b11;
    float det = detB * detB + kappa * normB2 + kappa * kappa;  // sum form: a·c − b² loses needles in float
    if (!(det > 0.0) || !dplIsFinite(det)) return f;
    float invDet = 1.0 / det;
    f.conic = vec3(f.variance.y, -covariance, f.variance.x) * invDet;
    f.compensation = max(kGpuMinCompensation, sqrt(detB * detB * invDet));
    f.visible = dplIsFinite(f.centrePx.x) && dplIsFinite(f.centrePx.y);
    return f;
}
