// SPDX-License-Identifier: Apache-2.0
// Screen footprint of a splat with three axes: sdk/math/projection.h line by line.
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

// The 2×3 Jacobian at a centre: focal lengths over depth, clamped slopes.
vec4 dplJacobian(ViewData view, vec3 centre) {
    float invZ = 1.0 / centre.z;
    vec2 slope = centre.xy * invZ;
    return vec4(view.focalCentrePx.xy * invZ, clamp(slope, view.slopeLimits.xz, view.slopeLimits.yw));
}
vec2 dplOnScreen(vec4 jacobian, vec3 axis) { return jacobian.xy * (axis.xy - jacobian.zw * axis.z); }

Footprint dplHiddenFootprint(float depthM) {
    Footprint f;
    f.centrePx = vec2(0.0);
    f.conic = vec3(0.0);
    f.variance = vec2(0.0);
    f.compensation = 0.0;
    f.depthM = depthM;
    f.visible = false;
    return f;
}

// variance, covariance and det(B)² without κ; the sum form of the determinant: a·c − b² loses needles in float.
Footprint dplFootprint(ViewData view, vec3 centre, vec2 variance, float covariance, float detB2, float kappa) {
    Footprint f = dplHiddenFootprint(centre.z);
    float det = detB2 + kappa * (variance.x + variance.y) + kappa * kappa;
    if (!(det > 0.0) || !dplIsFinite(det)) return f;
    float invDet = 1.0 / det;
    f.centrePx = view.focalCentrePx.xy * (centre.xy * (1.0 / centre.z)) + view.focalCentrePx.zw;
    f.variance = variance + kappa;
    f.conic = vec3(f.variance.y, -covariance, f.variance.x) * invDet;
    f.compensation = max(kGpuMinCompensation, sqrt(detB2 * invDet));
    f.visible = dplIsFinite(f.centrePx.x) && dplIsFinite(f.centrePx.y);
    return f;
}

Footprint dplProject(ViewData view, vec3 centre, vec3 axis1, vec3 axis2, float kappa) {
    if (!(centre.z > kGpuNearM)) return dplHiddenFootprint(centre.z);
    vec4 jacobian = dplJacobian(view, centre);
    vec2 b1 = dplOnScreen(jacobian, axis1), b2 = dplOnScreen(jacobian, axis2);
    float detB = b1.x * b2.y - b2.x * b1.y;
    return dplFootprint(view, centre, b1 * b1 + b2 * b2, b1.x * b1.y + b2.x * b2.y, detB * detB, kappa);
}

// Three axes: det(BBᵀ) is the sum of the squared minors (Cauchy-Binet).
Footprint dplProjectGeneral(ViewData view, vec3 centre, vec3 axis1, vec3 axis2, vec3 axis3, float kappa) {
    if (!(centre.z > kGpuNearM)) return dplHiddenFootprint(centre.z);
    vec4 jacobian = dplJacobian(view, centre);
    vec2 b1 = dplOnScreen(jacobian, axis1), b2 = dplOnScreen(jacobian, axis2), b3 = dplOnScreen(jacobian, axis3);
    vec3 minors = vec3(b2.x * b3.y - b3.x * b2.y, b3.x * b1.y - b1.x * b3.y, b1.x * b2.y - b2.x * b1.y);
    return dplFootprint(view, centre, b1 * b1 + b2 * b2 + b3 * b3, b1.x * b1.y + b2.x * b2.y + b3.x * b3.y, dot(minors, minors), kappa);
}

ProjectedSplat dplHiddenSplat() {
    ProjectedSplat p;
    p.opacity = 0.0;
    p.centrePx = p.radiusPx = vec2(0.0);
    p.conicA = p.conicB = p.conicC = 0.0;
    p.colour = vec4(0.0);
    return p;
}

// A footprint of this opacity as the draw reads it, colour aside; hidden when no pixel of the target sees 1/255 of it.
ProjectedSplat dplShow(Footprint f, float opacity, vec2 targetPx) {
    ProjectedSplat p = dplHiddenSplat();
    if (opacity >= kGpuMinAlpha) {
        float level = 2.0 * log(opacity / kGpuMinAlpha);
        vec2 radius = sqrt(level * f.variance);
        vec2 low = f.centrePx - radius, high = f.centrePx + radius;
        if (high.x > 0.0 && high.y > 0.0 && low.x < targetPx.x && low.y < targetPx.y) {
            p.centrePx = f.centrePx;
            p.radiusPx = radius;
            p.conicA = f.conic.x;
            p.conicB = f.conic.y;
            p.conicC = f.conic.z;
            p.opacity = opacity;
            p.colour.w = f.depthM;
        }
    }
    return p;
}
