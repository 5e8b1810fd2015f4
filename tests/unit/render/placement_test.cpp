// SPDX-License-Identifier: Apache-2.0
// Placed subjects on the CPU and on Vulkan with both fills; on Metal: tests/metal/metal_frame_test.cpp.
#include "tests/unit/render/placed_pictures.h"

#include "sdk/render/avatar_upload.h"
#include "sdk/splat/software_renderer.h"
#include "tests/unit/render/vulkan_test_device.h"

namespace dpl {
namespace {

TEST(Placement, movesPointsAndCamerasAlike) {
    const Placement p = turnedPlacement(2.5);
    const Cameraf view = tubeCamera(64, 48, 0.4f, 7), own = p.toOwn(view);
    const Vec3d point(0.2, 1.1, -0.4);
    EXPECT_LT(glm::distance(p.toOwn(p.toWorld(point)), point), 1e-12);
    const Vec3f seen = view.toView(Vec3f(p.toWorld(point)));
    EXPECT_LT(glm::distance(SubjectView(own, 2.5f).toView(Vec3f(point)), seen), 1e-5f) << "the same place, in metres of the world";
    EXPECT_LT(glm::distance(p.toWorld(Vec3d(own.eye())), Vec3d(view.eye())), 1e-5);
}

TEST(Placement, atTheOriginLeavesEveryBitOfACamera) {
    const Cameraf view = tubeCamera(64, 48, 0.4f, 7), own = Placement().toOwn(view);
    EXPECT_EQ(own.viewFromWorldRotation, view.viewFromWorldRotation);
    EXPECT_EQ(own.viewFromWorldTranslation, view.viewFromWorldTranslation);
}

/** What the shaders read: sort depths are those of the world for every subject, and splats reach as much farther as they are larger. */
TEST(Placement, theBlockOfAFrameSortsInTheWorld) {
    const Cameraf view = tubeCamera(64, 48, 0.4f, 7);
    const SplatSet splats{100, 0, 0.3f, true};
    const Placement p = turnedPlacement(2.5);
    const gpu::FrameData standing = packFrame(splats, {&view, 1}), placed = packFrame(splats, {&view, 1}, 1, {}, 1, 0, p);
    const Vec3d point(0.2, 1.1, -0.4), world = p.toWorld(point);
    const auto depth = [](const gpu::FrameData& f, const Vec3d& x) {
        return glm::dot(Vec3d(f.sortAxisX, f.sortAxisY, f.sortAxisZ), x) + double(f.sortOffsetM);
    };
    EXPECT_EQ(standing.sortOffsetM, 0);
    EXPECT_NEAR(depth(placed, point), depth(standing, world), 1e-5);
    EXPECT_EQ(placed.sortStartM, standing.sortStartM);
    EXPECT_EQ(placed.largestGrowth, 2.5f * standing.largestGrowth);
}

TEST(Placement, softwareEqualsAMovedCamera) {
    const auto renderer = createSoftwareRenderer(2);
    expectEqualToAMovedCamera(*renderer);
    expectEqualToAMovedCamera(*renderer, /*withDetail=*/true);
}

TEST(Placement, softwareEqualsScaledNumbers) {
    const auto renderer = createSoftwareRenderer(2);
    expectEqualToScaledNumbers(*renderer);
}

TEST(Placement, softwareSortsInTheWorld) {
    const auto renderer = createSoftwareRenderer(2);
    expectSortedInTheWorld(*renderer);
}

class VulkanPlacement : public testing::TestWithParam<Fill> {};
INSTANTIATE_TEST_SUITE_P(Fill, VulkanPlacement, testing::Values(Fill::Quads, Fill::Tiles),
                         [](const auto& info) { return std::string(info.param == Fill::Tiles ? "Tiles" : "Quads"); });

TEST_P(VulkanPlacement, equalsAMovedCamera) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    expectEqualToAMovedCamera(*vulkan.renderer);
    expectEqualToAMovedCamera(*vulkan.renderer, /*withDetail=*/true);
}

TEST_P(VulkanPlacement, equalsScaledNumbers) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    expectEqualToScaledNumbers(*vulkan.renderer);
}

TEST_P(VulkanPlacement, sortsInTheWorld) {
    TestVulkan vulkan(testVulkanOptions(), GetParam());
    DPL_NEED_VULKAN(vulkan);
    expectSortedInTheWorld(*vulkan.renderer);
}

}  // namespace
}  // namespace dpl
