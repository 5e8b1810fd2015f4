// SPDX-License-Identifier: Apache-2.0
// Writes one vector of posed splats at a time: packed fields and triangle frames in, rows of the caller's buffers out. PosedTriangle
// (posed_splats.h) says the same for one splat.
#include "sdk/splat/simd.h"

#include <cstddef>
#include <cstring>
#include <iterator>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sdk/splat/write_kernel.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per instruction set; must come before the other Highway headers

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "sdk/splat/write_kernel.h"

HWY_BEFORE_NAMESPACE();
#include "sdk/splat/lanes-inl.h"
#include "sdk/splat/packed_lanes-inl.h"

namespace dpl {
namespace HWY_NAMESPACE {

/** The frames of the lanes' triangles, in the avatar's space. */
struct Frames {
    real3 v0, v1, v2, f0, f1, normal, light;
    real3 rest0, rest1, rest2;  // columns of worldFromRest
    real shown;
    truth valid;
};

HWY_INLINE Frames gather(const TriangleFrame<float>* frames, const uint32_t* indices) {
    using Frame = TriangleFrame<float>;
    static_assert(sizeof(bool) == 1 && offsetof(Frame, v1) == 12 && offsetof(Frame, f0) == 36 && offsetof(Frame, shown) == 60 &&
                  offsetof(Frame, normal) == 68 && offsetof(Frame, worldFromRest) == 80 && offsetof(Frame, light) == 116 &&
                  offsetof(Frame, valid) == 128);
    HWY_ALIGN float quads[8][kLanes * 4];
    HWY_ALIGN float valid[kLanes];
    for (size_t lane = 0; lane < kLanes; ++lane) {
        const Frame& frame = frames[indices[lane]];
        const float* words = &frame.v0.x;
        const auto copy = [&](size_t q) HWY_ATTR { copyQuad(words + 4 * q, &quads[q][4 * lane]); };
        copy(0), copy(1), copy(2), copy(3), copy(4), copy(5), copy(6), copy(7);
        valid[lane] = frame.valid ? 1 : 0;
    }
    Frames f;
    const D d;
    real bounded;
    const auto load4 = [&](size_t q, real& a, real& b, real& c, real& e)
                           HWY_ATTR { hn::LoadInterleaved4(d, quads[q], a.v, b.v, c.v, e.v); };
    load4(0, f.v0.x, f.v0.y, f.v0.z, f.v1.x), load4(1, f.v1.y, f.v1.z, f.v2.x, f.v2.y), load4(2, f.v2.z, f.f0.x, f.f0.y, f.f0.z);
    load4(3, f.f1.x, f.f1.y, f.f1.z, f.shown), load4(4, bounded, f.normal.x, f.normal.y, f.normal.z);
    load4(5, f.rest0.x, f.rest0.y, f.rest0.z, f.rest1.x), load4(6, f.rest1.y, f.rest1.z, f.rest2.x, f.rest2.y);
    load4(7, f.rest2.z, f.light.x, f.light.y, f.light.z);
    f.valid = real(hn::Load(d, valid)) > real(0);
    return f;
}

HWY_INLINE real3 choose3(truth condition, const real3& yes, const real3& no) {
    return {choose(condition, yes.x, no.x), choose(condition, yes.y, no.y), choose(condition, yes.z, no.z)};
}
HWY_INLINE real3 turn(const float* rows, const real3& a) {
    return {dot(vectorOf(rows), a), dot(vectorOf(rows + 3), a), dot(vectorOf(rows + 6), a)};
}

struct Quaternion {
    real x, y, z, w;
};

/** The rotation whose matrix has these columns, by the largest of its four numbers. */
HWY_INLINE Quaternion quaternionOf(const real3& a, const real3& b, const real3& c) {
    const real w = a.x + b.y + c.z, x = a.x - b.y - c.z, y = b.y - a.x - c.z, z = c.z - a.x - b.y;
    const real most = max(max(w, x), max(y, z)), largest = real(0.5) * sqrt(most + real(1)), factor = real(0.25) / largest;
    const truth isW = !(w < most), isX = !(x < most), isY = !(y < most);
    const auto pick = [&](real ifW, real ifX, real ifY, real ifZ)
                          HWY_ATTR { return choose(isW, ifW, choose(isX, ifX, choose(isY, ifY, ifZ))); };
    const real wx = factor * (b.z - c.y), wy = factor * (c.x - a.z), wz = factor * (a.y - b.x), xy = factor * (a.y + b.x),
               xz = factor * (c.x + a.z), yz = factor * (b.z + c.y);
    return {pick(wx, largest, xy, xz), pick(wy, xy, largest, yz), pick(wz, xz, yz, largest), pick(largest, wx, wy, wz)};
}

/** Bits of the nearest half of numbers within ±kMaxHalf: halfFromFloat over lanes. */
HWY_INLINE auto halfBits(real x) {
    const hn::RebindToUnsigned<D> du;
    const auto bits = hn::BitCast(du, x.v), magnitude = hn::And(bits, hn::Set(du, 0x7FFFFFFFu));
    const auto sign = hn::And(hn::ShiftRight<16>(bits), hn::Set(du, 0x8000u));
    const auto odd = hn::And(hn::ShiftRight<13>(magnitude), hn::Set(du, 1u));
    const auto normal = hn::ShiftRight<13>(magnitude - hn::Set(du, 112u << 23) + hn::Set(du, 0xFFFu) + odd);
    const auto small = hn::BitCast(du, (abs(x) + real(0.5)).v) - hn::Set(du, 0x3F000000u);
    return hn::Or(sign, hn::IfThenElse(magnitude < hn::Set(du, 0x38800000u), small, normal));
}

/** Where the lanes' rows of the caller lie. */
struct LaneRows {
    size_t first, count;
    uint64_t beyond;  // numbers that were too large for a half
};

/** Writes n numbers a lane. */
template <uint32_t n>
HWY_INLINE void put(const StridedNumbers& to, const real (&numbers)[n], LaneRows& rows) {
    const D d;
    uint8_t* row = to.first + rows.first * to.strideBytes;
    if (!to.half) {
        HWY_ALIGN float words[n][kLanes];
        for (uint32_t k = 0; k < n; ++k) hn::Store(numbers[k].v, d, words[k]);
        for (size_t lane = 0; lane < rows.count; ++lane, row += to.strideBytes)
            for (uint32_t k = 0; k < n; ++k) std::memcpy(row + 4 * k, &words[k][lane], 4);
        return;
    }
    const hn::RebindToUnsigned<D> du;
    HWY_ALIGN uint32_t words[n][kLanes];
    const auto written = hn::FirstN(d, rows.count);
    for (uint32_t k = 0; k < n; ++k) {
        const real most(kMaxHalf);
        rows.beyond += hn::CountTrue(d, hn::And(written, (abs(numbers[k]) > most).mask));
        hn::Store(halfBits(clamp(numbers[k], -most, most)), du, words[k]);
    }
    for (size_t lane = 0; lane < rows.count; ++lane, row += to.strideBytes)
        for (uint32_t k = 0; k < n; ++k) {
            const uint16_t half = uint16_t(words[k][lane]);
            std::memcpy(row + 2 * k, &half, sizeof half);
        }
}

/** One vector of splats, posed. */
struct Posed {
    real3 own, centre;          // in the avatar's space, and in the world
    real3 t1, t2, normal;       // orthonormal; the first two in the plane; world
    real3 rest0, rest1, rest2;  // columns of worldFromRest, in the avatar's space
    PlaneEllipse ellipse;
    real opacity, light;
};

HWY_INLINE Posed pose(const WriteTask& task, const float* fields) {
    using namespace bound_field;
    const WriteConstants& c = *task.constants;
    const Frames f = gather(task.frames, reinterpret_cast<const uint32_t*>(fields + kTriangle * kGroupSplats));
    const real zero(0), one(1), u = load(fields, kU), v = load(fields, kV);
    const real3 e1 = f.v1 - f.v0, e2 = f.v2 - f.v0;
    Posed p;
    p.own = barycentric(f.v0, e1, e2, u, v);
    p.centre = turn(c.rotation, real(c.scale) * p.own) + vectorOf(c.translation);
    p.light = barycentric(f.light.x, f.light.y - f.light.x, f.light.z - f.light.x, u, v);
    p.rest0 = f.rest0, p.rest1 = f.rest1, p.rest2 = f.rest2;

    const real3 x = choose3(f.valid, (one / sqrt(dot(e1, e1))) * e1, {one, zero, zero}), n = choose3(f.valid, f.normal, {zero, zero, one}),
                y = {n.y * x.z - n.z * x.y, n.z * x.x - n.x * x.z, n.x * x.y - n.y * x.x};
    p.t1 = turn(c.rotation, x), p.t2 = turn(c.rotation, y), p.normal = turn(c.rotation, n);
    const auto inPlane = [&](const real3& axis, const real3& f0) HWY_ATTR { return choose(f.valid, real(c.scale) * dot(axis, f0), zero); };
    PlaneAxes axes;
    axes.a10 = load(fields, kAxis10), axes.a11 = load(fields, kAxis11), axes.a20 = load(fields, kAxis20), axes.a21 = load(fields, kAxis21);
    p.ellipse = planeEllipse(axes, inPlane(x, f.f0), inPlane(x, f.f1), inPlane(y, f.f0), inPlane(y, f.f1));

    real shown = f.shown;
    if (c.hasEye) {
        const real3 eye = vectorOf(c.eye), toCentre = eye - p.own;
        const real gate = singleFaceGate(dot(f.normal, eye - f.v0), sqrt(dot(toCentre, toCentre)));
        shown = choose(load(fields, kSingleFace) > zero, shown * gate, shown);
    }
    p.opacity = choose(f.valid, load(fields, kOpacity) * shown, zero);
    return p;
}

HWY_INLINE real3 colourOf(const WriteTask& task, const Posed& p, const float* sh) {
    const WriteConstants& c = *task.constants;
    real3 sum = shBand0(sh);
    if (c.hasEye && task.shDegree > 0) {
        const real3 away = p.own - vectorOf(c.eye);
        const real distanceM = sqrt(dot(away, away));
        const real3 seen = (real(1) / distanceM) * away;
        const real3 direction = {dot(p.rest0, seen), dot(p.rest1, seen), dot(p.rest2, seen)};
        real3 all = addShBand<1>(sum, direction, sh);
        if (task.shDegree > 1) all = addShBand<2>(all, direction, sh);
        if (task.shDegree > 2) all = addShBand<3>(all, direction, sh);
        sum = choose3(distanceM > real(0), all, sum);
    }
    const auto lit = [&](real a) HWY_ATTR { return clamp(a * p.light, real(0), real(1)); };
    return {lit(sum.x), lit(sum.y), lit(sum.z)};
}

/** A band of coefficients, turned into the world with the light in them (ShRotator, foldLight). */
template <uint32_t kBand>
HWY_INLINE void turnBand(const WriteConstants& c, const Posed& p, const float* sh, real (&out)[(2 * kBand + 1) * 3]) {
    constexpr uint32_t n = 2 * kBand + 1, firstDirection = kBand * kBand - 1, firstInverse = kBand == 1 ? 0 : kBand == 2 ? 9 : 34;
    const real zero(0);
    real3 values[n];  // of the band, in each direction
    for (uint32_t i = 0; i < n; ++i) {
        const float* world = c.shDirections + 3 * (firstDirection + i);
        float own[3];  // turned back by the placement
        for (int k = 0; k < 3; ++k) own[k] = c.rotation[k] * world[0] + c.rotation[3 + k] * world[1] + c.rotation[6 + k] * world[2];
        const real3 d = vectorOf(own);
        values[i] = addShBand<kBand>({zero, zero, zero}, {dot(p.rest0, d), dot(p.rest1, d), dot(p.rest2, d)}, sh);
    }
    for (uint32_t m = 0; m < n; ++m) {
        real3 sum = {zero, zero, zero};
        for (uint32_t i = 0; i < n; ++i) sum = sum + real(c.shInverse[firstInverse + m * n + i]) * values[i];
        out[3 * m] = p.light * sum.x, out[3 * m + 1] = p.light * sum.y, out[3 * m + 2] = p.light * sum.z;
    }
}

HWY_INLINE void putSh(const WriteTask& task, const Posed& p, const float* sh, StridedNumbers to, LaneRows& rows) {
    const WriteConstants& c = *task.constants;
    const auto next = [&](const auto& numbers) HWY_ATTR {
        put(to, numbers, rows);
        to.first += (to.half ? 2 : 4) * std::size(numbers);
    };
    const auto band = [&]<uint32_t kBand>() HWY_ATTR {
        if (c.shDegree < kBand) return;
        real numbers[(2 * kBand + 1) * 3];
        if (task.shDegree < kBand)
            for (real& number : numbers) number = real(0);
        else
            turnBand<kBand>(c, p, sh, numbers);
        next(numbers);
    };
    const real3 dc = load3(sh, 0);
    const real first[3] = {litCoefficient0(dc.x, p.light), litCoefficient0(dc.y, p.light), litCoefficient0(dc.z, p.light)};
    next(first);
    band.template operator()<1>(), band.template operator()<2>(), band.template operator()<3>();
}

HWY_INLINE void putCovariance(const Posed& p, const StridedNumbers& to, LaneRows& rows) {
    const real thin = flatThicknessM(), across = thin * thin;
    const real x[3] = {p.t1.x, p.t1.y, p.t1.z}, y[3] = {p.t2.x, p.t2.y, p.t2.z}, n[3] = {p.normal.x, p.normal.y, p.normal.z};
    real six[6];
    for (uint32_t i = 0, number = 0; i < 3; ++i)
        for (uint32_t k = i; k < 3; ++k, ++number) six[number] = ellipseCovariance(p.ellipse, across, x[i], y[i], n[i], x[k], y[k], n[k]);
    put(to, six, rows);
}

/** The columns of a vector of splats that need its principal axes. */
HWY_INLINE void putAxes(const WriteTask& task, const Posed& p, LaneRows& rows) {
    const EllipseAxes e = ellipseAxes(p.ellipse);
    const real thin = flatThicknessM(), cosine = e.halfCosine, sine = e.halfSine;
    const truth isFlat = e.major > real(0);
    const Quaternion f = quaternionOf(p.t1, p.t2, p.normal);
    const Quaternion q = {f.x * cosine + f.y * sine, f.y * cosine - f.x * sine, f.z * cosine + f.w * sine, f.w * cosine - f.z * sine};
    const real wLast[4] = {q.x, q.y, q.z, q.w}, wFirst[4] = {q.w, q.x, q.y, q.z};
    const real scale[3] = {choose(isFlat, e.major, thin), choose(isFlat, e.minor, thin), thin};
    for (const SplatColumn& column : task.columns) {
        if (column.what == SplatNumbers::Rotation) put(column.to, wLast, rows);
        if (column.what == SplatNumbers::RotationWxyz) put(column.to, wFirst, rows);
        if (column.what == SplatNumbers::Scale) put(column.to, scale, rows);
    }
}

uint64_t writeGroups(const WriteTask& task) {
    const uint32_t fieldCount = groupFields(true, task.shDegree);
    bool hasAxes = false;
    for (const SplatColumn& column : task.columns)
        hasAxes |= column.what == SplatNumbers::Rotation || column.what == SplatNumbers::RotationWxyz || column.what == SplatNumbers::Scale;
    uint64_t beyond = 0;
    for (size_t first = 0; first < task.count; first += kLanes) {
        const float* fields = task.packed + first / kGroupSplats * (fieldCount * kGroupSplats) + first % kGroupSplats;
        const float* sh = fields + bound_field::kSh * kGroupSplats;
        LaneRows rows{task.firstRow + first, HWY_MIN(kLanes, task.count - first), 0};
        const Posed p = pose(task, fields);
        if (hasAxes) putAxes(task, p, rows);
        for (const SplatColumn& column : task.columns) {
            if (column.what == SplatNumbers::Position) {
                const real numbers[3] = {p.centre.x, p.centre.y, p.centre.z};
                put(column.to, numbers, rows);
            } else if (column.what == SplatNumbers::Covariance) {
                putCovariance(p, column.to, rows);
            } else if (column.what == SplatNumbers::Opacity) {
                const real numbers[1] = {p.opacity};
                put(column.to, numbers, rows);
            } else if (column.what == SplatNumbers::Colour) {
                const real3 colour = colourOf(task, p, sh);
                const real numbers[3] = {colour.x, colour.y, colour.z};
                put(column.to, numbers, rows);
            } else if (column.what == SplatNumbers::Sh) {
                putSh(task, p, sh, column.to, rows);
            }
        }
        beyond += rows.beyond;
    }
    return beyond;
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(writeGroups);
uint64_t writeGroups(const WriteTask& task) {
    return HWY_DYNAMIC_DISPATCH(writeGroups)(task);
}
}  // namespace dpl
#endif
