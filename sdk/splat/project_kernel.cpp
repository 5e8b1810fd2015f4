// SPDX-License-Identifier: Apache-2.0
// One vector of splats at a time: packed fields in, ProjectedSplat records, tile boxes and depth keys out. The formulas are those of
// sdk/math/{projection,binding,sh}.h; tests/reference holds both to the same double-precision referee.
#include "sdk/splat/simd.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sdk/splat/project_kernel.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per instruction set; must come before the other Highway headers

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "sdk/splat/project_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kGroupSplats>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr size_t kLanes = hn::MaxLanes(D());

HWY_INLINE V set(float x) {
    return hn::Set(D(), x);
}
HWY_INLINE V fma(V a, V b, V c) {
    return hn::MulAdd(a, b, c);
}

struct V3 {
    V x, y, z;
};
HWY_INLINE V dot(const V3& a, const V3& b) {
    return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}

HWY_INLINE V smoothStep01(V x) {
    x = hn::Min(hn::Max(x, hn::Zero(D())), set(1));
    return x * x * hn::NegMulAdd(x, set(2), set(3));
}

/** Everything about a splat but its colour. */
struct Shape {
    V3 view, restDirection;  // centre in view space; eye → centre in the rest frame, not normalised
    V varianceX, varianceY, covariance, detB2;
    V opacity, fade, cloth, light;
    M valid;
};

/** The 2×3 Jacobian at a view-space point, as scale and clamped slope: row0(a) = jx·(a.x − sx·a.z). */
struct Jacobian {
    V jx, jy, sx, sy, slopeX, slopeY;
    HWY_INLINE void at(const ProjectView& c, const V3& view) {
        const V invZ = set(1) / view.z;
        slopeX = view.x * invZ, slopeY = view.y * invZ;
        jx = set(c.fx) * invZ, jy = set(c.fy) * invZ;
        sx = hn::Min(hn::Max(slopeX, set(c.minX)), set(c.maxX)), sy = hn::Min(hn::Max(slopeY, set(c.minY)), set(c.maxY));
    }
    HWY_INLINE V row0(const V3& a) const { return jx * hn::NegMulAdd(sx, a.z, a.x); }
    HWY_INLINE V row1(const V3& a) const { return jy * hn::NegMulAdd(sy, a.z, a.y); }
};

/** Four floats, without a loop: at -O2 the compiler leaves short ones rolled. */
HWY_INLINE void copyQuad(const float* from, float* to) {
    std::memcpy(to, from, 16);
}

HWY_INLINE V3 load3(const float* fields) {
    const D d;
    return {hn::Load(d, fields), hn::Load(d, fields + kGroupSplats), hn::Load(d, fields + 2 * kGroupSplats)};
}

HWY_INLINE V3 turn(const ProjectView& c, const V3& a) {
    const float* r = c.rotation;
    return {dot({set(r[0]), set(r[1]), set(r[2])}, a), dot({set(r[3]), set(r[4]), set(r[5])}, a),
            dot({set(r[6]), set(r[7]), set(r[8])}, a)};
}

HWY_INLINE void staticShape(const ProjectTask& task, const float* fields, Shape& s, Jacobian& j) {
    using namespace static_field;
    const D d;
    const ProjectView& c = *task.view;
    const V3 world = load3(fields + kPosition * kGroupSplats);
    s.restDirection = {world.x - set(c.eye[0]), world.y - set(c.eye[1]), world.z - set(c.eye[2])};
    s.view = turn(c, world);
    s.view = {s.view.x + set(c.translation[0]), s.view.y + set(c.translation[1]), s.view.z + set(c.translation[2])};
    j.at(c, s.view);
    // Rows of J·W in world space, then B = (J·W)·A column by column.
    const float* r = c.rotation;
    V3 row0, row1;
    row0.x = j.row0({set(r[0]), set(r[3]), set(r[6])}), row1.x = j.row1({set(r[0]), set(r[3]), set(r[6])});
    row0.y = j.row0({set(r[1]), set(r[4]), set(r[7])}), row1.y = j.row1({set(r[1]), set(r[4]), set(r[7])});
    row0.z = j.row0({set(r[2]), set(r[5]), set(r[8])}), row1.z = j.row1({set(r[2]), set(r[5]), set(r[8])});
    const V3 a0 = load3(fields + kAxes * kGroupSplats), a1 = load3(fields + (kAxes + 3) * kGroupSplats),
             a2 = load3(fields + (kAxes + 6) * kGroupSplats);
    const V3 b0 = {dot(row0, a0), dot(row0, a1), dot(row0, a2)}, b1 = {dot(row1, a0), dot(row1, a1), dot(row1, a2)};
    s.varianceX = dot(b0, b0), s.varianceY = dot(b1, b1), s.covariance = dot(b0, b1);
    const V3 minors = {b0.y * b1.z - b0.z * b1.y, b0.z * b1.x - b0.x * b1.z, b0.x * b1.y - b0.y * b1.x};
    s.detB2 = dot(minors, minors);  // Cauchy-Binet: the subtraction a·c − b² loses needles
    s.fade = smoothStep01((s.view.z - set(float(kNearM))) * set(float(1 / (kNearFadeEndM - kNearM))));
    s.opacity = hn::Load(d, fields + kOpacity * kGroupSplats);
    s.cloth = hn::Zero(d);
    s.light = set(1);
    s.valid = s.view.z > set(float(kNearM));
}

