// SPDX-License-Identifier: Apache-2.0
// Level of detail: which splats are left out first, how many splats a density draws, and one budget for several subjects.
#include "sdk/visibility/detail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "sdk/format/spatial_order.h"
#include "sdk/format/splat_codec.h"
#include "sdk/format/splat_detail.h"
#include "sdk/math/projection.h"
#include "tests/reference/random_avatar.h"

namespace dpl {
namespace {

struct Subject {
    AvatarData avatar;
    CodedSplats splats;
    DetailSubject subject;
    explicit Subject(AvatarData a) : avatar(std::move(a)), splats(*codeSplats(avatar.mesh, avatar.splats)) {
        measureDetail(avatar, splats);
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
    void forGroups(Body&& body) const {  // first splat, count, group
        for (size_t g = 0; g < splats.groups.size(); ++g) {
            const SplatChunk& c = splats.chunks[g / 2];
            const uint32_t first = std::min<uint32_t>(c.splatCount, g % 2 * kSplatGroupSize),
                           count = std::min(kSplatGroupSize, c.splatCount - first);
            if (count > 0) body(c.firstSplat + first, count, splats.groups[g]);
        }
    }
    uint64_t drawn(float perM2) const {
        uint64_t sum = 0;
        forGroups([&](uint32_t, uint32_t count, const SplatGroup& g) {
            for (uint32_t rank = 0, most = drawnRanks(keptShare(perM2, g.areaM2)); rank < most; ++rank)
                sum += placeOfRank(rank) < count ? 1 : 0;
        });
        return sum;
    }
};

/** General splats around (0, 1, 0), about a metre across. The last group is not full. */
struct Cloud {
    GeneralDetailSubject subject;
    explicit Cloud(uint32_t seed, uint32_t count = 3005) {
        StaticSplatData splats = randomStaticSplats(seed, count, 0);
        for (Vec3f& p : splats.position) p.y += 1;
        subject = GeneralDetailSubject(measureGroups(splats, spatialOrder(splats.position)), count);
    }
    /** Splats drawn of the groups that reach in front of a camera. */
    uint64_t drawn(const GeneralDetail& detail, std::span<const Cameraf> views) const {
        uint64_t sum = 0;
        for (size_t g = 0; g < subject.groups().size(); ++g) {
            const GeneralGroup& group = subject.groups()[g];
            bool ahead = false;
            for (const Cameraf& view : views)
                for (int corner = 0; corner < 8; ++corner)
                    ahead |=
                        view.toView(group.middle + group.reach * Vec3f(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)).z >=
                        float(kNearM);
            const float pixelM = detail.pixelM(group.middle, group.reach);
            const uint32_t count = std::min<uint32_t>(kSplatGroupSize, subject.splatCount() - uint32_t(g) * kSplatGroupSize);
            for (uint32_t rank = 0, most = ahead ? drawnRanks(keptShare(detail.perPixel, group.detail.areaM2 / (pixelM * pixelM))) : 0;
                 rank < most; ++rank)
                sum += placeOfRank(rank) < count ? 1 : 0;
        }
        return sum;
    }
};

TEST(SplatGroups, everyPrefixOfTheRanksIsSpreadEvenly) {
    std::vector<bool> taken(kSplatGroupSize, false);
    for (uint32_t rank = 0; rank < kSplatGroupSize; ++rank) {
        ASSERT_LT(placeOfRank(rank), kSplatGroupSize);
        ASSERT_FALSE(taken[placeOfRank(rank)]);
        taken[placeOfRank(rank)] = true;
        // The longest gap is at most twice that of an even spread.
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
            surface += 0.5 * double(glm::length(glm::cross(s.avatar.mesh.restPositions[t.y] - s.avatar.mesh.restPositions[t.x],
                                                           s.avatar.mesh.restPositions[t.z] - s.avatar.mesh.restPositions[t.x])));
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
        for (const SplatGroup& g : s.splats.groups)
            EXPECT_TRUE(std::isfinite(g.areaM2) && std::isfinite(g.gain) && g.enough >= 0 && g.enough <= 1);
        for (const float perM2 : {0.0f, 1.0f, 1e30f}) {
            EXPECT_TRUE(s.subject.largestGrowth(perM2) >= 1 && std::isfinite(s.subject.largestGrowth(perM2))) << perM2;
            const double most = s.subject.drawnAtMost(double(perM2));
            EXPECT_TRUE(most >= 0 && most <= s.splats.count()) << most;
        }
        const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 100, 100, 120);
        std::vector<Mat3x4f> joints;
        jointTransforms(s.avatar.joints, s.rest(), joints);
        DetailMember member{.avatar = &s.subject, .worldFromRest = joints, .views = {&camera, 1}};
        EXPECT_LE(chooseDetails({4, 100}, {&member, 1}).drawn, s.splats.count());
        EXPECT_TRUE(member.pixelM > 0 && std::isfinite(member.pixelM));
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

TEST(SplatGroups, faceAndHandsKeepMoreWithinTheSameNumber) {
    const Subject plain(4, 9);
    for (const auto& [bone, times] :
         {std::pair{"head", 3.0f}, {"rightEye", 3.0f}, {"rightHand", 2.0f}, {"leftLittleDistal", 2.0f}, {"chest", 1.0f}}) {
        AvatarData avatar = plain.avatar;
        avatar.joints[1].humanoidBone = bone;
        for (auto& w : avatar.mesh.jointWeights)
            w = w[1] > 127 ? glm::u8vec4(0, 255, 0, 0) : glm::u8vec4(255, 0, 0, 0);  // each on one joint
        for (auto& j : avatar.mesh.jointIndices) j = {0, 1, 60000, 60000};           // joints of weight 0 are not looked up
        const Subject s(std::move(avatar));
        double area = 0, plainArea = 0;
        float least = INFINITY, most = 0;
        for (size_t g = 0; g < s.splats.groups.size(); ++g) {
            const SplatChunk& c = s.splats.chunks[g / 2];
            const uint32_t before = std::min<uint32_t>(c.splatCount, g % 2 * kSplatGroupSize),
                           count = std::min(kSplatGroupSize, c.splatCount - before);
            if (count == 0) continue;
            area += double(s.splats.groups[g].areaM2) * count, plainArea += double(plain.splats.groups[g].areaM2) * count;
            const float ratio = s.splats.groups[g].areaM2 / plain.splats.groups[g].areaM2;
            least = std::min(least, ratio), most = std::max(most, ratio);
            EXPECT_EQ(s.splats.groups[g].gain, plain.splats.groups[g].gain);
            EXPECT_EQ(s.splats.groups[g].enough, plain.splats.groups[g].enough);
        }
        EXPECT_NEAR(area / plainArea, 1, 1e-5) << bone;
        if (times == 1) {
            EXPECT_EQ(least, 1) << bone;
            EXPECT_EQ(most, 1) << bone;
        } else {
            EXPECT_NEAR(double(most / least), double(times), 0.02) << bone;
        }
        EXPECT_EQ(s.drawn(INFINITY), s.splats.count());
    }
}

TEST(SplatGroups, ofGeneralSplatsStandForTheSurfaceTheyLieOn) {
    // A square of 2 m with a splat every 2 cm.
    StaticSplatData flat;
    for (int i = 0; i < 10000; ++i) {
        flat.position.emplace_back(0.02f * float(i % 100), 0.02f * float(i / 100), 1),
            flat.rotation.emplace_back(glm::normalize(Quatf(1, 0.2f, 0, 0.1f)));
        flat.scaleM.emplace_back(1e-4f), flat.opacity.push_back(0.5f), flat.sh.insert(flat.sh.end(), {1, 1, 1});
    }
    double area = 0;
    const std::vector<GeneralGroup> groups = measureGroups(flat, spatialOrder(flat.position));
    for (size_t g = 0; g < groups.size(); ++g)
        area += double(groups[g].detail.areaM2) * std::min<double>(kSplatGroupSize, 10000 - double(g) * kSplatGroupSize);
    EXPECT_EQ(groups.size(), 79u);
    EXPECT_GT(area, 3.9);
    EXPECT_LT(area, 8);  // the Morton curve jumps, so some groups lie in two places and count as larger
    // Large splats in one place stand for their own size.
    StaticSplatData one = flat;
    std::fill(one.position.begin(), one.position.end(), Vec3f(0));
    std::fill(one.scaleM.begin(), one.scaleM.end(), Vec3f(0.5f, 0.2f, 0));
    const SplatGroup large = measureGroups(one, spatialOrder(one.position))[3].detail;
    EXPECT_NEAR(double(large.areaM2) * kSplatGroupSize, 12 * 0.5 * 0.2, 1e-5);
    EXPECT_TRUE(large.enough > 0 && large.enough < 0.2f) << "128 in one place, of which a few are enough: " << large.enough;
    // Numbers that are not finite, and invisible splats, still give finite groups.
    one.position[7].x = INFINITY, one.scaleM[9].y = NAN;
    for (const GeneralGroup& g : measureGroups(one, spatialOrder(one.position)))
        EXPECT_TRUE(std::isfinite(g.detail.areaM2) && std::isfinite(g.detail.gain) && std::isfinite(g.detail.enough));
    std::fill(one.opacity.begin(), one.opacity.end(), 0.0f);
    for (const GeneralGroup& g : measureGroups(one, spatialOrder(one.position))) EXPECT_EQ(g.detail.areaM2, 0);
}

TEST(Detail, theSumOfGeneralSplatsIsNeverBelowWhatIsDrawnAndMovesWithoutSteps) {
    Cloud cloud(2);
    for (const float distanceM : {0.1f, 1.0f, 4.0f, 20.0f}) {
        const Cameraf pair[2] = {lookAt({0, 1, distanceM}, {0, 1, -9}, 200, 200, 240),
                                 lookAt({0.1f, 1, distanceM}, {1, 1, -9}, 200, 200, 240)};
        cloud.subject.look(pair);
        double before = 0;
        for (double perPixel = 1e-4; perPixel < 1e4; perPixel *= 1.1) {
            const double most = cloud.subject.drawnAtMost(perPixel),
                         drawn = double(cloud.drawn(cloud.subject.detail(float(perPixel)), pair));
            EXPECT_GE(most + 1e-6, drawn) << distanceM << " " << perPixel;
            EXPECT_GE(most, before);
            if (distanceM > 3) {
                EXPECT_LE(most, 1.03 * drawn + double(cloud.subject.groups().size() + kSplatGroupSize)) << distanceM << " " << perPixel;
            }
            before = most;
        }
        EXPECT_EQ(cloud.subject.drawnAtMost(INFINITY), cloud.subject.splatCount());
        if (distanceM > 3) {
            EXPECT_EQ(cloud.subject.drawnAtMost(1e9), cloud.subject.splatCount());
        }
    }
    // A camera that moves through the cloud until all of it is behind.
    const auto largestStep = [&](float stepM) {
        double largest = 0, before = -1;
        for (float z = 4; z > -4; z -= stepM) {
            const Cameraf view = lookAt({0, 1, z}, {0, 1, -9}, 200, 200, 240);
            cloud.subject.look({&view, 1});
            const double most = cloud.subject.drawnAtMost(0.3);
            if (before >= 0) largest = std::max(largest, std::abs(most - before));
            before = most;
        }
        EXPECT_EQ(before, 0) << "all are behind the camera";
        return largest;
    };
    const double coarse = largestStep(0.02f), fine = largestStep(0.005f);
    EXPECT_GT(coarse, 5);
    EXPECT_LT(coarse, 150);
    EXPECT_LT(fine, 0.5 * coarse);
}

TEST(Detail, oneBudgetLowersAllAlike) {
    const Subject near(1, 9), far(2, 9);
    const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 200, 200, 240);
    Pose away = far.rest();
    away.rootTranslation = {0.5f, 0, -6};
    Cloud cloud(1);
    std::vector<Mat3x4f> joints[2];
    jointTransforms(near.avatar.joints, near.rest(), joints[0]), jointTransforms(far.avatar.joints, away, joints[1]);
    DetailMember out[3] = {{&near.subject, joints[0]}, {&far.subject, joints[1]}, {nullptr, {}, &cloud.subject}};
    for (DetailMember& m : out) m.views = {&camera, 1};
    const auto choose = [&](const DetailOptions& options) { return chooseDetails(options, out).drawn; };
    const uint64_t all = near.splats.count() + far.splats.count() + cloud.subject.splatCount();
    EXPECT_EQ(choose({}), all);
    EXPECT_TRUE(out[0].detail.full() && out[1].detail.full() && out[2].generalDetail.full());
    EXPECT_EQ(choose({0, uint32_t(all)}), all);
    EXPECT_TRUE(out[0].detail.full() && out[1].detail.full() && out[2].generalDetail.full()) << "it fits";
    EXPECT_EQ(out[0].pixelM, near.pixelM(near.rest(), {&camera, 1}));
    EXPECT_GT(out[1].pixelM, 2.5 * out[0].pixelM);
    for (const uint32_t budget : {4000u, 1500u, 500u}) {
        for (const float perPixel : {0.0f, 1e9f}) {
            const uint64_t allowed = choose({perPixel, budget});
            EXPECT_LE(allowed, budget);
            EXPECT_GT(allowed, budget * 95 / 100);
            EXPECT_LE(near.drawn(out[0].detail.perM2) + far.drawn(out[1].detail.perM2) + cloud.drawn(out[2].generalDetail, {&camera, 1}),
                      budget);
            EXPECT_LT(out[2].share, 1);
            // All subjects get the same number of splats a pixel.
            EXPECT_NEAR(double(out[0].detail.perM2) * out[0].pixelM * out[0].pixelM / double(out[2].generalDetail.perPixel), 1, 1e-4);
            const double a = double(out[0].detail.perM2) * out[0].pixelM * out[0].pixelM,
                         b = double(out[1].detail.perM2) * out[1].pixelM * out[1].pixelM;
            EXPECT_NEAR(a / b, 1, 1e-4);
        }
    }
    // A budget that is large enough does not change the level of detail; one that is too small leaves one splat a group.
    const uint64_t asked = choose({2, 0});
    const float wanted = out[0].detail.perM2;
    EXPECT_LT(asked, all);
    EXPECT_EQ(choose({2, uint32_t(asked)}), asked);
    EXPECT_EQ(out[0].detail.perM2, wanted);
    EXPECT_GE(choose({2, 1}), near.splats.chunks.size() + far.splats.chunks.size() + cloud.subject.groups().size());
    EXPECT_GE(near.drawn(out[0].detail.perM2), near.splats.chunks.size());
}

TEST(Detail, limitsLowerWhatTheHostWantsAndNeverRaiseIt) {
    const Subject s(1, 9);
    Cloud cloud(1);
    const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 200, 200, 240);
    std::vector<Mat3x4f> joints;
    jointTransforms(s.avatar.joints, s.rest(), joints);
    DetailMember out[2] = {{&s.subject, joints}, {nullptr, {}, &cloud.subject}};
    for (DetailMember& m : out) m.views = {&camera, 1};
    const auto choose = [&](const DetailOptions& options) { return chooseDetails(options, out); };
    const uint64_t all = s.splats.count() + cloud.subject.splatCount();
    EXPECT_EQ(choose({}).wantedKept, all);
    for (const DetailOptions host : {DetailOptions{}, DetailOptions{2, 0}, DetailOptions{0, 3000}, DetailOptions{2, 500}}) {
        const DetailTotals alone = choose(host);
        const float density = out[0].detail.perM2;
        EXPECT_EQ(alone.kept, alone.wantedKept);
        EXPECT_LE(alone.kept, alone.drawn);
        for (const uint32_t limit : {300u, 450u, 600u, 2000u, uint32_t(all), UINT32_MAX}) {
            const DetailTotals both = choose({host.splatsPerPixel, host.splatBudget, {0, limit}});
            EXPECT_EQ(both.wantedKept, alone.wantedKept) << "the limit is no wish";
            EXPECT_EQ(both.wantedDrawn, alone.drawn);
            EXPECT_LE(both.kept, std::min<uint64_t>(alone.kept, limit));
            EXPECT_LE(both.drawn, alone.drawn);
            if (limit >= alone.wantedKept) {
                EXPECT_EQ(out[0].detail.perM2, density) << "a limit that fits changes nothing";
            } else {
                EXPECT_GT(both.kept, limit * 95 / 100);
            }
            const DetailTotals drawn = choose({host.splatsPerPixel, host.splatBudget, {limit, 0}});
            EXPECT_EQ(drawn.wantedDrawn, alone.drawn);
            EXPECT_LE(drawn.drawn, std::min<uint64_t>(alone.drawn, limit));
            EXPECT_GT(drawn.drawn, std::min<uint64_t>(alone.drawn, limit) * 95 / 100);
        }
    }
}

/** A budget counts fading splats as drawn, so one splat less than all makes a third of them fade. A limit of kept splats does not. */
TEST(Detail, aKeptLimitBelowAllSplatsBeginsWithoutAStep) {
    const Subject s(1, 9);
    const Cameraf camera = lookAt({0, 1, 3}, {0, 1, 0}, 200, 200, 240);
    std::vector<Mat3x4f> joints;
    jointTransforms(s.avatar.joints, s.rest(), joints);
    DetailMember out[1] = {{&s.subject, joints}};
    out[0].views = {&camera, 1};
    const auto opacity = [&] {
        double sum = 0;
        s.forGroups([&](uint32_t, uint32_t count, const SplatGroup& g) {
            for (uint32_t rank = 0; rank < kSplatGroupSize; ++rank)
                if (placeOfRank(rank) < count) sum += double(detailWeight(keptShare(out[0].detail.perM2, g.areaM2), rank));
        });
        return sum;
    };
    const double all = s.splats.count();
    double before = all;
    for (double limit = all - 1; limit > 0.1 * all; limit *= 0.98) {
        chooseDetails({0, 0, {0, uint32_t(limit)}}, out);
        EXPECT_LE(opacity(), before);
        EXPECT_GT(opacity(), before - 0.03 * all) << limit;
        before = opacity();
    }
    EXPECT_LT(before, 0.2 * all);
}

TEST(Detail, theNearestPointInTheFinestViewDecides) {
    const Subject s(3);
    const Cameraf front = lookAt({0, 1, 4}, {0, 1, 0}, 200, 200, 240), nearer = lookAt({0, 1, 3.5f}, {0, 1, 0}, 200, 200, 240),
                  wider = lookAt({0, 1, 4}, {0, 1, 0}, 200, 200, 120);
    const double one = s.pixelM(s.rest(), {&front, 1});
    EXPECT_GT(one, (4 - 0.55) / 240 - 0.004);  // the surface is within 0.5 m of (0, 1, 0); the joints' balls reach a little farther
    EXPECT_LT(one, 4.0 / 240);
    const Cameraf pair[2] = {front, nearer}, swapped[2] = {nearer, front};
    EXPECT_EQ(s.pixelM(s.rest(), pair), s.pixelM(s.rest(), {&nearer, 1}));
    EXPECT_EQ(s.pixelM(s.rest(), pair), s.pixelM(s.rest(), swapped));
    EXPECT_NEAR(s.pixelM(s.rest(), {&wider, 1}) / one, 2, 1e-6);
    // A camera inside the avatar, and one that looks away from it: the depth is limited to kDetailNearestM.
    const Cameraf inside = lookAt({0, 1, 0.1f}, {0, 1, 0}, 200, 200, 240), behind = lookAt({0, 1, -4}, {0, 1, -8}, 200, 200, 240);
    EXPECT_NEAR(s.pixelM(s.rest(), {&inside, 1}), kDetailNearestM / 240, 1e-9);
    EXPECT_NEAR(s.pixelM(s.rest(), {&behind, 1}), kDetailNearestM / 240, 1e-9);
    // The pixel size follows the pose without steps.
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
