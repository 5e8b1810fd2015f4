// SPDX-License-Identifier: Apache-2.0
// The types and functions that sdk/math/formulas (see its README) needs, over SIMD lanes, and the formulas compiled with them. Private to
// sdk/splat. Include it once per Highway target, between HWY_BEFORE_NAMESPACE() and HWY_AFTER_NAMESPACE(); therefore it has no guard.
namespace dpl {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

/** One truth value per lane. */
struct truth {
    M mask;
    HWY_INLINE truth() = default;
    HWY_INLINE truth(M m) : mask(m) {}
};
HWY_INLINE truth operator&&(truth a, truth b) {
    return hn::And(a.mask, b.mask);
}
HWY_INLINE truth operator!(truth a) {
    return hn::Not(a.mask);
}

/** One float per lane. */
struct real {
    V v;
    HWY_INLINE real() = default;
    HWY_INLINE real(V lanes) : v(lanes) {}
    HWY_INLINE explicit real(double number) : v(hn::Set(D(), float(number))) {}
};
/** a·b, not yet rounded: adding to it becomes one fused multiply-add where the target has it, independent of -ffp-contract. */
struct product {
    V a, b;
    HWY_INLINE operator real() const { return hn::Mul(a, b); }
};
HWY_INLINE product operator*(real a, real b) {
    return {a.v, b.v};
}
HWY_INLINE real operator+(real a, real b) {
    return hn::Add(a.v, b.v);
}
HWY_INLINE real operator+(product a, real b) {
    return hn::MulAdd(a.a, a.b, b.v);
}
HWY_INLINE real operator+(real a, product b) {
    return hn::MulAdd(b.a, b.b, a.v);
}
HWY_INLINE real operator+(product a, product b) {
    return hn::MulAdd(a.a, a.b, hn::Mul(b.a, b.b));
}
HWY_INLINE real operator-(real a, real b) {
    return hn::Sub(a.v, b.v);
}
HWY_INLINE real operator-(product a, real b) {
    return hn::MulSub(a.a, a.b, b.v);
}
HWY_INLINE real operator-(real a, product b) {
    return hn::NegMulAdd(b.a, b.b, a.v);
}
HWY_INLINE real operator-(product a, product b) {
    return hn::NegMulAdd(b.a, b.b, hn::Mul(a.a, a.b));
}
HWY_INLINE real operator/(real a, real b) {
    return hn::Div(a.v, b.v);
}
HWY_INLINE real operator-(real a) {
    return hn::Neg(a.v);
}
HWY_INLINE truth operator<(real a, real b) {
    return hn::Lt(a.v, b.v);
}
HWY_INLINE truth operator>(real a, real b) {
    return hn::Gt(a.v, b.v);
}
HWY_INLINE truth operator<=(real a, real b) {
    return hn::Le(a.v, b.v);
}
HWY_INLINE real min(real a, real b) {
    return hn::Min(a.v, b.v);
}
HWY_INLINE real max(real a, real b) {
    return hn::Max(a.v, b.v);
}
HWY_INLINE real clamp(real x, real low, real high) {
    return min(max(x, low), high);
}
HWY_INLINE real abs(real x) {
    return hn::Abs(x.v);
}
HWY_INLINE real sqrt(real x) {
    return hn::Sqrt(x.v);
}
HWY_INLINE real log(real x) {
    return hn::Log(D(), x.v);
}
HWY_INLINE real choose(truth condition, real yes, real no) {
    return hn::IfThenElse(condition.mask, yes.v, no.v);
}

struct real2 {
    real x, y;
    HWY_INLINE real2() = default;
    HWY_INLINE real2(real first, real second) : x(first), y(second) {}
};
struct product2 {
    product x, y;
    HWY_INLINE operator real2() const { return {x, y}; }
};
HWY_INLINE product2 operator*(real a, const real2& b) {
    return {a * b.x, a * b.y};
}
HWY_INLINE real2 operator+(const product2& a, const product2& b) {
    return {a.x + b.x, a.y + b.y};
}

struct real3 {
    real x, y, z;
    HWY_INLINE real3() = default;
    HWY_INLINE real3(real first, real second, real third) : x(first), y(second), z(third) {}
};
HWY_INLINE real3 operator+(const real3& a, const real3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HWY_INLINE real3 operator-(const real3& a, const real3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
struct product3 {
    product x, y, z;
    HWY_INLINE operator real3() const { return {x, y, z}; }
};
HWY_INLINE product3 operator*(real a, const real3& b) {
    return {a * b.x, a * b.y, a * b.z};
}
HWY_INLINE real3 operator+(const real3& a, const product3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
HWY_INLINE real dot(const real3& a, const real3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

#define DPL_FN HWY_INLINE
#include "sdk/math/formulas/binding.inl"
#include "sdk/math/formulas/ellipse.inl"
#include "sdk/math/formulas/footprint.inl"
#include "sdk/math/formulas/sh.inl"
#undef DPL_FN

}  // namespace HWY_NAMESPACE
}  // namespace dpl