HWY_INLINE void boundShape(const ProjectTask& task, const float* fields, Shape& s, Jacobian& j) {
    using namespace bound_field;
    const D d;
    HWY_ALIGN float quads[8][kLanes * 4];
    const uint32_t* indices = reinterpret_cast<const uint32_t*>(fields + kTriangle * kGroupSplats);
    for (size_t lane = 0; lane < kLanes; ++lane) {
        const float* record = reinterpret_cast<const float*>(task.triangles + HWY_MIN(indices[lane], task.triangleCount));
        const auto copy = [&](size_t q) HWY_ATTR { copyQuad(record + 4 * q, &quads[q][4 * lane]); };
        copy(0), copy(1), copy(2), copy(3), copy(4), copy(5), copy(6), copy(7);
    }
    V3 v0, e1, e2, f0, f1, r0, r1, r2;
    V planeDot, valid, light0, light1, light2, pad;
    hn::LoadInterleaved4(d, quads[0], v0.x, v0.y, v0.z, planeDot);
    hn::LoadInterleaved4(d, quads[1], e1.x, e1.y, e1.z, valid);
    hn::LoadInterleaved4(d, quads[2], e2.x, e2.y, e2.z, light0);
    const V u = hn::Load(d, fields + kU * kGroupSplats), v = hn::Load(d, fields + kV * kGroupSplats);
    const auto affine = [&](const V3& o, const V3& a, const V3& b) HWY_ATTR {
        return V3{fma(v, b.x, fma(u, a.x, o.x)), fma(v, b.y, fma(u, a.y, o.y)), fma(v, b.z, fma(u, a.z, o.z))};
    };
    s.view = affine(v0, e1, e2);
    hn::LoadInterleaved4(d, quads[5], r0.x, r0.y, r0.z, pad);
    hn::LoadInterleaved4(d, quads[6], r1.x, r1.y, r1.z, pad);
    hn::LoadInterleaved4(d, quads[7], r2.x, r2.y, r2.z, pad);
    s.restDirection = affine(r0, r1, r2);
    hn::LoadInterleaved4(d, quads[3], f0.x, f0.y, f0.z, light1);
    hn::LoadInterleaved4(d, quads[4], f1.x, f1.y, f1.z, light2);
    j.at(*task.view, s.view);
    const V f00 = j.row0(f0), f01 = j.row0(f1), f10 = j.row1(f0), f11 = j.row1(f1);
    const auto field = [&](uint32_t k) HWY_ATTR { return hn::Load(d, fields + k * kGroupSplats); };
    const V a10 = field(kAxis10), a11 = field(kAxis11), a20 = field(kAxis20), a21 = field(kAxis21);
    const V b00 = fma(a10, f00, a11 * f01), b01 = fma(a20, f00, a21 * f01);
    const V b10 = fma(a10, f10, a11 * f11), b11 = fma(a20, f10, a21 * f11);
    s.varianceX = fma(b00, b00, b01 * b01), s.varianceY = fma(b10, b10, b11 * b11), s.covariance = fma(b00, b10, b01 * b11);
    const V detB = b00 * b11 - b01 * b10;
    s.detB2 = detB * detB;
    s.fade = smoothStep01((s.view.z - set(float(kNearM))) * set(float(1 / (kNearFadeEndM - kNearM))));
    const V distance = hn::Sqrt(dot(s.view, s.view));
    const V gate = smoothStep01(planeDot / (distance * set(float(kGateEnd))));
    s.fade = hn::IfThenElse(field(kSingleFace) > hn::Zero(d), s.fade * gate, s.fade);
    s.opacity = field(kOpacity);
    s.cloth = field(kCloth);
    s.light = fma(v, light2, fma(u, light1, light0));
    s.valid = hn::And(s.view.z > set(float(kNearM)), valid > hn::Zero(d));
}

