// Level of detail: which splats go first, how many splats a density draws, and one budget for several avatars.
#include "sdk/avatar/detail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "tests/reference/random_avatar.h"

namespace dpl {
namespace {

struct Subject {
    AvatarData avatar;
    CodedSplats splats;
    DetailSubject subject;
    explicit Subject(AvatarData a) : avatar(std::move(a)), splats(*codeSplats(avatar.mesh, avatar.splats)) {
        measureGroups(avatar.mesh, splats);
        subject = DetailSubject(avatar, splats);
    }
    explicit Subject(uint32_t seed, uint32_t perTriangle = 5) : Subject(randomAvatar(seed, 9, perTriangle, 1)) {}
    Pose rest() const { return Pose::rest(avatar.joints.size()); }
    double pixelM(const Pose& pose, std::span<const Cameraf> views) const {
        std::vector<Mat3x4f> transforms;
        jointTransforms(avatar.joints, pose, transforms);
        return subject.finestPixelM(transforms, views);
    }
    template <class Body>
    void forGroups(Body&& body) const {   // first splat, count, group
        for (size_t g = 0; g < splats.groups.size(); ++g) {
            const SplatChunk& c = splats.chunks[g / 2];
            const uint32_t first = std::min<uint32_t>(c.splatCount, g % 2 * kSplatGroupSize), count = std::min(kSplatGroupSize, c.splatCount - first);
            if (count > 0) body(c.firstSplat + first, count, splats.groups[g]);
        }
    }
    uint64_t drawn(float perM2) const {
        uint64_t sum = 0;
        forGroups([&](uint32_t, uint32_t count, const SplatGroup& g) { 
            for (uint32_t rank = 0, most = drawnRanks(keptShare(perM2, g.areaM2)); rank < most; ++rank) sum += placeOfRank(rank) < count ? 1 : 0;
        });
        return sum;
    }
};

TEST(SplatGroups, everyPrefixOfTheRanksIsSpreadEvenly) {
    std::vector<bool> taken(kSplatGroupSize, false);
    for (uint32_t rank = 0; rank < kSplatGroupSize; ++rank) {
        ASSERT_LT(placeOfRank(rank), kSplatGroupSize);
        ASSERT_FALSE(taken[placeOfRank(rank)]);
        taken[placeOfRank(rank)] = true;
        // No gap is more than twice as long as it must be.
        uint32_t gap = 0, longest = 0;
        for (const bool t : taken) gap = t ? 0 : gap + 1, longest = std::max(longest, gap);
        EXPECT_LE(longest + 1, 2 * kSplatGroupSize / (rank + 1)) << rank;
    }
}

TEST(SplatGroups, standForTheWholeSurfaceTogether) {
    for (uint32_t perTriangle : {1u, 5u, 7u}) {
        const Subject s(perTriangle, perTriangle);
        double area = 0, surface = 0;
        s.forGroups([&](uint32_t, uint32_t count, const SplatGroup& g) {
            EXPECT_TRUE(g.areaM2 > 0 && g.gain >= 0 && g.gain <= 1 && g.enough >= 0 && g.enough <= 1) << g.gain << " " << g.enough;
            area += double(g.areaM2) * count;
        });
        for (const Triangle& t : s.avatar.mesh.triangles)
            surface += 0.5 * double(glm::length(glm::cross(s.avatar.mesh.restPositions[t.y] - s.avatar.mesh.restPositions[t.x], s.avatar.mesh.restPositions[t.z] - s.avatar.mesh.restPositions[t.x])));
        EXPECT_NEAR(area / surface, 1, 1e-4) << "every triangle carries splats";
    }
}

TEST(SplatGroups, nothingVisibleNothingBound) {
    AvatarData invisible = randomAvatar(3, 6, 4, 0);
    std::fill(invisible.splats.opacity.begin(), invisible.splats.opacity.end(), 0.0f);
    AvatarData flat = randomAvatar(4, 6, 4, 0);
    std::fill(flat.mesh.restPositions.begin(), flat.mesh.restPositions.end(), Vec3f(1, 2, 3));
    AvatarData none = randomAvatar(5, 6, 0, 0);
    for (const AvatarData& avatar : {invisible, flat, none}) {
        const Subject s(avatar);
        for (const SplatGroup& g : s.splats.groups) EXPECT_TRUE(std::isfinite(g.areaM2) && std::isfinite(g.gain) && g.enough >= 0 && g.enough <= 1);
        for (const float perM2 : {0.0f, 1.0f, 1e30f}) {
            EXPECT_TRUE(s.subject.largestGrowth(perM2) >= 1 && std::isfinite(s.subject.largestGrowth(perM2))) << perM2;
            const double most = s.subject.drawnAtMost(double(perM2));
            EXPECT_TRUE(most >= 0 && most <= s.splats.count()) << most;
        }
        const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 100, 100, 120);
        DetailMember member{&s.subject};
        member.pixelM = s.pixelM(s.rest(), {&camera, 1});
        EXPECT_TRUE(member.pixelM > 0 && std::isfinite(member.pixelM));
        EXPECT_LE(chooseDetails({4, 100}, {&member, 1}), s.splats.count());
    }
}

TEST(Detail, theCurveIsNeverBelowWhatIsDrawnAndRisesWithoutSteps) {
    const Subject s(1, 6);
    double before = 0;
    for (double perM2 = 0.1; perM2 < 1e6; perM2 *= 1.03) {
        const double most = s.subject.drawnAtMost(perM2);
        EXPECT_GE(most + 1e-6, double(s.drawn(float(perM2)))) << perM2;
        EXPECT_LE(most, 1.25 * double(s.drawn(float(perM2))) + double(s.splats.groups.size())) << perM2;
        EXPECT_GE(most, before);
        EXPECT_LE(most - before, 0.031 * double(s.splats.count()) + 0.04 * before + (before == 0 ? 1e9 : 0));
        before = most;
    }
    EXPECT_EQ(s.subject.drawnAtMost(INFINITY), s.splats.count());
    EXPECT_EQ(s.drawn(INFINITY), s.splats.count());
    EXPECT_EQ(s.subject.largestGrowth(INFINITY), 1);
    EXPECT_GT(s.subject.largestGrowth(1), 1.2f);
}

TEST(Detail, oneBudgetLowersAllAlike) {
    const Subject near(1, 9), far(2, 9);
    const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 200, 200, 240);
    Pose away = far.rest();
    away.rootTranslation = {0.5f, 0, -6};
    const DetailSubject general(100);   // splats without a level of detail
    std::vector<Mat3x4f> joints[2];
    jointTransforms(near.avatar.joints, near.rest(), joints[0]), jointTransforms(far.avatar.joints, away, joints[1]);
    DetailMember out[3] = {{&near.subject, joints[0]}, {&far.subject, joints[1]}, {&general}};
    const auto choose = [&](const DetailOptions& options) { return chooseDetails(options, {&camera, 1}, out); };
    const uint64_t all = near.splats.count() + far.splats.count() + 100;
    EXPECT_EQ(choose({}), all);
    EXPECT_TRUE(out[0].detail.full() && out[1].detail.full());
    EXPECT_EQ(choose({0, uint32_t(all)}), all);
    EXPECT_TRUE(out[0].detail.full() && out[1].detail.full()) << "it fits";
    EXPECT_EQ(out[0].pixelM, near.pixelM(near.rest(), {&camera, 1}));
    EXPECT_GT(out[1].pixelM, 2.5 * out[0].pixelM);
    for (const uint32_t budget : {2000u, 1000u, 300u}) {
        for (const float perPixel : {0.0f, 1e9f}) {
            const uint64_t allowed = choose({perPixel, budget});
            EXPECT_LE(allowed, budget);
            EXPECT_GT(allowed, budget * 95 / 100);
            EXPECT_LE(near.drawn(out[0].detail.perM2) + far.drawn(out[1].detail.perM2) + 100, budget);
            EXPECT_TRUE(out[2].detail.full());
            EXPECT_EQ(out[2].share, 1);
            // As many splats a pixel on both.
            const double a = double(out[0].detail.perM2) * out[0].pixelM * out[0].pixelM, b = double(out[1].detail.perM2) * out[1].pixelM * out[1].pixelM;
            EXPECT_NEAR(a / b, 1, 1e-4);
        }
    }
    // A generous budget changes nothing about the level of detail; one that nothing fits leaves a splat of 128.
    const uint64_t asked = choose({2, 0});
    const float wanted = out[0].detail.perM2;
    EXPECT_LT(asked, all);
    EXPECT_EQ(choose({2, uint32_t(asked)}), asked);
    EXPECT_EQ(out[0].detail.perM2, wanted);
    EXPECT_GT(choose({2, 1}), 100u);
    EXPECT_GE(near.drawn(out[0].detail.perM2), near.splats.chunks.size());
}

