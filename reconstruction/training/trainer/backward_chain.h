// SPDX-License-Identifier: Apache-2.0
// Backward pass of one bound splat: from the gradient on its screen record to the gradients on its parameters and its triangle
// (docs/reference/binding.md, docs/reference/footprint.md), by the formulas of backward.inl. The trainer instantiates the templates in
// float, the gradient tests in double.
//
//   (x, y, conic, opacity', colour) ─► B, z ─► A1, A2, centre ─► (F, φ, ln s, u, v) and the triangle's corners
//
// The forward pass stores its intermediate values in a ForwardRecord, so nothing is projected a second time.
// Every path is differentiated, also those through the view direction (SH), the gate and the polar rotation. The gradient of a rigid
// motion of all vertices therefore equals that of the opposite camera motion. D⁻¹ of the rest triangle is a constant.
#pragma once

#include <cmath>

#include "sdk/math/binding.h"
#include "sdk/math/projection.h"
#include "sdk/math/sh.h"
#include "sdk/splat/forward_record.h"

namespace dpl {
namespace formula_scope {

using std::atan2;
using std::cos;
using std::sin;

/** backward.inl as C++. */
template <class T>
struct BackwardFormulas : Formulas<T> {
    using real = T;
    using real2 = Vec2<T>;
    using real3 = Vec3<T>;
    using real33 = Mat3<T>;
    using truth = bool;
    using ForwardRecord = dpl::ForwardRecord<T>;
    using TriangleFrame = dpl::TriangleFrame<T>;
    using typename Formulas<T>::Lens;
    using typename Formulas<T>::PlaneStretch;
    using typename Formulas<T>::PosedTriangle;
    using typename Formulas<T>::ShBand1;
    using typename Formulas<T>::ShBand2;
    using typename Formulas<T>::ShBand3;
    using Formulas<T>::boundedStretch;
    using Formulas<T>::determinantOf;
    using Formulas<T>::planeStretch;
    using Formulas<T>::posedTriangle;
    using Formulas<T>::shownStretch;
    using Formulas<T>::stretchYield;
#define DPL_FN static inline
#include "reconstruction/training/trainer/backward.inl"
#undef DPL_FN
};

}  // namespace formula_scope

using formula_scope::BackwardFormulas;

/** ∂loss/∂(screen record of one splat, as blending reads it). x, y in pixels; conicB is the coefficient of dx·dy; opacity is the effective
 *  opacity' = opacity · compensation · gate · nearFade. */
template <class T>
struct ScreenGradient {
    T x = 0, y = 0;
    T conicA = 0, conicB = 0, conicC = 0;
    T opacity = 0;
    Vec3<T> colour{0};
};

/** The parameters of one splat that the backward pass reads. `sh` is borrowed. */
template <class T>
struct SplatParameters {
    Vec2<T> uv{0};
    T opacity = 0;  // linear
    bool singleFace = false;
    uint32_t shDegree = 0;
    const T* sh = nullptr;  // coefficient-major
};

/** ∂loss/∂parameters of one splat. */
template <class T>
struct ParameterGradient {
    Vec2<T> uv{0};
    T phi = 0;
    Vec2<T> logScale{0};  // s·∂loss/∂s: no division, so it stays finite for tiny splats
    T opacity = 0;        // wrt the linear opacity
    T sh[kMaxShCoefficients * 3] = {};
};

/** Gradients summed over the splats of one triangle. finishTriangle() turns them into corner gradients. */
template <class T>
struct TriangleGradient {
    Vec3<T> f0{0}, f1{0};         // wrt the columns of F
    Vec3<T> turn{0};              // wrt an infinitesimal world rotation of the triangle's normal and polar rotation
    Vec3<T> c0{0}, c1{0}, c2{0};  // wrt the corners through splat centres
    Vec3<T> light{0};             // wrt the brightness at the corners
    T shown = 0;                  // wrt TriangleFrame::shown

