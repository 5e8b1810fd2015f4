// SPDX-License-Identifier: Apache-2.0
// Projects one vector of splats at a time: packed fields in, ProjectedSplat records, tile boxes and depth keys out. The formulas are those
// of sdk/math/formulas over lanes (sdk/splat/lanes-inl.h); this file loads, selects and stores.
#include "sdk/splat/simd.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sdk/splat/project_kernel.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per instruction set; must come before the other Highway headers

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "sdk/splat/project_kernel.h"

HWY_BEFORE_NAMESPACE();
#include "sdk/splat/lanes-inl.h"
#include "sdk/splat/packed_lanes-inl.h"

namespace dpl {
namespace HWY_NAMESPACE {

/** A splat in one view, without its colour. */
struct Shape {
    real3 view, restDirection;  // centre in view space; from the eye to the centre in the rest frame, not normalised
    Jacobian jacobian;
    Spread spread;
    real opacity, nearFade, gate, cloth, light;  // gate: as in ForwardRecord
    truth valid;
    // Bound splats only, for ForwardRecord.
    PlaneAxes axes;
    real2 b1, b2;
    real f0Z, f1Z;  // view z of the columns of F
    real planeDot, distanceM;
};

HWY_INLINE real3 turn(const ProjectView& c, const real3& a) {
    const float* r = c.rotation;
    return {dot({real(r[0]), real(r[1]), real(r[2])}, a), dot({real(r[3]), real(r[4]), real(r[5])}, a),
            dot({real(r[6]), real(r[7]), real(r[8])}, a)};
}

HWY_INLINE Lens lensOf(const ProjectView& c) {
    Lens lens;
    lens.focalPx = {real(c.fx), real(c.fy)};
    lens.centrePx = {real(c.cx), real(c.cy)};
    lens.minSlope = {real(c.minX), real(c.minY)};
    lens.maxSlope = {real(c.maxX), real(c.maxY)};
    return lens;
}

HWY_INLINE void staticShape(const ProjectTask& task, const Lens& lens, const float* fields, Shape& s) {
    using namespace static_field;
    const ProjectView& c = *task.view;
    const real3 world = load3(fields, kPosition);
    s.restDirection = world - vectorOf(c.eye);
    s.view = turn(c, world) + vectorOf(c.translation);
    s.jacobian = jacobianAt(lens, s.view);
    s.spread =
        solidSpread(axisOnScreen(s.jacobian, turn(c, load3(fields, kAxes))), axisOnScreen(s.jacobian, turn(c, load3(fields, kAxes + 3))),
                    axisOnScreen(s.jacobian, turn(c, load3(fields, kAxes + 6))));
    s.nearFade = nearFade(s.view.z);
    s.gate = real(1);
    s.opacity = load(fields, kOpacity);
    s.cloth = real(0);
    s.light = real(1);
    s.valid = s.view.z > real(kNearM);
}

HWY_INLINE void boundShape(const ProjectTask& task, const Lens& lens, const float* fields, Shape& s) {
    using namespace bound_field;
    HWY_ALIGN float quads[8][kLanes * 4];
    const uint32_t* indices = reinterpret_cast<const uint32_t*>(fields + kTriangle * kGroupSplats);
    for (size_t lane = 0; lane < kLanes; ++lane) {
        const float* record = reinterpret_cast<const float*>(task.triangles + HWY_MIN(indices[lane], task.triangleCount));
        const auto copy = [&](size_t q) HWY_ATTR { copyQuad(record + 4 * q, &quads[q][4 * lane]); };
        copy(0), copy(1), copy(2), copy(3), copy(4), copy(5), copy(6), copy(7);
    }
    real shown, light0, light1, light2, pad;
    const real u = load(fields, kU), v = load(fields, kV);
    const real3 v0 = loadQuad(quads[0], s.planeDot), e1 = loadQuad(quads[1], shown), e2 = loadQuad(quads[2], light0);
    s.view = barycentric(v0, e1, e2, u, v);
    const real3 r0 = loadQuad(quads[5], pad), r1 = loadQuad(quads[6], pad), r2 = loadQuad(quads[7], pad);
    s.restDirection = barycentric(r0, r1, r2, u, v);
    const real3 f0 = loadQuad(quads[3], light1), f1 = loadQuad(quads[4], light2);
    s.f0Z = f0.z, s.f1Z = f1.z;
    s.jacobian = jacobianAt(lens, s.view);
    s.axes.a10 = load(fields, kAxis10), s.axes.a11 = load(fields, kAxis11), s.axes.a20 = load(fields, kAxis20);
    s.axes.a21 = load(fields, kAxis21);
    const real2 screen0 = axisOnScreen(s.jacobian, f0), screen1 = axisOnScreen(s.jacobian, f1);
    s.b1 = s.axes.a10 * screen0 + s.axes.a11 * screen1;
    s.b2 = s.axes.a20 * screen0 + s.axes.a21 * screen1;
    s.spread = flatSpread(s.b1, s.b2);
    s.nearFade = nearFade(s.view.z);
    s.distanceM = sqrt(dot(s.view, s.view));
    s.gate = choose(load(fields, kSingleFace) > real(0), singleFaceGate(s.planeDot, s.distanceM), real(1)) * shown;
    s.opacity = load(fields, kOpacity);
    s.cloth = load(fields, kCloth);
    s.light = barycentric(light0, light1, light2, u, v);
    s.valid = s.view.z > real(kNearM) && shown > real(0);
}

/** 0.5 + Σ basis·sh. direction: unit, rest frame; sh: the first SH field of the group at this lane. */
template <uint32_t kDegree>
HWY_INLINE real3 shSum(const real3& direction, const float* sh) {
    real3 sum = shBand0(sh);
    if constexpr (kDegree >= 1) sum = addShBand<1>(sum, direction, sh);
    if constexpr (kDegree >= 2) sum = addShBand<2>(sum, direction, sh);
    if constexpr (kDegree >= 3) sum = addShBand<3>(sum, direction, sh);
    return sum;
}

/** Stores (a, b, c, d) of each lane, kStride floats apart. */
template <size_t kStride>
HWY_INLINE void storeQuads(real a, real b, real c, real d, float* out) {
    HWY_ALIGN float quads[kLanes * 4];
    hn::StoreInterleaved4(a.v, b.v, c.v, d.v, D(), quads);
    for (size_t lane = 0; lane < kLanes; ++lane) copyQuad(&quads[4 * lane], out + kStride * lane);
}

template <bool kBound, uint32_t kDegree, bool kRecord>
void projectAs(const ProjectTask& task) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const hn::RebindToSigned<D> di;
    const ProjectView& c = *task.view;
    const Lens lens = lensOf(c);
    const real zero(0), one(1), kappa(c.kappaPx2), nearest(0.5 + c.reachPx), farthest(0.5 - c.reachPx), huge(1e30);
    constexpr uint32_t kFields = groupFields(kBound, kDegree), kShField = kBound ? bound_field::kSh : static_field::kSh;
    BlockVisible& visible = *task.visible;
    auto minKey = hn::Set(du, visible.minKey), maxKey = hn::Set(du, visible.maxKey), tileEntries = hn::Zero(du);

