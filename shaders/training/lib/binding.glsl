// SPDX-License-Identifier: Apache-2.0
// Triangles and forward records under the names that the shared formulas use. Needs train.glsl.
#include "sdk/math/formulas/binding.inl"
#include "sdk/math/formulas/footprint.inl"
#include "sdk/math/formulas/sh.inl"

struct ForwardRecord {  // sdk/splat/forward_record.h
    float a10, a11, a20, a21;
    float b1X, b1Y, b2X, b2Y;
    float slopeX, slopeY, clampedX, clampedY;
    float depthM, inverseZ, axis1Z, axis2Z;
    float conicA, conicB, conicC, inverseDet;
    float compensation, nearFade, gate, cosine;
    float directionX, directionY, directionZ, inverseDistance;
    float red, green, blue, light;
};

struct TriangleFrame {  // sdk/math/binding.h
    vec3 v0, v1, v2;
    vec3 f0, f1;
    float shown;
    bool bounded;
    vec3 normal;
    mat3 worldFromRest;
    vec3 light;
};

TriangleFrame triangleFrameOf(TrainTriangle t) {
    return TriangleFrame(vec3(t.v0X, t.v0Y, t.v0Z), vec3(t.v1X, t.v1Y, t.v1Z), vec3(t.v2X, t.v2Y, t.v2Z), vec3(t.f0X, t.f0Y, t.f0Z),
                         vec3(t.f1X, t.f1Y, t.f1Z), t.shown, (t.flags & kTrainBounded) != 0u, vec3(t.normalX, t.normalY, t.normalZ),
                         mat3(t.restX0, t.restX1, t.restX2, t.restY0, t.restY1, t.restY2, t.restZ0, t.restZ1, t.restZ2),
                         vec3(t.light0, t.light1, t.light2));
}

Lens frameLens() {
    Lens lens;
    lens.focalPx = frame.focalPx;
    lens.centrePx = frame.centrePx;
    lens.minSlope = frame.minSlope;
    lens.maxSlope = frame.maxSlope;
    return lens;
}

/** Basis of spherical harmonics, zero above the degree of the frame. */
void shBasisOf(vec3 d, out float basis[16]) {
    ShBand1 one = shBand1(d);
    ShBand2 two = shBand2(d);
    ShBand3 three = shBand3(d);
    basis = float[16](kShC0, one.b1, one.b2, one.b3, two.b4, two.b5, two.b6, two.b7, two.b8, three.b9, three.b10, three.b11, three.b12,
                      three.b13, three.b14, three.b15);
}
