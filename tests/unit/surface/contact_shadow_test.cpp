// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/contact_shadow.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/not_finite.h"
#include "tests/unit/surface/shadow_reference.h"

namespace dpl::test {
namespace {

struct Body {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;

    void box(const Vec3f& low, const Vec3f& high) {
        const uint32_t first = uint32_t(positions.size());
        for (int corner = 0; corner < 8; ++corner)
            positions.push_back({corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z});
        for (const Triangle& t : std::initializer_list<Triangle>{{0, 2, 1},
                                                                 {1, 2, 3},
                                                                 {4, 5, 6},
                                                                 {5, 7, 6},
                                                                 {0, 1, 4},
                                                                 {1, 5, 4},
                                                                 {2, 6, 3},
                                                                 {3, 6, 7},
                                                                 {0, 4, 2},
                                                                 {2, 4, 6},
                                                                 {1, 3, 5},
                                                                 {3, 7, 5}})
            triangles.push_back(t + first);
    }
    /** Two feet that stand liftM above the floor, and what is above them. */
    static Body standing(float liftM = 0) {
        Body b;
        b.box({-0.2f, liftM, -0.1f}, {-0.1f, liftM + 0.08f, 0.16f});
        b.box({0.1f, liftM, -0.1f}, {0.2f, liftM + 0.08f, 0.16f});
        b.box({-0.25f, liftM + 0.5f, -0.15f}, {0.25f, liftM + 1.7f, 0.15f});
        return b;
    }
    Body moved(const std::function<Vec3f(Vec3f)>& by) const {
        Body b = *this;
        for (Vec3f& p : b.positions) p = by(p);
        return b;
    }
    ContactShadow shadow(const ShadowFloor& floor = {}) const {
        ContactShadow made;
        ContactShadowCaster().cast(positions, triangles, floor, Vec3d(0, 1, 0), made);
        return made;
    }
};

/** Alpha at a point of the floor, 0 to 1; 0 outside the picture. */
float alphaAt(const ContactShadow& s, const Vec3d& p) {
    const double side = glm::length(s.across), u = glm::dot(p - s.corner, s.across) / (side * side),
                 v = glm::dot(p - s.corner, s.along) / (side * side);
    if (!(u >= 0 && u < 1 && v >= 0 && v < 1)) return 0;
    return float(s.alpha[size_t(v * kShadowSidePx) * kShadowSidePx + size_t(u * kShadowSidePx)]) / 255;
}

Body scattered(uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> at(-0.6f, 0.6f), height(-0.2f, 0.5f), size(-0.25f, 0.25f);
    Body b;
    for (uint32_t t = 0; t < 40; ++t) {
        const Vec3f p(at(random), height(random), at(random));
        for (int corner = 0; corner < 3; ++corner) b.positions.push_back(p + Vec3f(size(random), 0.3f * size(random), size(random)));
        b.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return b;
}

TEST(ContactShadowTest, isThatOfTheReference) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const Body b = seed == 1 ? Body::standing() : scattered(seed);
        const ShadowFloor floor{glm::normalize(Vec3d(seed > 3 ? 0.3 : 0, 1, seed > 4 ? -0.2 : 0)), seed == 6 ? 0.1 : 0.0};
        const ContactShadow fast = b.shadow(floor);
        const std::vector<double> slow = referenceShadow(b.positions, b.triangles, floor.up, fast);
        ASSERT_GT(fast.darkest, 100) << seed;
        // A place within rounding of an edge may count or not: a sixteenth of a pixel's share of its blot. Measured: 1 at most.
        double most = 0;
        for (size_t i = 0; i < fast.alpha.size(); ++i) most = std::max(most, std::abs(fast.alpha[i] - 255 * slow[i]));
        EXPECT_LT(most, 2.5) << seed;
        EXPECT_NEAR(glm::dot(floor.up, fast.corner), floor.height, 1e-9);
        EXPECT_NEAR(glm::dot(floor.up, fast.across), 0, 1e-9);
        EXPECT_NEAR(glm::dot(fast.along, fast.across), 0, 1e-9);
        EXPECT_NEAR(glm::length(fast.along), glm::length(fast.across), 1e-9);
    }
}

TEST(ContactShadowTest, liesBelowTheFeetAndNotBetweenThem) {
    const ContactShadow s = Body::standing().shadow();
    EXPECT_GT(alphaAt(s, {0.15, 0, 0.03}), 0.65f);
    EXPECT_GT(alphaAt(s, {-0.15, 0, 0.03}), 0.65f);
    EXPECT_LT(alphaAt(s, {0, 0, 0.03}), 0.2f);
    EXPECT_GT(alphaAt(s, {0.15, 0, 0.14}), 0.4f);
    EXPECT_GT(alphaAt(s, {0.24, 0, 0.03}), 0.08f);  // it is seen beside the foot, too
    EXPECT_EQ(alphaAt(s, {0.15, 0, -0.4}), 0);
}

TEST(ContactShadowTest, fadesAndWidensAsFeetLeaveTheFloorUntilItIsEmpty) {
    float before = 2;
    for (const float lift : {0.0f, 0.02f, 0.05f, 0.1f, 0.2f, 0.29f}) {
        const float below = alphaAt(Body::standing(lift).shadow(), {0.15, 0, 0.03});
        EXPECT_LT(below, before) << lift;
        before = below;
    }
    EXPECT_LT(before, 0.01f);
    EXPECT_GT(alphaAt(Body::standing(0.08f).shadow(), {0.15, 0, 0.3}), alphaAt(Body::standing().shadow(), {0.15, 0, 0.3}) + 0.005f);
    const ContactShadow air = Body::standing(0.3f).shadow();
    EXPECT_EQ(air.darkest, 0);
    EXPECT_EQ(air.alpha, ContactShadow().alpha);
    EXPECT_NEAR(glm::length(air.across), kShadowLeastM, 1e-6);
    EXPECT_EQ(Body::standing(-3).shadow().darkest, 0);  // the floor is a ceiling
}

TEST(ContactShadowTest, coversAPersonWhoLies) {
    const Body lying = Body::standing().moved([](Vec3f p) { return Vec3f(p.x, 0.15f - p.z, p.y - 0.9f); });
    const ContactShadow s = lying.shadow();
    EXPECT_GT(glm::length(s.across), 2.3);
    EXPECT_GT(alphaAt(s, {0, 0, 0.3}), 0.9f);
    EXPECT_GT(alphaAt(s, {0.2, 0, -0.3}), 0.85f);
    for (uint32_t i = 0; i < kShadowSidePx; ++i)
        for (const size_t edge : {size_t(i), size_t(kShadowSidePx - 1) * kShadowSidePx + i, size_t(i) * kShadowSidePx,
                                  size_t(i) * kShadowSidePx + kShadowSidePx - 1})
            EXPECT_EQ(s.alpha[edge], 0);
}

TEST(ContactShadowTest, keepsThePixelsOfAFootThatStands) {
    const auto step = [](float forwards) {
        Body b;
        b.box({-0.2f, 0, -0.1f}, {-0.1f, 0.08f, 0.16f});
        b.box({0.1f, 0.1f, forwards}, {0.2f, 0.18f, forwards + 0.26f});
        return b.shadow();
    };
    const ContactShadow one = step(0.3f), other = step(0.337f);
    const double pixel = glm::length(one.across) / kShadowSidePx;
    ASSERT_EQ(one.across, other.across);
    const Vec3d shift = (other.corner - one.corner) / pixel;
    EXPECT_NEAR(shift.z, std::round(shift.z), 1e-6);
    EXPECT_NEAR(shift.x, 0, 1e-6);
}

TEST(ContactShadowTest, takesWhatIsNoPerson) {
    Body b = Body::standing();
    EXPECT_EQ(b.moved([](Vec3f p) { return p * 1e9f; }).shadow().darkest, 0);
    EXPECT_EQ(b.moved([](Vec3f) { return Vec3f(kNan); }).shadow().darkest, 0);
    EXPECT_EQ(b.moved([](Vec3f) { return Vec3f(0); }).shadow().darkest, 0);
    EXPECT_EQ(Body().shadow().darkest, 0);
    Body one = b;
    one.positions[0].x = kInfinity;
    EXPECT_EQ(one.shadow().darkest, 0);
    EXPECT_GT(b.moved([](Vec3f p) { return p + Vec3f(90000, 0, 0); }).shadow().darkest, 100);
}

TEST(ContactShadowTest, hasTheSameBytesFromOneCasterThatMadeOthers) {
    ContactShadowCaster caster;
    ContactShadow again;
    for (const float lift : {0.0f, 0.1f, 0.0f}) {
        const Body b = Body::standing(lift);
        caster.cast(b.positions, b.triangles, {}, Vec3d(0), again);
    }
    EXPECT_EQ(again.alpha, Body::standing().shadow().alpha);
}

}  // namespace
}  // namespace dpl::test