TEST(Detail, theNearestPointInTheFinestViewDecides) {
    const Subject s(3);
    const Cameraf front = lookAt({0, 1, 4}, {0, 1, 0}, 200, 200, 240), nearer = lookAt({0, 1, 3.5f}, {0, 1, 0}, 200, 200, 240), wider = lookAt({0, 1, 4}, {0, 1, 0}, 200, 200, 120);
    const double one = s.pixelM(s.rest(), {&front, 1});
    EXPECT_GT(one, (4 - 0.55) / 240 - 0.004);   // the surface is within half a metre of (0, 1, 0), its balls a little farther out
    EXPECT_LT(one, 4.0 / 240);
    const Cameraf pair[2] = {front, nearer}, swapped[2] = {nearer, front};
    EXPECT_EQ(s.pixelM(s.rest(), pair), s.pixelM(s.rest(), {&nearer, 1}));
    EXPECT_EQ(s.pixelM(s.rest(), pair), s.pixelM(s.rest(), swapped));
    EXPECT_NEAR(s.pixelM(s.rest(), {&wider, 1}) / one, 2, 1e-6);
    // The camera within the avatar, and the avatar behind it: as near as it gets.
    const Cameraf inside = lookAt({0, 1, 0.1f}, {0, 1, 0}, 200, 200, 240), behind = lookAt({0, 1, -4}, {0, 1, -8}, 200, 200, 240);
    EXPECT_NEAR(s.pixelM(s.rest(), {&inside, 1}), kDetailNearestM / 240, 1e-9);
    EXPECT_NEAR(s.pixelM(s.rest(), {&behind, 1}), kDetailNearestM / 240, 1e-9);
    // Moves with the pose, without steps.
    Pose pose = s.rest();
    double before = one;
    for (int k = 1; k <= 100; ++k) {
        pose.localRotations[1] = glm::angleAxis(0.02f * float(k), Vec3f(1, 0, 0)), pose.rootTranslation.z = 0.005f * float(k);
        const double now = s.pixelM(pose, {&front, 1});
        EXPECT_LT(std::abs(now - before), 0.03 / 240 * 1.5);
        before = now;
    }
    EXPECT_LT(before, one);
}

}  // namespace
}  // namespace dpl
