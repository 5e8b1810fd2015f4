// SPDX-License-Identifier: Apache-2.0
// Frames of the Metal backend on the software device with two kernels: few enough to run in the build with sanitizers, which watches the
// memory of the backend, the device and the executor, in frames that fail as well.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "sdk/backend/metal/mtl_backend.h"
#include "tests/metal/software/software_device.h"

namespace dpl::mtl {
namespace {

constexpr uint32_t kWords = 1000;

/** Fills words, replaces them by their sums, and copies these to where the CPU reads. */
class MetalDeviceFrame : public testing::Test {
protected:
    void open(const SoftwareOptions& options = {}) {
        device_ = std::make_unique<SoftwareDevice>(options);
        auto made = createBackendOn(device_->seam(), /*lent=*/false);
        ASSERT_TRUE(made) << made.error().message;
        backend_ = std::move(*made);
        const auto words = backend_->createBuffer({"words", (kWords + 1) * 4, BufferMemory::Device}),
                   read = backend_->createBuffer({"read", (kWords + 1) * 4, BufferMemory::Readback});
        const auto pipeline = backend_->computePipeline("scan.sums");
        ASSERT_TRUE(words && read && pipeline);
        read_ = *read;
        ComputeStep sums;
        sums.label = "sums", sums.pipeline = *pipeline, sums.groups = 1;
        sums.bindings = {{*words, Access::Update}};
        const gpu::ScanPush push{0, kWords};
        sums.push.size = sizeof push;
        std::memcpy(sums.push.bytes.data(), &push, sizeof push);
        const auto frame = backend_->createFrame({FillStep{"fill", *words, 3}, sums, CopyStep{"copy", *words, *read}}, FrameRun::Submitted);
        ASSERT_TRUE(frame) << frame.error().message;
        frame_ = *frame;
    }
    void TearDown() override {
        backend_.reset();
        device_->finish();
        EXPECT_EQ(device_->takeFaults(), std::vector<std::string>());
        EXPECT_EQ(device_->alive(), std::vector<std::string>());
    }
    /** The exclusive sums of words that are all 3. */
    void expectSums() {
        std::vector<uint32_t> words(kWords + 1);  // the last one is the total
        std::memcpy(words.data(), backend_->mapped(read_).data(), words.size() * 4);
        for (uint32_t i = 0; i <= kWords; ++i) ASSERT_EQ(words[i], 3 * i) << i;
    }

    std::unique_ptr<SoftwareDevice> device_;
    std::unique_ptr<MetalBackend> backend_;
    BufferId read_;
    FrameId frame_;
};

TEST_F(MetalDeviceFrame, computesOverAndOver) {
    open();
    for (int i = 0; i < 5; ++i) {
        const Status ran = backend_->run(frame_);
        ASSERT_TRUE(ran) << ran.error().message;
        expectSums();
    }
}

TEST_F(MetalDeviceFrame, computesAgainAfterARefusalInTheBackground) {
    open();
    device_->failNext(CommandError::NotPermitted, "in the background");
    EXPECT_FALSE(backend_->run(frame_));
    const Status ran = backend_->run(frame_);
    ASSERT_TRUE(ran) << ran.error().message;
    expectSums();
}

TEST_F(MetalDeviceFrame, leavesNothingBehindWhenTheDeviceIsLost) {
    open({.looks = 1000});
    device_->failNext(CommandError::PageFault, "a page fault");
    EXPECT_FALSE(backend_->run(frame_));
    EXPECT_FALSE(backend_->run(frame_)) << "it stays lost";
}

TEST_F(MetalDeviceFrame, leavesNothingBehindWithFramesThatNobodyWaitedFor) {
    open({.looks = 1000});
    for (int i = 0; i < 2; ++i) EXPECT_TRUE(backend_->submit(frame_));
}

}  // namespace
}  // namespace dpl::mtl
