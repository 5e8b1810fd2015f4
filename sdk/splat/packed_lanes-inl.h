// SPDX-License-Identifier: Apache-2.0
// Fields of packed groups (packed_layout.h), and the colours of their splats, over SIMD lanes. Private to sdk/splat. Include it behind
// lanes-inl.h, in the same way.
namespace dpl {
namespace HWY_NAMESPACE {

constexpr size_t kLanes = hn::MaxLanes(D());
static_assert(kGroupSplats % kLanes == 0);

HWY_INLINE real load(const float* fields, uint32_t field) {
    return hn::Load(D(), fields + field * kGroupSplats);
}
HWY_INLINE real3 load3(const float* fields, uint32_t field) {
    return {load(fields, field), load(fields, field + 1), load(fields, field + 2)};
}

/** Copies four floats with one memcpy: at -O2 the compiler does not unroll short loops. */
HWY_INLINE void copyQuad(const float* from, float* to) {
    std::memcpy(to, from, 16);
}

/** Loads four floats for each lane: returns the first three and sets w to the fourth. */
HWY_INLINE real3 loadQuad(const float* quad, real& w) {
    real3 a;
    hn::LoadInterleaved4(D(), quad, a.x.v, a.y.v, a.z.v, w.v);
    return a;
}

HWY_INLINE real3 vectorOf(const float* xyz) {
    return {real(xyz[0]), real(xyz[1]), real(xyz[2])};
}

/** sum + Σ basis·sh of one band above 0. direction: unit, rest frame; sh: the first SH field of the group at this lane. */
template <uint32_t kBand>
HWY_INLINE real3 addShBand(real3 sum, const real3& direction, const float* sh) {
    const auto add = [&](uint32_t k, real basis) HWY_ATTR { sum = sum + basis * load3(sh, 3 * k); };
    if constexpr (kBand == 1) {
        const ShBand1 b = shBand1(direction);
        add(1, b.b1), add(2, b.b2), add(3, b.b3);
    }
    if constexpr (kBand == 2) {
        const ShBand2 b = shBand2(direction);
        add(4, b.b4), add(5, b.b5), add(6, b.b6), add(7, b.b7), add(8, b.b8);
    }
    if constexpr (kBand == 3) {
        const ShBand3 b = shBand3(direction);
        add(9, b.b9), add(10, b.b10), add(11, b.b11), add(12, b.b12), add(13, b.b13), add(14, b.b14), add(15, b.b15);
    }
    return sum;
}

/** 0.5 + basis·sh of band 0. */
HWY_INLINE real3 shBand0(const float* sh) {
    const real half(0.5);
    return real3(half, half, half) + real(kShC0) * load3(sh, 0);
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
