// SPDX-License-Identifier: Apache-2.0
// Single MSL kernels on the CPU: skinning with correctives and the depth of the mesh against the referee, the sort against
// std::stable_sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "apps/reference/reference_mesh.h"
#include "sdk/format/splat_codec.h"
#include "tests/metal/msl_frame.h"
#include "tests/metal/msl_kernels.h"
#include "tests/reference/corrective_cases.h"
#include "tests/unit/render/palette_of.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

TEST(MetalKernels, correctedVerticesAreTheRefereesToAThousandthOfTheirRange) {
    const auto verticesOf = [](const AvatarData& avatar, const Pose& pose, bool skinned) {
        const CodedSplats coded = *codeSplats(avatar.mesh, avatar.splats);
        AvatarRecords records = packAvatar(avatar, coded);
        const Cameraf camera = tubeCamera(16, 16, 0);
        gpu::FrameData frame = packFrame(splatSetOf(avatar, coded), {&camera, 1});
        std::vector<gpu::vec4> palette = paletteOf(avatar, skinned ? pose : Pose::rest(avatar.joints.size()), pose);
        gpu::FrameCounts counts{};
        std::vector<Vec4f> posed(avatar.mesh.restPositions.size());
        run(msl_skin_corrected, groupsFor(posed.size(), gpu::kVertexGroup), 0,
            {&frame, palette.data(), records.correctedVertices.data(), posed.data(), &counts},
            gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), firstLightRow(avatar), 0});
        return posed;
    };
    expectCorrectivesMatch("Metal", verticesOf);
    expectSceneLightMatches("Metal", verticesOf);
}

TEST(MetalKernels, meshDepthMatchesTheReference) {
    const AvatarData avatar = makeTube({.splatsPerTriangle = 1});
    const Pose pose = tubePose(0.9f, 0.4f);
    std::vector<Mat3x4f> joints;
    jointTransforms(avatar.joints, pose, joints);
    AvatarRecords records = packAvatar(avatar, *codeSplats(avatar.mesh, avatar.splats));
    std::vector<gpu::vec4> palette(paletteSize(avatar));
    std::vector<gpu::PosedVertex> posed(avatar.mesh.restPositions.size());
    packPalette(joints, {}, {}, palette);
    for (const float distanceM : {1.6f, 0.2f}) {  // small triangles, and triangles so large that all lanes of a threadgroup share one
        const Cameraf views[2] = {tubeCamera(80, 70, 0.6f, distanceM, -0.03f), tubeCamera(80, 70, 0.6f, distanceM, 0.03f)};
        gpu::FrameData frame = packFrame(splatSetOf(avatar, *codeSplats(avatar.mesh, avatar.splats)), views);
        std::vector<uint32_t> first;
        for (int order = 0; order < 3; ++order) {
            gpu::FrameCounts counts{};
            run(msl_skin, groupsFor(posed.size(), gpu::kVertexGroup), order,
                {&frame, palette.data(), records.vertices.data(), posed.data(), &counts},
                gpu::VertexPush{uint32_t(posed.size()), uint32_t(3 * avatar.joints.size()), 0, 0});
            std::vector<uint32_t> bits(2 * 80 * 70, std::bit_cast<uint32_t>(INFINITY));
            const uint32_t triangles = uint32_t(avatar.mesh.triangles.size());
            run(msl_mesh_depth, groupsFor(triangles, gpu::kVertexGroup), order,
                {&frame, records.triangles.data(), posed.data(), bits.data()}, gpu::MeshDepthPush{triangles, 2, 80, 70});
            if (order == 0) first = bits;
            EXPECT_EQ(bits, first) << "lane order " << order;
        }
        for (size_t v = 0; v < 2; ++v) {
            std::vector<float> depthM(80 * 70);
            for (size_t i = 0; i < depthM.size(); ++i) depthM[i] = std::bit_cast<float>(first[v * depthM.size() + i]);
            std::replace(depthM.begin(), depthM.end(), INFINITY, 0.0f);
            const MeshDepthReport r =
                compareMeshDepth(depthM, referenceSkin(avatar, pose), avatar.mesh.triangles, referenceCamera(views[v]), 0.01, 2e-5);
            EXPECT_EQ(r.wrong, 0u) << r.firstWrong;
            EXPECT_GT(r.covered, depthM.size() / 20);
        }
    }
}

TEST(MetalKernels, sortIsStableAcrossBlocksAndTies) {
    for (uint32_t keys : {1u, 16u, 65536u}) {
        for (int order = 0; order < 3; ++order) {
            gpu::FrameCounts counts{};
            counts.visible = 5001;
            setRuns(counts);
            std::vector<gpu::SortPair> pairs(counts.visible);
            for (uint32_t i = 0; i < counts.visible; ++i) pairs[i] = {(i * 2654435761u >> 7) % keys, i};
            EXPECT_TRUE(sortPairs(pairs, counts, order) == stablySorted(pairs)) << keys << " keys, lane order " << order;
        }
    }
}

}  // namespace
}  // namespace dpl
