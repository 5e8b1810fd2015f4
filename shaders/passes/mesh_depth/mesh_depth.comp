// SPDX-License-Identifier: Apache-2.0
// Depth of the posed mesh at pixel centres (formulas: sdk/splat/mesh_depth.h). The caller reads it as a depth buffer of everything that
// can hide a splat. An atomic minimum of the float bits keeps the nearest z, so the result does not depend on the order of lanes. One
// lane draws a small triangle by itself; all lanes of the workgroup share the pixels of a large one.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/footprint.glsl"
layout(local_size_x = 128) in;  // kVertexGroup

layout(std140, binding = 0) uniform FrameBlock { FrameData frame; };
layout(std430, binding = 1) readonly buffer TriangleBlock { TriangleRecord triangles[]; };
layout(std430, binding = 2) readonly buffer PosedBlock { PosedVertex posed[]; };
// float bits of z, set to infinity before this pass; by view, row, column
layout(std430, binding = 3) buffer DepthBlock { uint depths[]; };
layout(push_constant) uniform PushBlock { MeshDepthPush push; };

shared uint largeCount;
shared uint large[256];  // kVertexGroup × kMaxViews: triangle × views + view

struct Corners {  // sorted by vertex index: two triangles compute their common edge from the same numbers, so no gap opens
    vec3 a, b, c;     // (u, v, z)
};

vec3 corner(ViewData view, uint vertex) {
    vec3 p = dplToView(view, vec3(posed[vertex].x, posed[vertex].y, posed[vertex].z));
    return vec3(view.focalPx.x * p.x + view.centrePx.x * p.z, view.focalPx.y * p.y + view.centrePx.y * p.z, p.z);
}

/** Triangles of hidden layers are not posed. Other components always are where this pass runs. */
bool isHidden(uint triangle) {
    uint component = triangles[triangle].component;
    return component != 0u && (frame.unseenComponents >> (component - 1u) & 1u) != 0u;
}

Corners cornersOf(uint triangle, uint view) {
    uvec3 index = uvec3(triangles[triangle].corner0, triangles[triangle].corner1, triangles[triangle].corner2);
    uint low = min(index.x, min(index.y, index.z)), high = max(index.x, max(index.y, index.z));
    ViewData v = frame.views[view];
    Corners t;
    t.a = corner(v, low);
    t.b = corner(v, index.x ^ index.y ^ index.z ^ low ^ high);
    t.c = corner(v, high);
    return t;
}

struct Reach {  // bounds of the visible part of a triangle
    float lowX, lowY, highX, highY;
    float margin;
};

void take(inout Reach r, float x, float y) {
    r.lowX = min(r.lowX, x);
    r.lowY = min(r.lowY, y);
    r.highX = max(r.highX, x);
    r.highY = max(r.highY, y);
}

/** Adds the corner `a` if it is in front of the near plane, and the point where the edge to `b` crosses that plane. */
void takeEdge(inout Reach r, vec3 a, vec3 b) {
    if (a.z > kNearM) take(r, a.x / a.z, a.y / a.z);
    if ((a.z > kNearM) == (b.z > kNearM)) return;
    float t = (kNearM - a.z) / (b.z - a.z);
    take(r, (a.x + t * (b.x - a.x)) / kNearM, (a.y + t * (b.y - a.y)) / kNearM);
    r.margin = 1.0;
}

bool finiteCorner(vec3 p) { return isFinite(p.x) && isFinite(p.y) && isFinite(p.z); }

/** First pixel whose centre lies in [low, high], and one past the last, clamped to 0 .. size. The clamp is repeated after the
 *  conversion to int, so that a NaN cannot leave the target. */
ivec2 pixelsIn(float low, float high, uint size) {
    int first = clamp(int(clamp(ceil(low - 0.5), 0.0, float(size))), 0, int(size)), end = clamp(int(clamp(floor(high - 0.5) + 1.0, 0.0, float(size))), 0, int(size));
    return ivec2(first, max(first, end));
}

/** First column, one past the last column, first row, one past the last row. */
ivec4 boxOf(Corners t) {
    Reach r;
    r.lowX = r.lowY = 1e30;
    r.highX = r.highY = -1e30;
    r.margin = 0.01;  // float rounding
    takeEdge(r, t.a, t.b);
    takeEdge(r, t.b, t.c);
    takeEdge(r, t.c, t.a);
    if (!finiteCorner(t.a) || !finiteCorner(t.b) || !finiteCorner(t.c)) return ivec4(0, 0, 0, 0);
    ivec2 x = pixelsIn(r.lowX - r.margin, r.highX + r.margin, push.widthPx), y = pixelsIn(r.lowY - r.margin, r.highY + r.margin, push.heightPx);
    return ivec4(x.x, x.y, y.x, y.y);
}

float edge(float u1, float v1, float u2, float v2) { return u1 * v2 - u2 * v1; }

void drawPixels(Corners t, ivec4 box, uint view, uint first, uint step) {
    uint width = uint(box.y - box.x), count = width * uint(box.w - box.z);
    for (uint i = first; i < count; i += step) {
        uint x = uint(box.x) + i % width, y = uint(box.z) + i / width;
        float px = float(x) + 0.5, py = float(y) + 0.5;
        float ua = t.a.x - t.a.z * px, va = t.a.y - t.a.z * py;
        float ub = t.b.x - t.b.z * px, vb = t.b.y - t.b.z * py;
        float uc = t.c.x - t.c.z * px, vc = t.c.y - t.c.z * py;
        float ea = edge(ub, vb, uc, vc), eb = -edge(ua, va, uc, vc), ec = edge(ua, va, ub, vb);
        if (!(min(ea, min(eb, ec)) >= 0.0 || max(ea, max(eb, ec)) <= 0.0)) continue;
        float z = (ea * t.a.z + eb * t.b.z + ec * t.c.z) / (ea + eb + ec);
        if (z > kNearM && isFinite(z)) atomicMin(depths[(view * push.heightPx + y) * push.widthPx + x], floatBitsToUint(z));
    }
}

void main() {
    uint lane = gl_LocalInvocationIndex, triangle = gl_WorkGroupID.x * kVertexGroup + lane;
    if (lane == 0u) largeCount = 0u;
    barrier();
    bool drawn = triangle < push.triangleCount && !isHidden(min(triangle, push.triangleCount - 1u));
    for (uint view = 0u; drawn && view < push.viewCount; ++view) {
        Corners t = cornersOf(triangle, view);
        ivec4 box = boxOf(t);
        if (uint(box.y - box.x) * uint(box.w - box.z) <= kMeshDepthOwnPixels) {
            drawPixels(t, box, view, 0u, 1u);
        } else {
            uint place = atomicAdd(largeCount, 1u);
            large[place] = triangle * push.viewCount + view;
        }
    }
    barrier();
    for (uint i = 0u; i < largeCount; ++i) {
        uint view = large[i] % push.viewCount;
        Corners t = cornersOf(large[i] / push.viewCount, view);
        drawPixels(t, boxOf(t), view, lane, kVertexGroup);
    }
}
