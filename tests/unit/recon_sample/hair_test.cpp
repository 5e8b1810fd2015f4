// SPDX-License-Identifier: Apache-2.0
// Locks of hair: rooted on the scalp, whole and outside the body in any motion, still when left alone, farther than the head when shaken.
#include <gtest/gtest.h>

#include "reconstruction/subject/sample/hair_swing.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

constexpr double kDurationS = 18.75;

Subject withHair(Hairstyle style, uint64_t seed = 6, uint32_t threads = 2) {
    Jobs jobs(threads);
    return makeSubject(seed, jobs, Bottom::Shorts, style);
}

const Subject& longHaired() {
    static const Subject kSubject = withHair(Hairstyle::Long);
    return kSubject;
}

const LayerData& hairLayer(const Subject& s) {
    return *std::find_if(s.mesh.layers.begin(), s.mesh.layers.end(), [](const LayerData& l) { return l.name == "hair"; });
}

/** Of all locks, in order. */
std::vector<Vec3d> restOf(const HairLocks& hair) {
    std::vector<Vec3d> nodes;
    for (const HairLock& lock : hair.locks)
        for (const LockNode& node : lock.rest) nodes.push_back(node.at);
    return nodes;
}

/** Metres a second, of the fastest node between two sets of nodes a step apart. */
double fastest(const std::vector<Vec3d>& before, const std::vector<Vec3d>& after) {
    double most = 0;
    for (size_t i = 0; i < before.size(); ++i) most = std::max(most, glm::distance(before[i], after[i]) / LockChains::kStepS);
    return most;
}

TEST(HairLocks, standOnTheScalpAndOffIt) {
    const Subject shortHaired = withHair(Hairstyle::Short);
    for (const Subject* s : {&shortHaired, &longHaired()}) {
        const HairLocks& hair = s->hair;
        const LayerData& layer = hairLayer(*s);
        EXPECT_GT(hair.locks.size(), 200u);
        EXPECT_EQ(hair.firstVertex + hair.locks.size() * hair.verticesPerLock(), layer.firstVertex + layer.vertexCount);
        double highest = 0;
        for (const HairLock& lock : hair.locks) {
            const Triangle& f = s->mesh.triangles[lock.rootTriangle];
            Vec3d root(0);
            for (int c = 0; c < 3; ++c) root += double(lock.rootWeights[c]) * Vec3d(s->mesh.restPositions[f[c]]);
            EXPECT_LT(glm::distance(root, lock.rest[0].at), 0.002);
            EXPECT_GE(lock.lengthM, hair.swing() ? 0.20 : 0.02);
            EXPECT_LE(lock.lengthM, hair.swing() ? 0.35 : 0.04);
            highest = std::max(highest, glm::distance(root, lock.rest.back().at));
        }
        EXPECT_GT(highest, hair.swing() ? 0.2 : 0.02) << "else it is a cap";
    }
}

TEST(HairLocks, changeNobodyWithoutThem) {
    const Subject &s = longHaired(), &capped = subject();
    EXPECT_TRUE(capped.hair.locks.empty());
    EXPECT_EQ(s.mesh.layers[0].vertexCount, capped.mesh.layers[0].vertexCount);
    for (uint32_t v = 0; v < s.mesh.layers[0].vertexCount; ++v) ASSERT_EQ(s.mesh.restPositions[v], capped.mesh.restPositions[v]);
    EXPECT_NE(s.name, capped.name);
}

TEST(HairLocks, areTheSameOnAnyNumberOfThreadsAndOthersForAnotherSeed) {
    const Subject one = withHair(Hairstyle::Long, 6, 1), other = withHair(Hairstyle::Long, 7);
    EXPECT_EQ(one.mesh.restPositions, longHaired().mesh.restPositions);
    EXPECT_NE(other.hair.frequencyHz, one.hair.frequencyHz);
    EXPECT_NE(other.hair.damping, one.hair.damping);
}