/** (0.5 + Σ basis·sh)·light, clamped to [0,1]; NaN becomes black. `sh` is the first SH field of the group at this lane. */
template <uint32_t kDegree>
HWY_INLINE V3 colourOf(const V3& direction, const float* sh, V light) {
    const D d;
    const V inverse = set(1) / hn::Sqrt(dot(direction, direction));
    const V x = direction.x * inverse, y = direction.y * inverse, z = direction.z * inverse;
    V3 c = {set(0.5f), set(0.5f), set(0.5f)};
    const auto add = [&](uint32_t k, V basis) HWY_ATTR {
        const float* f = sh + k * 3 * kGroupSplats;
        c.x = fma(basis, hn::Load(d, f), c.x);
        c.y = fma(basis, hn::Load(d, f + kGroupSplats), c.y);
        c.z = fma(basis, hn::Load(d, f + 2 * kGroupSplats), c.z);
    };
    add(0, set(float(kShC0)));
    if constexpr (kDegree >= 1) {
        constexpr float k1 = 0.4886025119029199f;
        add(1, set(-k1) * y), add(2, set(k1) * z), add(3, set(-k1) * x);
    }
    if constexpr (kDegree >= 2) {
        const V xx = x * x, yy = y * y, zz = z * z, xy = x * y, yz = y * z, xz = x * z;
        add(4, set(1.0925484305920792f) * xy), add(5, set(-1.0925484305920792f) * yz);
        add(6, set(0.31539156525252005f) * (zz + zz - xx - yy));
        add(7, set(-1.0925484305920792f) * xz), add(8, set(0.5462742152960396f) * (xx - yy));
        if constexpr (kDegree >= 3) {
            const V three = set(3), fourZz = zz * set(4) - xx - yy;
            add(9, set(-0.5900435899266435f) * y * (three * xx - yy));
            add(10, set(2.890611442640554f) * xy * z);
            add(11, set(-0.4570457994644658f) * y * fourZz);
            add(12, set(0.3731763325901154f) * z * (zz + zz - three * xx - three * yy));
            add(13, set(-0.4570457994644658f) * x * fourZz);
            add(14, set(1.445305721320277f) * z * (xx - yy));
            add(15, set(-0.5900435899266435f) * x * (xx - three * yy));
        }
    }
    const auto clamp01 = [&](V a) HWY_ATTR { return hn::Min(hn::IfThenElseZero(a > hn::Zero(d), a * light), set(1)); };
    return {clamp01(c.x), clamp01(c.y), clamp01(c.z)};
}

