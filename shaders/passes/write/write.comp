// SPDX-License-Identifier: Apache-2.0
// Writes the splats of one posed avatar as general Gaussians into a buffer of the app, one row a splat: what PosedSplatWriter does on the CPU
// (sdk/splat/posed_splats.cpp). Words that no property covers keep their bits. Offsets and strides are whole words, so no two lanes share
// a word.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "sdk/math/formulas/binding.inl"
#include "sdk/math/formulas/ellipse.inl"
#include "shaders/lib/quaternion.glsl"
layout(local_size_x = 128) in;  // kSplatGroup

layout(std140, binding = 0) uniform WriteBlock { WriteData data; };
DPL_WORDS(1, CodeBlock, codes);
DPL_FOURS(2, TriangleBlock, triangles);  // TriangleFrame
DPL_FOURS(3, KeptBlock, kept);           // KeptRecord; read where data.thinned is set
layout(std430, binding = 4) buffer RowBlock { uint rows[]; };  // of the app
layout(push_constant) uniform PushBlock { CodesPush push; };
#include "shaders/lib/sh_degree.glsl"
#include "shaders/lib/codes.glsl"
#include "shaders/lib/triangle_frame.glsl"

vec3 dplSh(uint base, uint k) {
    if (k > 0u && data.shShare <= 0.0) return vec3(0.0);  // their coefficients were not fetched
    return k > 0u ? data.shShare * dplShCode(k) : dplShCode(k);
}
#include "shaders/lib/sh.glsl"

// Numbers of a row, one after the other. Halves go out in pairs.
uint nextWord;
bool writesHalves, holdsHalf;
float held;

uint halves(float low, float high) { return packHalf2x16(clamp(vec2(low, high), -65504.0, 65504.0)); }

void beginRow(uvec4 element, uint row) {
    nextWord = element.y + row * element.z;
    writesHalves = element.w != 0u;
    holdsHalf = false;
}
void put(float number) {
    if (writesHalves && !holdsHalf) {
        held = number;
        holdsHalf = true;
        return;
    }
    rows[nextWord] = writesHalves ? halves(held, number) : floatBitsToUint(number);
    ++nextWord;
    holdsHalf = false;
}
void put(vec3 numbers) {
    put(numbers.x);
    put(numbers.y);
    put(numbers.z);
}
void endRow() {
    if (holdsHalf) rows[nextWord] = (rows[nextWord] & 0xFFFF0000u) | (halves(held, 0.0) & 0xFFFFu);
}

vec3 bandAt(uint band, vec3 d) {
    vec3 sum = vec3(0.0);
    if (kShDegree >= 1u && band == 1u) {
        ShBand1 b = shBand1(d);
        sum = b.b1 * dplSh(0u, 1u) + b.b2 * dplSh(0u, 2u) + b.b3 * dplSh(0u, 3u);
    }
    if (kShDegree >= 2u && band == 2u) {
        ShBand2 b = shBand2(d);
        sum = b.b4 * dplSh(0u, 4u) + b.b5 * dplSh(0u, 5u) + b.b6 * dplSh(0u, 6u) + b.b7 * dplSh(0u, 7u) + b.b8 * dplSh(0u, 8u);
    }
    if (kShDegree >= 3u && band == 3u) {
        ShBand3 b = shBand3(d);
        sum = b.b9 * dplSh(0u, 9u) + b.b10 * dplSh(0u, 10u) + b.b11 * dplSh(0u, 11u) + b.b12 * dplSh(0u, 12u);
        sum += b.b13 * dplSh(0u, 13u) + b.b14 * dplSh(0u, 14u) + b.b15 * dplSh(0u, 15u);
    }
    return sum;
}

float inverseAt(uint number) { return data.shInverse[number >> 2u][number & 3u]; }

/** The coefficients, turned into the world with the light in them. As ShRotator: the values of a band at 2l + 1 directions, turned back,
 *  determine the band. */
void putSh(mat3 worldFromRest, float light) {
    vec3 dc = dplSh(0u, 0u);
    put(vec3(litCoefficient0(dc.x, light), litCoefficient0(dc.y, light), litCoefficient0(dc.z, light)));
    uint firstDirection = 0u, firstInverse = 0u;
    for (uint band = 1u; band <= data.shDegree; ++band) {
        uint size = 2u * band + 1u;
        vec3 values[7];
        for (uint i = 0u; i < size; ++i)
            values[i] = band <= kShDegree ? bandAt(band, data.shDirections[firstDirection + i].xyz * worldFromRest) : vec3(0.0);
        for (uint m = 0u; m < size; ++m) {
            vec3 sum = vec3(0.0);
            for (uint i = 0u; i < size; ++i) sum += inverseAt(firstInverse + m * size + i) * values[i];
            put(light * sum);
        }
        firstDirection += size;
        firstInverse += size * size;
    }
}

vec3 turned(vec3 own) { return vec3(dot(data.worldFromOwnRow0.xyz, own), dot(data.worldFromOwnRow1.xyz, own), dot(data.worldFromOwnRow2.xyz, own)); }
vec3 placed(uvec4 own) { return turned(uintBitsToFloat(own.xyz)) + vec3(data.worldFromOwnRow0.w, data.worldFromOwnRow1.w, data.worldFromOwnRow2.w); }