    for (uint32_t step = 0; step < task.groups * (kGroupSplats / kLanes); ++step) {
        const uint32_t splat = task.firstSplat + step * uint32_t(kLanes);
        const size_t offset = size_t(step) * kLanes;
        const float* fields = task.packed + offset / kGroupSplats * (kFields * kGroupSplats) + offset % kGroupSplats;
        Shape s;
        if constexpr (kBound)
            boundShape(task, lens, fields, s);
        else
            staticShape(task, lens, fields, s);

        Footprint f = footprintOf(lens, s.jacobian, s.view.z, s.spread, kappa);
        if (!c.compensated) f.compensation = one;
        const real opacity = s.opacity * f.compensation * (s.nearFade * s.gate);
        const real x = f.centrePx.x, y = f.centrePx.y;

        // Comparisons with NaN are false, so splats with numbers that are not finite are hidden here.
        truth shown = s.valid && f.visible && opacity > real(kMinAlpha) && opacity < huge && abs(x) < huge && abs(y) < huge;
        const real q = visibleRadius2(choose(shown, opacity, real(kMinAlpha)));
        const real radiusX = sqrt(q * f.varianceX), radiusY = sqrt(q * f.varianceY);
        // The box contains every pixel that has a sample within the radius.
        const real lastX(c.width - 1), lastY(c.height - 1);
        const real x0 = max(hn::Ceil((x - radiusX - nearest).v), zero), x1 = min(hn::Floor((x + radiusX - farthest).v), lastX);
        const real y0 = max(hn::Ceil((y - radiusY - nearest).v), zero), y1 = min(hn::Floor((y + radiusY - farthest).v), lastY);
        shown = shown && x0 <= x1 && y0 <= y1;

        real3 colour = {zero, zero, zero};
        if (!hn::AllFalse(d, shown.mask)) {
            const real inverseDistance = one / sqrt(dot(s.restDirection, s.restDirection));
            const real3 direction = inverseDistance * s.restDirection;
            const real3 unlit = shSum<kDegree>(direction, fields + kShField * kGroupSplats);
            const auto lit = [&](real a) HWY_ATTR { return choose(a > zero, min(a * s.light, one), zero); };  // NaN becomes black
            colour = {lit(unlit.x), lit(unlit.y), lit(unlit.z)};
            if constexpr (kRecord) {
                float* out = reinterpret_cast<float*>(task.records + splat);
                const Jacobian& j = s.jacobian;
                const auto store = [&](size_t quad, real a, real b, real e, real g)
                                       HWY_ATTR { storeQuads<32>(a, b, e, g, out + 4 * quad); };
                store(0, s.axes.a10, s.axes.a11, s.axes.a20, s.axes.a21);
                store(1, s.b1.x, s.b1.y, s.b2.x, s.b2.y);
                store(2, j.slope.x, j.slope.y, j.clampedSlope.x, j.clampedSlope.y);
                store(3, f.depthM, j.inverseZ, s.axes.a10 * s.f0Z + s.axes.a11 * s.f1Z, s.axes.a20 * s.f0Z + s.axes.a21 * s.f1Z);
                store(4, f.conicA, f.conicB, f.conicC, f.inverseDet);
                store(5, f.compensation, s.nearFade, s.gate, s.planeDot / s.distanceM);
                store(6, direction.x, direction.y, direction.z, inverseDistance);
                store(7, unlit.x, unlit.y, unlit.z, s.light);
            }
            // Clamped to the target first: hidden lanes may hold values that do not convert to an integer.
            const auto tile = [&](real a, real last)
                                  HWY_ATTR { return hn::BitCast(du, hn::ShiftRight<4>(hn::ConvertTo(di, clamp(a, zero, last).v))); };
            static_assert(kTileSizePx == 16);
            const auto tx0 = tile(x0, lastX), tx1 = tile(x1, lastX), ty0 = tile(y0, lastY), ty1 = tile(y1, lastY);
            hn::StoreInterleaved2(hn::Or(tx0, hn::ShiftLeft<16>(ty0)), hn::Or(tx1, hn::ShiftLeft<16>(ty1)), du,
                                  reinterpret_cast<uint32_t*>(task.boxes + splat));
            const auto oneU = hn::Set(du, 1);
            const auto shownU = hn::RebindMask(du, shown.mask);
            tileEntries = tileEntries + hn::IfThenElseZero(shownU, (tx1 - tx0 + oneU) * (ty1 - ty0 + oneU));
            const auto key = hn::BitCast(du, s.view.z.v);  // positive floats order like their bits
            minKey = hn::Min(minKey, hn::IfThenElse(shownU, key, minKey)), maxKey = hn::Max(maxKey, hn::IfThenElseZero(shownU, key));
            hn::CompressStore(key, shownU, du, task.keys + visible.count);
            visible.count += uint32_t(hn::CompressStore(hn::Iota(du, task.firstIndex + splat), shownU, du, task.values + visible.count));
        }

        const real index = hn::BitCast(d, hn::Iota(du, task.firstIndex + splat));
        HWY_ALIGN float records[4][kLanes * 4];
        hn::StoreInterleaved4(x.v, y.v, f.conicA.v, f.conicB.v, d, records[0]);
        hn::StoreInterleaved4(f.conicC.v, choose(shown, opacity, zero).v, colour.x.v, colour.y.v, d, records[1]);
        hn::StoreInterleaved4(colour.z.v, radiusX.v, radiusY.v, s.view.z.v, d, records[2]);
        hn::StoreInterleaved4((one / f.varianceY).v, index.v, s.cloth.v, zero.v, d, records[3]);
        float* out = reinterpret_cast<float*>(task.projected + splat);
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const auto copy = [&](size_t k) HWY_ATTR { copyQuad(&records[k][4 * lane], out + 16 * lane + 4 * k); };
            copy(0), copy(1), copy(2), copy(3);
        }
    }
    visible.minKey = hn::GetLane(hn::MinOfLanes(du, minKey)), visible.maxKey = hn::GetLane(hn::MaxOfLanes(du, maxKey));
    HWY_ALIGN uint32_t sums[kLanes];
    hn::Store(tileEntries, du, sums);
    for (const uint32_t sum : sums) visible.tileEntries += sum;
}

void projectGroups(const ProjectTask& task) {
    using Kernel = void (*)(const ProjectTask&);
    static constexpr Kernel kGeneral[4] = {projectAs<false, 0, false>, projectAs<false, 1, false>, projectAs<false, 2, false>,
                                           projectAs<false, 3, false>},
                            kBound[4] = {projectAs<true, 0, false>, projectAs<true, 1, false>, projectAs<true, 2, false>,
                                         projectAs<true, 3, false>};
    const Kernel* kernels = task.triangles ? kBound : kGeneral;
#ifndef DOPPEL_WITHOUT_TRAINER  // which alone asks for records
    static constexpr Kernel kRecorded[4] = {projectAs<true, 0, true>, projectAs<true, 1, true>, projectAs<true, 2, true>,
                                            projectAs<true, 3, true>};
    if (task.triangles && task.records) kernels = kRecorded;
#endif
    kernels[task.shDegree](task);
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(projectGroups);
void projectGroups(const ProjectTask& task) {
    HWY_DYNAMIC_DISPATCH(projectGroups)(task);
}
}  // namespace dpl
#endif