template <bool kBound, uint32_t kDegree>
void projectAs(const ProjectTask& task) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const hn::RebindToSigned<D> di;
    const ProjectView& c = *task.view;
    const V zero = hn::Zero(d), one = set(1), kappa = set(c.kappaPx2), nearest = set(0.5f + c.reachPx), farthest = set(0.5f - c.reachPx),
            huge = set(1e30f);
    constexpr uint32_t kFields = groupFields(kBound, kDegree), kShField = kBound ? bound_field::kSh : static_field::kSh;
    BlockVisible& visible = *task.visible;
    auto minKey = hn::Set(du, visible.minKey), maxKey = hn::Set(du, visible.maxKey), tileEntries = hn::Zero(du);

    for (uint32_t step = 0; step < task.groups * (kGroupSplats / kLanes); ++step) {
        const uint32_t splat = task.firstSplat + step * uint32_t(kLanes);
        const size_t offset = size_t(step) * kLanes;
        const float* fields = task.packed + offset / kGroupSplats * (kFields * kGroupSplats) + offset % kGroupSplats;
        Shape s;
        Jacobian j;
        if constexpr (kBound)
            boundShape(task, fields, s, j);
        else
            staticShape(task, fields, s, j);

        const V det = fma(kappa, s.varianceX + s.varianceY + kappa, s.detB2);  // κ² + κ‖B‖² + det(B)²
        const V invDet = one / det;
        s.varianceX = s.varianceX + kappa, s.varianceY = s.varianceY + kappa;
        const V compensation = c.compensated ? hn::Max(set(float(kMinCompensation)), hn::Sqrt(s.detB2 * invDet)) : one;
        const V opacity = s.opacity * compensation * s.fade;
        const V x = fma(set(c.fx), j.slopeX, set(c.cx)), y = fma(set(c.fy), j.slopeY, set(c.cy));

        // A pixel is in the box when one of its samples may be. Comparisons with NaN are false, so everything that is not finite ends here.
        M shown = hn::And(s.valid, hn::And(det > zero, det < set(3e38f)));
        shown = hn::And(shown, hn::And(opacity > set(float(kMinAlpha)), opacity < huge));
        shown = hn::And(shown, hn::And(hn::Abs(x) < huge, hn::Abs(y) < huge));
        const V q = set(2) * hn::Log(d, hn::IfThenElse(shown, opacity * set(255), one));
        const V radiusX = hn::Sqrt(q * s.varianceX), radiusY = hn::Sqrt(q * s.varianceY);
        const V lastX = set(c.width - 1), lastY = set(c.height - 1);
        const V x0 = hn::Max(hn::Ceil(x - radiusX - nearest), zero), x1 = hn::Min(hn::Floor(x + radiusX - farthest), lastX);
        const V y0 = hn::Max(hn::Ceil(y - radiusY - nearest), zero), y1 = hn::Min(hn::Floor(y + radiusY - farthest), lastY);
        shown = hn::And(shown, hn::And(x0 <= x1, y0 <= y1));

        V3 colour = {zero, zero, zero};
        if (!hn::AllFalse(d, shown)) {
            colour = colourOf<kDegree>(s.restDirection, fields + kShField * kGroupSplats, s.light);
            // Clamped to the target first: lanes that are not shown may hold anything.
            const auto tile = [&](V a, V last) HWY_ATTR {
                return hn::BitCast(du, hn::ShiftRight<4>(hn::ConvertTo(di, hn::Min(hn::Max(a, zero), last))));
            };
            static_assert(kTileSizePx == 16);
            const auto tx0 = tile(x0, lastX), tx1 = tile(x1, lastX), ty0 = tile(y0, lastY), ty1 = tile(y1, lastY);
            hn::StoreInterleaved2(hn::Or(tx0, hn::ShiftLeft<16>(ty0)), hn::Or(tx1, hn::ShiftLeft<16>(ty1)), du,
                                  reinterpret_cast<uint32_t*>(task.boxes + splat));
            hn::StoreU(one / s.varianceY, d, task.rowScale + splat);
            const auto oneU = hn::Set(du, 1);
            const auto shownU = hn::RebindMask(du, shown);
            tileEntries = tileEntries + hn::IfThenElseZero(shownU, (tx1 - tx0 + oneU) * (ty1 - ty0 + oneU));
            const auto key = hn::BitCast(du, s.view.z);  // positive floats order like their bits
            minKey = hn::Min(minKey, hn::IfThenElse(shownU, key, minKey)), maxKey = hn::Max(maxKey, hn::IfThenElseZero(shownU, key));
            hn::CompressStore(key, shownU, du, task.keys + visible.count);
            visible.count += uint32_t(hn::CompressStore(hn::Iota(du, task.firstIndex + splat), shownU, du, task.values + visible.count));
        }

        HWY_ALIGN float records[4][kLanes * 4];
        hn::StoreInterleaved4(x, y, s.varianceY * invDet, hn::Neg(s.covariance * invDet), d, records[0]);
        hn::StoreInterleaved4(s.varianceX * invDet, hn::IfThenElseZero(shown, opacity), colour.x, colour.y, d, records[1]);
        hn::StoreInterleaved4(colour.z, radiusX, radiusY, s.view.z, d, records[2]);
        hn::StoreInterleaved4(compensation, s.fade, hn::BitCast(d, hn::Iota(du, task.firstIndex + splat)), s.cloth, d, records[3]);
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
    static constexpr Kernel kKernels[2][4] = {{projectAs<false, 0>, projectAs<false, 1>, projectAs<false, 2>, projectAs<false, 3>},
                                              {projectAs<true, 0>, projectAs<true, 1>, projectAs<true, 2>, projectAs<true, 3>}};
    kKernels[task.triangles != nullptr][task.shDegree](task);
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