    TriangleGradient& operator+=(const TriangleGradient& o) {
        f0 += o.f0, f1 += o.f1, turn += o.turn, c0 += o.c0, c1 += o.c1, c2 += o.c2, light += o.light, shown += o.shown;
        return *this;
    }
};

template <class T>
inline typename BackwardFormulas<T>::BackwardView backwardViewOf(const PinholeCamera<T>& c) {
    return {lensOf(c), glm::transpose(c.viewFromWorldRotation)};
}

/** Σ_k weight[k] · ∂basis[k]/∂d at the unit direction d. The caller removes the component along d. */
template <class T>
inline Vec3<T> shBasisGradient(const Vec3<T>& d, uint32_t degree, const T* w) {
    using B = BackwardFormulas<T>;
    Vec3<T> g(0);
    if (degree >= 1) g += B::shBand1Gradient({w[1], w[2], w[3]});
    if (degree >= 2) g += B::shBand2Gradient(d, {w[4], w[5], w[6], w[7], w[8]});
    if (degree >= 3) g += B::shBand3Gradient(d, {w[9], w[10], w[11], w[12], w[13], w[14], w[15]});
    return g;
}

/** Backward pass of one splat that the forward pass drew. `f` is its forward record, `g` the gradient on its screen record. Overwrites
 *  `out` and adds to `triangle`. */
template <class T>
inline void backwardSplat(const typename BackwardFormulas<T>::BackwardView& view, const TriangleFrame<T>& frame,
                          const SplatParameters<T>& splat, const ForwardRecord<T>& f, const ScreenGradient<T>& g, ParameterGradient<T>& out,
                          TriangleGradient<T>& triangle) {
    using B = BackwardFormulas<T>;
    auto world = B::footprintBackward(view, frame, splat.opacity, splat.singleFace, f, {g.x, g.y, g.conicA, g.conicB, g.conicC, g.opacity});
    const auto colour = B::colourBackward(f, g.colour);
    const Vec3<T> direction(f.directionX, f.directionY, f.directionZ);
    T basis[kMaxShCoefficients], weight[kMaxShCoefficients] = {};
    shBasis(direction, splat.shDegree, basis);
    for (uint32_t i = 0; i < shCoefficientCount(splat.shDegree); ++i) {
        for (int ch = 0; ch < 3; ++ch) out.sh[i * 3 + uint32_t(ch)] = basis[i] * colour.unlit[ch];
        weight[i] = splat.sh[i * 3] * colour.unlit.x + splat.sh[i * 3 + 1] * colour.unlit.y + splat.sh[i * 3 + 2] * colour.unlit.z;
    }
    if (splat.shDegree > 0) world = B::directionBackward(world, frame, f, shBasisGradient(direction, splat.shDegree, weight));
    const auto placement = B::placementBackward(frame, f, world, colour.light);
    out.opacity = world.opacity, out.uv = placement.uv, out.phi = placement.phi, out.logScale = placement.logScale;
    triangle.shown += world.shown;
    triangle.f0 += f.a10 * world.axis1 + f.a20 * world.axis2, triangle.f1 += f.a11 * world.axis1 + f.a21 * world.axis2;
    triangle.turn += world.turn;
    triangle.light += colour.light * Vec3<T>(T(1) - splat.uv.x - splat.uv.y, splat.uv.x, splat.uv.y);
    triangle.c0 += (T(1) - splat.uv.x - splat.uv.y) * world.centre;
    triangle.c1 += splat.uv.x * world.centre;
    triangle.c2 += splat.uv.y * world.centre;
}

/** Fills three corner gradients of a drawn triangle (drawnTriangle of bind and now) from the sums over its splats. */
template <class T>
inline void finishTriangle(const TriangleFrame<T>& frame, const RestTriangle<T>& bind, const RestTriangle<T>& now,
                           const TriangleGradient<T>& g, Vec3<T>* corner) {
    const RestInverse<T>&b = bind.inverse, &r = now.valid ? now.inverse : b;
    const auto edges =
        BackwardFormulas<T>::triangleBackward(frame, {b.i00, b.i01, b.i11}, {r.i00, r.i01, r.i11}, {g.f0, g.f1}, g.turn, g.shown);
    corner[0] = g.c0 - edges.d1 - edges.d2;
    corner[1] = g.c1 + edges.d1;
    corner[2] = g.c2 + edges.d2;
}

}  // namespace dpl