TEST(HairSwing, keepsLinksWholeAndOutOfTheBodyWhileTheHeadShakes) {
    const Subject& s = longHaired();
    const SampleMotion motion = SampleMotion::dynamicSequence(s.seed, kDurationS, false, /*headShake=*/true);
    HairSwing swing(s, motion);
    double stretch = 0, deepest = 1;
    for (double t = 0.5; t < 12; t += 0.5) {
        const std::vector<LockNode> nodes = swing.at(t);
        const PosedSolids solids(*s.hair.solids, truthTransforms(s.joints, motion.pose(t)));
        for (size_t i = 0; i < nodes.size(); ++i) {
            const size_t inLock = i % s.hair.nodesPerLock;
            if (inLock < 2) continue;  // stiff with the head, in the scalp
            const double linkM = s.hair.locks[i / s.hair.nodesPerLock].linkM();
            stretch = std::max(stretch, std::abs(glm::distance(nodes[i].at, nodes[i - 1].at) / linkM - 1));
            deepest = std::min(deepest, solids.nearest(nodes[i].at).distanceM);
        }
    }
    std::printf("[ HAIR ] links stretched by up to %.4f %%, nodes at least %.2f mm outside\n", 100 * stretch, 1e3 * deepest);
    EXPECT_LT(stretch, 0.01);
    EXPECT_GT(deepest, -0.002);
}

TEST(HairSwing, aShakeMovesTipsFartherThanTheHeadDoes) {
    const Subject& s = longHaired();
    const SampleMotion calm = SampleMotion::dynamicSequence(s.seed, kDurationS),
                       shaken = SampleMotion::dynamicSequence(s.seed, kDurationS, false, true);
    const auto strays = [&](const SampleMotion& motion) {
        HairSwing swing(s, motion);
        double most = 0;
        for (double t = 7; t < 11; t += 0.1) {
            const std::vector<LockNode> nodes = swing.at(t);
            const Mat3x4d head = truthTransforms(s.joints, motion.pose(t))[kHead];
            double mean = 0;
            for (size_t i = 0; i < s.hair.locks.size(); ++i) {
                const Vec3d rigid = transformed(head, s.hair.locks[i].rest.back().at);
                mean += glm::distance(nodes[(i + 1) * s.hair.nodesPerLock - 1].at, rigid) / double(s.hair.locks.size());
            }
            most = std::max(most, mean);
        }
        return most;
    };
    const double most = strays(shaken), without = strays(calm);
    std::printf("[ HAIR ] tips stray from rigid hair by up to %.0f mm in the mean when shaken, %.0f mm otherwise\n", 1e3 * most,
                1e3 * without);
    EXPECT_GT(most, 0.08);
    EXPECT_GT(most, 1.5 * without);
    EXPECT_LT(most, 0.4);
}

TEST(LockChains, comeToRestAndStayFiniteWhateverTheHeadDoes) {
    const Subject& s = longHaired();
    const std::vector<Mat3x4d> still(s.joints.size(), Mat3x4d(1));
    const PosedSolids solids(*s.hair.solids, still);
    LockChains chains(s.hair, restOf(s.hair));
    for (int i = 0; i < 60; ++i) {  // the head leaps by half a metre
        Mat3x4d away(1);
        away[3] = Vec3d(i % 2 ? 0.5 : -0.5, 0, 0);
        chains.step(away, solids);
    }
    for (const Vec3d& p : chains.nodes()) ASSERT_LT(glm::length(p), 5) << "not a number, or far away";
    std::vector<Vec3d> before = chains.nodes();
    chains.step(still[kHead], solids);
    const double shaken = fastest(before, chains.nodes());
    for (double t = 0; t < 8; t += LockChains::kStepS) before = chains.nodes(), chains.step(still[kHead], solids);
    const double left = fastest(before, chains.nodes());
    std::printf("[ HAIR ] fastest node %.2f m/s, %.4f m/s after 8 s\n", shaken, left);
    EXPECT_GT(shaken, 1);
    EXPECT_LT(left, 0.05);
}

}  // namespace
}  // namespace dpl