void main() {
    uint group = gl_WorkGroupID.x, lane = gl_LocalInvocationIndex, row, splat;
    float weight = 1.0, growth = 1.0;
    if (data.thinned != 0u) {
        row = group * kSplatGroup + lane;
        if (row >= data.rows) return;
        uvec4 record = DPL_FOUR(kept, row);
        splat = record.x;
        dplFirstChunkWord = record.y;
        weight = uintBitsToFloat(record.z);
        growth = uintBitsToFloat(record.w);
    } else {
        dplFirstChunkWord = (group >> 1u) * kChunkWords;
        if (lane >= dplCountOf(group)) return;
        row = splat = dplFirstOf(group) + lane;
    }
    uint size = DPL_WORD(codes, push.firstSize + splat), place = DPL_WORD(codes, push.firstPlace + splat);
    vec2 scale = growth * dplScale(size), uv = dplUv(place);
    float phi = float(place >> 22u) * kPhiCodeStep;
    dplFetchSh(splat, data.shShare > 0.0);

    // The frame of its triangle, in the world.
    uint parent = kTriangleFrameFours * dplParent(splat);
    uvec4 corner0 = DPL_FOUR(triangles, parent), corner1 = DPL_FOUR(triangles, parent + 1u), corner2 = DPL_FOUR(triangles, parent + 2u);
    uvec4 column0 = DPL_FOUR(triangles, parent + 3u), column1 = DPL_FOUR(triangles, parent + 4u);
    bool valid = corner1.w != 0u || corner2.w != 0u;  // only a triangle that shows nothing has no rotation
    vec3 v0 = placed(corner0), v1 = placed(corner1), v2 = placed(corner2);
    vec3 f0 = turned(uintBitsToFloat(column0.xyz)), f1 = turned(uintBitsToFloat(column1.xyz));
    vec2 light01 = unpackHalf2x16(column0.w), light2AndHidden = unpackHalf2x16(column1.w);
    vec3 centre = barycentric(v0, v1 - v0, v2 - v0, uv.x, uv.y);
    float light = barycentric(light01.x, light01.y - light01.x, light2AndHidden.x - light01.x, uv.x, uv.y);
    vec3 t1 = vec3(1.0, 0.0, 0.0), t2 = vec3(0.0, 1.0, 0.0), normal = vec3(0.0, 0.0, 1.0);
    mat3 worldFromRest = mat3(1.0);
    if (valid) {
        t1 = normalize(v1 - v0);
        normal = normalize(cross(v1 - v0, v2 - v0));
        t2 = cross(normal, t1);
        mat3 placement = transpose(mat3(data.worldFromOwnRow0.xyz, data.worldFromOwnRow1.xyz, data.worldFromOwnRow2.xyz)) * (1.0 / data.scale);
        worldFromRest = placement * dplRotationOf(vec4(unpackSnorm2x16(corner1.w), unpackSnorm2x16(corner2.w)));
    }
    PlaneEllipse ellipse = planeEllipse(planeAxes(cos(phi), sin(phi), scale.x, scale.y), dot(t1, f0), dot(t1, f1), dot(t2, f0), dot(t2, f1));
    EllipseAxes axes = ellipseAxes(ellipse);

    for (uint e = 0u; e < data.elementCount; ++e) {
        uint property = data.elements[e].x;
        beginRow(data.elements[e], row);
        if (property == kWritePosition) put(centre);
        if (property == kWriteRotation || property == kWriteRotationWxyz) {
            vec4 q = dplQuaternionProduct(dplQuaternionOf(mat3(t1, t2, normal)), vec4(0.0, 0.0, axes.halfSine, axes.halfCosine));
            if (property == kWriteRotationWxyz) put(q.w);
            put(q.xyz);
            if (property == kWriteRotation) put(q.w);
        }
        if (property == kWriteScale) put(vec3(axes.major > 0.0 ? vec2(axes.major, axes.minor) : vec2(flatThicknessM()), flatThicknessM()));
        if (property == kWriteCovariance) {
            for (uint i = 0u; i < 3u; ++i)
                for (uint k = i; k < 3u; ++k)
                    put(ellipseCovariance(ellipse, flatThicknessM() * flatThicknessM(), t1[i], t2[i], normal[i], t1[k], t2[k], normal[k]));
        }
        if (property == kWriteOpacity) {
            float opacity = valid ? weight * dplOpacity(size) * (1.0 - light2AndHidden.y) : 0.0;
            vec3 toEye = vec3(data.eyeX, data.eyeY, data.eyeZ);
            if (valid && data.hasEye != 0u && dplGated(size)) opacity *= singleFaceGate(dot(normal, toEye - v0), length(toEye - centre));
            put(opacity);
        }
        if (property == kWriteColour) {
            vec3 away = data.hasEye != 0u ? centre - vec3(data.eyeX, data.eyeY, data.eyeZ) : vec3(0.0);
            float distanceM = length(away);
            if (kShDegree > 0u && distanceM > 0.0) put(dplShColour((away / distanceM) * worldFromRest, 0u, light));
            else put(clamp((vec3(0.5) + kShC0 * dplSh(0u, 0u)) * light, vec3(0.0), vec3(1.0)));
        }
        if (property == kWriteSh) putSh(worldFromRest, light);
        endRow();
    }
}
