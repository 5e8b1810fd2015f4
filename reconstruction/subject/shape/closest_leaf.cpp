// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruction/subject/shape/closest_leaf.cpp"
#include "hwy/foreach_target.h"  // compiles this file once per instruction set; must come before the other Highway headers

#include "hwy/highway.h"

#include "reconstruction/subject/shape/closest_leaf.h"

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kLeafTriangles>;
using V = hn::Vec<D>;

struct Lanes3 {
    V x, y, z;
};
HWY_INLINE Lanes3 minus(const Lanes3& a, const Lanes3& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
/** Products and sums one by one: a fused one would round differently where the processor has it. */
HWY_INLINE V dot(const Lanes3& a, const Lanes3& b) {
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V crossOf(V a, V b, V c, V d) {
    return hn::Sub(hn::Mul(a, b), hn::Mul(c, d));
}

void closestLanes(const ClosestLeaf& leaf, const Vec3f& p, LeafPoints& out) {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    const Lanes3 point{hn::Set(d, p.x), hn::Set(d, p.y), hn::Set(d, p.z)};
    for (size_t i = 0; i < kLeafTriangles; i += hn::Lanes(d)) {
        const auto corner = [&](size_t k) HWY_ATTR {
            return Lanes3{hn::Load(d, leaf.corner[k][0] + i), hn::Load(d, leaf.corner[k][1] + i), hn::Load(d, leaf.corner[k][2] + i)};
        };
        const Lanes3 a = corner(0), b = corner(1), c = corner(2);
        const Lanes3 ab = minus(b, a), ac = minus(c, a), ap = minus(point, a), bp = minus(point, b), cp = minus(point, c);
        const V d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
        const V vc = crossOf(d1, d4, d3, d2), vb = crossOf(d5, d2, d1, d6), va = crossOf(d3, d6, d5, d4);
        const V alongBc = hn::Sub(d4, d3), alongCb = hn::Sub(d5, d6);

        // Inside; a triangle without area takes its first corner, which is near enough.
        const V sum = hn::Add(hn::Add(va, vb), vc);
        const auto hasArea = hn::Gt(sum, zero);
        V wa = hn::IfThenElse(hasArea, hn::Div(va, sum), one), wb = hn::IfThenElseZero(hasArea, hn::Div(vb, sum)),
          wc = hn::IfThenElseZero(hasArea, hn::Div(vc, sum));
        // The regions of edges and corners; an earlier one of the six has the last word.
        const auto take = [&](auto region, V a0, V b0, V c0) HWY_ATTR {
            wa = hn::IfThenElse(region, a0, wa), wb = hn::IfThenElse(region, b0, wb), wc = hn::IfThenElse(region, c0, wc);
        };
        const auto all = [](auto x, auto y, auto z) HWY_ATTR { return hn::And(hn::And(x, y), z); };
        const V bc = hn::Div(alongBc, hn::Add(alongBc, alongCb));
        take(all(hn::Le(va, zero), hn::Ge(alongBc, zero), hn::Ge(alongCb, zero)), zero, hn::Sub(one, bc), bc);
        const V onAc = hn::Div(d2, hn::Sub(d2, d6));
        take(all(hn::Le(vb, zero), hn::Ge(d2, zero), hn::Le(d6, zero)), hn::Sub(one, onAc), zero, onAc);
        take(hn::And(hn::Ge(d6, zero), hn::Le(d5, d6)), zero, zero, one);
        const V onAb = hn::Div(d1, hn::Sub(d1, d3));
        take(all(hn::Le(vc, zero), hn::Ge(d1, zero), hn::Le(d3, zero)), hn::Sub(one, onAb), onAb, zero);
        take(hn::And(hn::Ge(d3, zero), hn::Le(d4, d3)), zero, one, zero);
        take(hn::And(hn::Le(d1, zero), hn::Le(d2, zero)), one, zero, zero);

        const auto blended = [&](V xa, V xb, V xc) HWY_ATTR { return hn::Add(hn::Add(hn::Mul(wa, xa), hn::Mul(wb, xb)), hn::Mul(wc, xc)); };
        const Lanes3 away = minus({blended(a.x, b.x, c.x), blended(a.y, b.y, c.y), blended(a.z, b.z, c.z)}, point);
        hn::Store(wa, d, out.weight[0] + i), hn::Store(wb, d, out.weight[1] + i), hn::Store(wc, d, out.weight[2] + i);
        hn::Store(dot(away, away), d, out.distance2 + i);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(closestLanes);
void closestInLeaf(const ClosestLeaf& leaf, const Vec3f& p, LeafPoints& out) {
    HWY_DYNAMIC_DISPATCH(closestLanes)(leaf, p, out);
}
}  // namespace dpl
#endif
