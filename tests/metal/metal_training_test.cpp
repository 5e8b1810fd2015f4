// SPDX-License-Identifier: Apache-2.0
// How the engine for Metal opens. What it computes is tested as the engine for Vulkan is (tests/unit/recon_gpu_training).
#include <gtest/gtest.h>

#include "reconstruction/training/gpu/metal_engine.h"
#include "reconstruction/training/gpu/open_engine.h"
#include "tests/metal/software/software_device.h"
#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl {
namespace {

TEST(MetalTraining, opensADeviceThatComputesAsTheCpuDoes) {
    const auto engine = openTrainingEngine({.name = {}, .allowEmulated = true});
    ASSERT_TRUE(engine) << engine.error().message;
    EXPECT_EQ((*engine)->name(), mtl::SoftwareDevice::shared().seam()->name());
    EXPECT_EQ(mtl::SoftwareDevice::shared().takeFaults(), std::vector<std::string>());
}

TEST(MetalTraining, takesNoDeviceOfAnotherNameAndNoneThatTheCpuPlays) {
    const auto other = openTrainingEngine({.name = "GeForce", .allowEmulated = true}), emulated = openTrainingEngine({});
    ASSERT_FALSE(other || emulated);
    EXPECT_EQ(other.error().code, Code::Unsupported);
    EXPECT_NE(other.error().message.find("GeForce"), std::string::npos) << other.error().message;
    EXPECT_EQ(emulated.error().code, Code::Unsupported);
}

/** After a few steps on a device that runs threads and threadgroups in an order. */
std::vector<float> trainedColours(int laneOrder) {
    mtl::SoftwareDevice device({.laneOrder = laneOrder});
    auto engine = createMetalEngine(device.seam());
    if (!engine) return {};
    Jobs jobs(1);
    auto trainer = CoOptimiser::create(test::toyScene(jobs, 4, 0, 0, 40), test::toySettings(8), jobs, engine->get());
    if (!trainer || !(*trainer)->run(4)) return {};
    EXPECT_EQ(device.takeFaults(), std::vector<std::string>());
    return (*trainer)->result().splats.sh;
}

TEST(MetalTraining, theOrderOfThreadsChangesNoByte) {
    const std::vector<float> forward = trainedColours(0);
    ASSERT_FALSE(forward.empty());
    EXPECT_EQ(trainedColours(1), forward) << "backward";
    EXPECT_EQ(trainedColours(2), forward) << "shuffled";
}

TEST(MetalTraining, aFaultOfTheDeviceEndsItWithASentenceAndLeavesNothingBehind) {
    mtl::SoftwareDevice device;
    {
        auto engine = createMetalEngine(device.seam());
        ASSERT_TRUE(engine) << engine.error().message;
        Jobs jobs(1);
        auto trainer = CoOptimiser::create(test::toyScene(jobs, 4, 0, 0, 24), test::toySettings(8), jobs, engine->get());
        ASSERT_TRUE(trainer) << trainer.error().message;
        ASSERT_TRUE((*trainer)->run(1));
        device.failNext(mtl::CommandError::PageFault, "a page fault");
        const Status ran = (*trainer)->run(1);
        ASSERT_FALSE(ran);
        EXPECT_EQ(ran.error().code, Code::Device);
        EXPECT_NE(ran.error().message.find("a page fault"), std::string::npos) << ran.error().message;
        EXPECT_FALSE((*trainer)->run(1)) << "it stays lost";
    }
    device.finish();
    EXPECT_EQ(device.takeFaults(), std::vector<std::string>());
    EXPECT_EQ(device.alive(), std::vector<std::string>());
}

}  // namespace
}  // namespace dpl
