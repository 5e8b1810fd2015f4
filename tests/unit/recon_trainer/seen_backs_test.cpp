// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/seen_backs.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

constexpr float kBellM = 0.4f;  // twice the radius of the body inside
constexpr size_t kRing = 56;    // triangles of a ring of the garment

/** Lowest corner of a triangle at rest. */
float lowest(const MeshData& mesh, size_t t) {
    const Triangle& c = mesh.triangles[t];
    return std::min({mesh.restPositions[c.x].y, mesh.restPositions[c.y].y, mesh.restPositions[c.z].y});
}

TEST(SeenBacks, theInsideOfABellShowsUnderItsRimAndNowhereElse) {
    Jobs jobs(2);
    const MeshData bell = dressedBall(6 * kRing, kBellM);
    const std::vector<Pose> rest{Pose::rest(2)};
    const std::vector<uint8_t> seen = seenBacks(twoJoints(), bell, rest, jobs);
    ASSERT_EQ(seen.size(), bell.triangles.size());
    float rim = 1;
    for (size_t t = bell.layers[1].firstTriangle; t < seen.size(); ++t) rim = std::min(rim, lowest(bell, t));
    size_t low = 0, lowSeen = 0;
    for (size_t t = 0; t < seen.size(); ++t) {
        if (t < bell.layers[1].firstTriangle) {
            ASSERT_EQ(seen[t], 0) << "a closed body shows no back";
        } else if (lowest(bell, t) > rim + 0.2f) {
            ASSERT_EQ(seen[t], 0) << "too far up: no view gets there, triangle " << t;
        } else if (lowest(bell, t) < rim + 0.03f) {
            ++low, lowSeen += seen[t];
        }
    }
    std::printf("%zu of %zu triangles at the rim show their back, %d in all\n", lowSeen, low, std::accumulate(seen.begin(), seen.end(), 0));
    EXPECT_GT(lowSeen, low * 9 / 10);
    // Every one of them is drawn from both sides, also those farther from the rim than its two rings.
    const auto flags = triangleFlags(bell.restPositions, bell.triangles, {}, seen, {}),
               without = triangleFlags(bell.restPositions, bell.triangles, {}, {}, {});
    size_t gained = 0;
    for (size_t t = 0; t < seen.size(); ++t) {
        ASSERT_FALSE(seen[t] && (flags[t] & kSplatSingleFace)) << t;
        gained += (without[t] & kSplatSingleFace) && !(flags[t] & kSplatSingleFace);
    }
    EXPECT_GT(gained, kRing) << "the rim's two rings are not all that shows";
}

TEST(SeenBacks, closedClothesAndOneSkinShowNone) {
    Jobs jobs(2);
    const std::vector<Pose> rest{Pose::rest(2)};
    for (const MeshData& mesh : {dressedBall(0, kBellM), ballMesh()}) {
        const auto seen = seenBacks(twoJoints(), mesh, rest, jobs);
        EXPECT_EQ(std::count(seen.begin(), seen.end(), uint8_t(1)), 0);
    }
}

TEST(SeenBacks, aPoseMayOpenMore) {
    Jobs jobs(2);
    const MeshData bell = dressedBall(6 * kRing, kBellM);
    Pose tipped = Pose::rest(2);
    tipped.localRotations[0] = glm::angleAxis(0.8f, Vec3f(1, 0, 0));
    const auto rest = seenBacks(twoJoints(), bell, std::vector<Pose>{Pose::rest(2)}, jobs),
               both = seenBacks(twoJoints(), bell, std::vector<Pose>{Pose::rest(2), tipped}, jobs);
    for (size_t t = 0; t < rest.size(); ++t) EXPECT_GE(both[t], rest[t]);
    EXPECT_GT(std::accumulate(both.begin(), both.end(), 0), std::accumulate(rest.begin(), rest.end(), 0));
}

}  // namespace
}  // namespace dpl::test
