// SPDX-License-Identifier: Apache-2.0
// Mesh depth on the GPU against a ray caster in double precision: random avatars in several poses, and meshes that are hard to rasterise.
#include "apps/reference/reference_mesh.h"
#include "tests/reference/mesh_depth_cases.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/vulkan_image.h"

namespace dpl {
namespace {

/** Draws a frame with mesh depth. splatDepth: with the depth of the splats too. */
std::vector<RenderedView> drawMeshDepth(Renderer& renderer, RenderAvatarId id, const Pose& pose, std::span<const Cameraf> views,
                                        bool splatDepth = false) {
    FrameWants wants;
    wants.depth = splatDepth, wants.meshDepth = true;
    std::vector<RenderedView> out(views.size());
    const Status status = renderer.render(id, pose, views, wants, out);
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    return out;
}

void expectDepth(const char* name, const std::vector<float>& depthM, const AvatarData& avatar, const Pose& pose, const Cameraf& camera,
                 double minCovered, double maxCovered = 1) {
    SCOPED_TRACE(name);
    ASSERT_EQ(depthM.size(), size_t(camera.widthPx) * camera.heightPx);
    // Slack of 2e-5: skinning in float moves vertices by 1e-7 m, and a position in the view of a camera 400 m away has steps of 3e-5 m.
    const MeshDepthReport r =
        compareMeshDepth(depthM, referenceSkin(avatar, pose), avatar.mesh.triangles, referenceCamera(camera), 0.01, 2e-5);
    EXPECT_EQ(r.wrong, 0u) << r.firstWrong;
    EXPECT_GE(double(r.covered), minCovered * double(r.pixels));
    EXPECT_LE(double(r.covered), maxCovered * double(r.pixels));
}

/** An avatar with this mesh on one joint at rest, without splats. */
AvatarData avatarOf(const MeshDepthCase& c) {
    AvatarData a;
    a.name = c.name;
    a.joints = {{"root", -1, Vec3f(0), "hips"}};
    a.mesh.restPositions = c.positions, a.mesh.triangles = c.triangles;
    a.mesh.colours.assign(c.positions.size(), {128, 128, 128, 255});
    a.mesh.jointIndices.assign(c.positions.size(), {0, 0, 0, 0});
    a.mesh.jointWeights.assign(c.positions.size(), {255, 0, 0, 0});
    a.mesh.layers = {{"body", "body", 0, uint32_t(c.positions.size()), 0, uint32_t(c.triangles.size())}};
    a.splats.triangleStart.assign(c.triangles.size() + 1, 0);
    return a;
}

TEST(VulkanMeshDepth, equalsTheReferenceInSeveralPosesAndViews) {
    TestVulkan vulkan;
    DPL_NEED_VULKAN(vulkan);
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        const auto avatar = share(seed % 2 ? makeTube({.seed = seed}) : test::withCorrectives(randomAvatar(seed), seed));
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id) << id.error().message;
        const Pose pose = seed % 2 ? tubePose(0.5f * float(seed), 0.3f) : randomPose(*avatar, seed);
        const Cameraf views[2] = {tubeCamera(80, 72, float(seed), 1.6f, -0.03f), tubeCamera(80, 72, float(seed), 1.6f, 0.03f)};
        const auto pair = drawMeshDepth(*vulkan.renderer, *id, pose, views),
                   again = drawMeshDepth(*vulkan.renderer, *id, pose, views, true);
        for (size_t v = 0; v < 2; ++v) {
            expectDepth("pair", pair[v].meshDepthM, *avatar, pose, views[v], 0.05);
            EXPECT_TRUE(pair[v].depthM.empty());
            EXPECT_EQ(again[v].meshDepthM, pair[v].meshDepthM) << "with the depth of splats, drawn again";
            EXPECT_EQ(again[v].depthM.size(), pair[v].meshDepthM.size());
            const auto alone = drawMeshDepth(*vulkan.renderer, *id, pose, {views + v, 1});
            EXPECT_EQ(alone[0].meshDepthM, pair[v].meshDepthM);
            EXPECT_TRUE(drawOne(*vulkan.renderer, *id, pose, views[v], true).rgba == alone[0].rgba) << "mesh depth must not change colours";
        }
        EXPECT_NE(pair[0].meshDepthM, pair[1].meshDepthM);
        Cameraf canted[2] = {views[0], tubeCamera(80, 72, float(seed) + 0.2f, 1.6f)};
        const auto eyes = drawMeshDepth(*vulkan.renderer, *id, pose, canted);
        for (size_t v = 0; v < 2; ++v) expectDepth("canted pair", eyes[v].meshDepthM, *avatar, pose, canted[v], 0.05);
    }
}

TEST(VulkanMeshDepth, equalsTheReferenceInRandomAndHardCases) {
    TestVulkan vulkan;
    DPL_NEED_VULKAN(vulkan);
    size_t drawn = 0;
    for (const MeshDepthCase& c : meshDepthCases()) {
        const bool finite =
            std::all_of(c.positions.begin(), c.positions.end(), [](const Vec3f& p) { return std::isfinite(p.x + p.y + p.z); });
        if (!finite || c.triangles.empty()) continue;  // renderers refuse such an avatar
        const auto avatar = std::make_shared<const AvatarData>(avatarOf(c));
        auto id = vulkan.renderer->addAvatar(avatar);
        ASSERT_TRUE(id) << c.name << ": " << id.error().message;
        const auto image = drawMeshDepth(*vulkan.renderer, *id, Pose::rest(1), {&c.camera, 1});
        expectDepth(c.name.c_str(), image[0].meshDepthM, *avatar, Pose::rest(1), c.camera, c.minCovered, c.maxCovered);
        vulkan.renderer->removeAvatar(*id);
        ++drawn;
    }
    EXPECT_GT(drawn, 40u);
}

/** From so near, triangles cover more than 64 pixels, and the lanes of a workgroup share each of them. */
TEST(VulkanMeshDepth, isTheSameHundredTimesWithLargeTrianglesToo) {
    TestVulkan vulkan;
    DPL_NEED_VULKAN(vulkan);
    const auto avatar = share(makeTube({.splatsPerTriangle = 1}));
    auto id = vulkan.renderer->addAvatar(avatar);
    ASSERT_TRUE(id) << id.error().message;
    const Cameraf close = tubeCamera(256, 256, 0.3f, 0.3f);
    const std::vector<float> first = drawMeshDepth(*vulkan.renderer, *id, tubePose(0.4f), {&close, 1})[0].meshDepthM;
    expectDepth("close", first, *avatar, tubePose(0.4f), close, 0.5);
    for (int frame = 1; frame < 100; ++frame)
        ASSERT_EQ(drawMeshDepth(*vulkan.renderer, *id, tubePose(0.4f), {&close, 1})[0].meshDepthM, first) << "frame " << frame;
}

TEST(VulkanMeshDepth, generalSplatsHaveNone) {
    TestVulkan vulkan;
    DPL_NEED_VULKAN(vulkan);
    auto id = vulkan.renderer->addSplats(randomStaticSplats(1, 10, 0));
    ASSERT_TRUE(id);
    FrameWants wants;
    wants.meshDepth = true;
    const Cameraf camera = tubeCamera(16, 16, 0);
    const Status status = vulkan.renderer->draw(*id, {}, {&camera, 1}, wants);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
