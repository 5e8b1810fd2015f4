// SPDX-License-Identifier: Apache-2.0
// Exports without a gate look as the avatar does with it.
#include "reconstruction/output/package/without_gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/output/package/avatar_drawer.h"
#include "reconstruction/output/package/posed_splats.h"
#include "tests/reference/image_compare.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

/** A tube that is opaque behind (z < 0) and thin in front. A white lining right below its thin front faces inwards, as the inside of a head
 *  below its brows: where it faces a camera the opaque back hides it. */
AvatarData tubeWithALining() {
    AvatarData a = makeTube({.shDegree = 0, .colourSpread = 0.3f});
    SplatData& s = a.splats;
    const uint32_t vertices = uint32_t(a.mesh.restPositions.size()), triangles = uint32_t(a.mesh.triangles.size());
    const auto depthOf = [&](const Triangle& t) {
        return (a.mesh.restPositions[t[0]].z + a.mesh.restPositions[t[1]].z + a.mesh.restPositions[t[2]].z) / 3;
    };
    for (uint32_t v = 0; v < vertices; ++v) {
        const Vec3f p = a.mesh.restPositions[v];
        a.mesh.restPositions.push_back({0.9f * p.x, p.y, 0.9f * p.z});
        a.mesh.colours.push_back(a.mesh.colours[v]);
        a.mesh.jointIndices.push_back(a.mesh.jointIndices[v]), a.mesh.jointWeights.push_back(a.mesh.jointWeights[v]);
    }
    for (uint32_t t = 0; t < triangles; ++t)
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i)
            if (depthOf(a.mesh.triangles[t]) > 0.02f)
                s.flags[i] = kSplatSingleFace, s.opacity[i] = 0.1f;
            else
                s.flags[i] = 0, s.opacity[i] = 0.99f;
    for (uint32_t t = 0; t < triangles; ++t) {
        const Triangle c = a.mesh.triangles[t];
        const bool lining = depthOf(c) > 0.08f && a.mesh.restPositions[c[0]].y > 0.2f && a.mesh.restPositions[c[0]].y < 0.8f;
        a.mesh.triangles.push_back({c[0] + vertices, c[2] + vertices, c[1] + vertices});
        for (uint32_t i = s.triangleStart[t]; lining && i < s.triangleStart[t + 1]; ++i) {
            s.uv.push_back({s.uv[i].y, s.uv[i].x}), s.phi.push_back(s.phi[i]), s.scaleM.push_back(s.scaleM[i]);
            s.opacity.push_back(0.9f), s.flags.push_back(kSplatSingleFace);
            for (int k = 0; k < 3; ++k) s.sh.push_back(1.7f);
        }
        s.triangleStart.push_back(s.count());
    }
    a.mesh.layers[0].vertexCount *= 2, a.mesh.layers[0].triangleCount *= 2;
    return a;
}

double psnrOf(const AvatarData& gated, const StaticSplatData& exported, const Pose& pose, Jobs& jobs) {
    AvatarDrawer drawer(gated, jobs);
    SplatEngine engine(jobs);
    std::vector<float> ours, theirs;
    for (int side = 0; side < 8; ++side) {
        const Cameraf camera = tubeCamera(128, 160, 0.2f + 0.785398f * float(side));
        SplatImage with, without;
        drawer.project(pose, camera).blend(with);
        engine.project(exported, camera, gated.kappaPx2, gated.compensated);
        engine.bin();
        engine.blend(without);
        EXPECT_GT(coverage(with.alpha), 0.1);
        ours.insert(ours.end(), without.rgb.begin(), without.rgb.end()), theirs.insert(theirs.end(), with.rgb.begin(), with.rgb.end());
    }
    return compareImages(ours, theirs).psnrDb;
}

TEST(WithoutGate, whatShowsOnlyFromInsideIsLeftOut) {
    const AvatarData avatar = tubeWithALining();
    const std::vector<Pose> poses = {tubePose(0.1f)};
    Jobs jobs(2);
    const auto made = withoutGate(avatar, poses, jobs);
    ASSERT_TRUE(made);
    const AvatarData& ungated = *made;
    auto before = posedSplats(avatar, poses[0]), after = SplatPoser(ungated, kSunkM).in(poses[0], /*all=*/false);
    ASSERT_TRUE(before && after);
    const double plainDb = psnrOf(avatar, *before, poses[0], jobs), db = psnrOf(avatar, *after, poses[0], jobs);
    std::printf("[  GATE   ] ignored %.1f dB, with factors %.1f dB, %u of %u splats\n", plainDb, db, after->count(), before->count());
    EXPECT_LT(plainDb, 30) << "the lining shows through, or this test proves nothing";
    EXPECT_GT(db, plainDb + 2);  // measured: 3.2
    EXPECT_LT(after->count(), before->count());
    EXPECT_GE(after->count(), 640u * 8) << "all of the outside stays";
}

TEST(WithoutGate, anAvatarWithoutAGateStaysAsItIs) {
    const AvatarData avatar = makeTube({.splatsPerTriangle = 2, .rings = 6, .singleFace = false});
    const std::vector<Pose> poses = {tubePose(0.3f)};
    Jobs jobs(1);
    const auto factors = opacityWithoutGate(avatar, poses, jobs);
    ASSERT_TRUE(factors);
    EXPECT_EQ(*factors, std::vector<float>(avatar.splats.count(), 1));
    EXPECT_EQ(withoutGate(avatar, poses, jobs)->splats.count(), avatar.splats.count());
}

TEST(WithoutGate, factorsDoNotDependOnThreads) {
    const AvatarData avatar = tubeWithALining();
    const std::vector<Pose> poses = {tubePose(0.5f)};
    Jobs one(1), three(3);
    EXPECT_EQ(*opacityWithoutGate(avatar, poses, one), *opacityWithoutGate(avatar, poses, three));
}

}  // namespace
}  // namespace dpl
