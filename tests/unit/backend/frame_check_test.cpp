// SPDX-License-Identifier: Apache-2.0
// Frames that createFrame refuses, on the null backend. The Vulkan backend makes the same check before it records.
#include <gtest/gtest.h>

#include <cmath>

#include "sdk/backend/null/null_backend.h"
#include "shaders/shared/frame.h"

namespace dpl {
namespace {

/** One valid step: compact.args reads block sums, updates counts, pushes ArgsPush. */
struct OneStep {
    std::unique_ptr<Backend> backend;
    BufferId sums, counts;
    ComputeStep step;

    OneStep() {
        auto made = createNullBackend(nullptr);
        EXPECT_TRUE(made);
        backend = std::move(*made);
        sums = *backend->createBuffer({"sums", 64});
        counts = *backend->createBuffer({"counts", 64});
        step.label = "step";
        step.pipeline = *backend->computePipeline("compact.args");
        step.bindings = {{sums, Access::Read}, {counts, Access::Update}};
        step.push.size = sizeof(gpu::ArgsPush);
        step.groups = 1;
    }
    Result<FrameId> create(bool fillSums = true, bool fillCounts = true) {
        std::vector<Step> steps;
        if (fillSums) steps.push_back(FillStep{"fill", sums, 0});
        if (fillCounts) steps.push_back(FillStep{"fill", counts, 0});
        steps.push_back(step);
        return backend->createFrame(std::move(steps));
    }
    void expectRefused(const char* part, bool fillSums = true) {
        auto frame = create(fillSums);
        ASSERT_FALSE(frame) << part;
        EXPECT_NE(frame.error().message.find(part), std::string::npos) << frame.error().message;
        EXPECT_NE(frame.error().message.find("step"), std::string::npos);
    }
};

TEST(FrameCheck, acceptsAValidStep) {
    OneStep s;
    auto frame = s.create();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_TRUE(s.backend->run(*frame));
}

TEST(FrameCheck, refusesAReadOfWhatNothingWrote) {
    OneStep s;
    s.expectRefused("nothing has written", false);
}

TEST(FrameCheck, acceptsALoadTimeWriteInstead) {
    OneStep s;
    const uint32_t zero[4] = {};
    ASSERT_TRUE(s.backend->write(s.sums, 0, std::as_bytes(std::span(zero))));
    EXPECT_TRUE(s.create(false));
}

TEST(FrameCheck, acceptsAReadOfWhatAnEarlierFrameWrites) {
    OneStep s;
    ASSERT_TRUE(s.backend->createFrame({FillStep{"fill", s.sums, 0}}));
    EXPECT_TRUE(s.create(false));
}

TEST(FrameCheck, refusesBindingsThatDifferFromTheShader) {
    {
        OneStep s;
        s.step.bindings.pop_back();
        s.expectRefused("binds 1 buffers");
    }
    {
        OneStep s;
        s.step.bindings[1].access = Access::Read;
        s.expectRefused("another access");
    }
    {
        OneStep s;
        s.step.bindings[0].access = Access::Update;
        s.expectRefused("another access");
    }
    {
        OneStep s;
        s.step.bindings[0].access = Access::Uniform;
        s.expectRefused("not a uniform block");
    }
    {
        OneStep s;
        s.step.bindings[0].buffer = BufferId{99};
        s.expectRefused("does not exist");
    }
    {
        OneStep s;
        s.step.bindings[0].buffer = s.counts;
        s.expectRefused("twice");
    }
    {
        OneStep s;
        s.step.push.size = 8;
        s.expectRefused("pushes 8 bytes");
    }
}

TEST(FrameCheck, refusesImpossibleDispatches) {
    {
        OneStep s;
        s.step.groups = 0;
        s.expectRefused("0 workgroups");
    }
    {
        OneStep s;
        s.step.groups = 70000;
        s.expectRefused("70000 workgroups");
    }
    {
        OneStep s;
        s.step.indirect = {s.counts, 56};
        s.expectRefused("do not fit");
    }
    {
        OneStep s;
        s.step.pipeline = PipelineId{};
        s.expectRefused("no compute pipeline");
    }
}

/** 8 x 4 px in two views with depth. */
struct OneDraw {
    std::unique_ptr<Backend> backend;
    DrawStep draw;
    BufferId buffers[3];

    explicit OneDraw(const DeviceInfo& device = NullOptions().info) {
        auto made = createNullBackend(nullptr, {.info = device});
        EXPECT_TRUE(made);
        backend = std::move(*made);
        const TargetId target = *backend->createTarget({8, 4, 2, true, true});
        draw.label = "draw";
        draw.pipeline = *backend->drawPipeline({"draw.vert.multiview", "draw.frag.depth", 2, true, true});
        draw.target = target;
        for (BufferId& buffer : buffers) {
            buffer = *backend->createBuffer({"buffer", 256});
            draw.bindings.push_back({buffer, Access::Read});
        }
        draw.push.size = sizeof(gpu::DrawPush);
        draw.args = {buffers[0], 0};
    }
    Status create() {
        std::vector<Step> steps;
        for (const BufferId buffer : buffers) steps.push_back(FillStep{"fill", buffer, 0});
        steps.push_back(draw);
        auto frame = backend->createFrame(std::move(steps));
        return frame ? Status() : Status(frame.error());
    }
    void expectRefused(const char* part) {
        const Status status = create();
        ASSERT_FALSE(status) << part;
        EXPECT_NE(status.error().message.find(part), std::string::npos) << status.error().message;
    }
};

TEST(FrameCheck, aFragmentShadersBuffersFollowThoseOfItsVertexShader) {
    OneDraw p;
    p.draw.pipeline = *p.backend->drawPipeline({"draw.vert.multiview", "draw.frag.depth.scene", 2, true, true});
    EXPECT_NE(p.draw.pipeline, *p.backend->drawPipeline({"draw.vert.multiview", "draw.frag.depth", 2, true, true}));
    p.expectRefused("binds 3 buffers");
    const BufferId scene = *p.backend->createBuffer({"scene", 256, BufferMemory::Upload});
    p.draw.bindings.push_back({scene, Access::Write});
    p.expectRefused("another access");
    p.draw.bindings[3].access = Access::Read;
    const Status status = p.create();
    EXPECT_TRUE(status) << status.error().message;
    p.draw.pipeline = *p.backend->drawPipeline({"draw.vert.multiview", "draw.frag.depth", 2, true, true});
    p.expectRefused("binds 4 buffers");
}

TEST(FrameCheck, aDrawAViewMustReachThemAllBeforeTheyAreRead) {
    OneDraw p;
    p.draw.view = 1;
    p.expectRefused("draws view 1 of a target that has 2 at once");
    p.draw.pipeline = *p.backend->drawPipeline({"draw.vert", "draw.frag.depth", 2, false, true});
    p.draw.target = *p.backend->createTarget({8, 4, 2, true, false});
    p.draw.view = 2;
    p.expectRefused("draws view 2");
    const BufferId pixels = *p.backend->createBuffer({"pixels", 256, BufferMemory::Readback});
    const auto read = [&](std::initializer_list<uint32_t> views) {
        std::vector<Step> steps;
        for (const BufferId buffer : p.buffers) steps.push_back(FillStep{"fill", buffer, 0});
        for (const uint32_t view : views) p.draw.view = view, steps.push_back(p.draw);
        steps.push_back(ReadbackStep{"read", p.draw.target, pixels, {}});
        return bool(p.backend->createFrame(std::move(steps)));
    };
    EXPECT_FALSE(read({0})) << "the right eye was never drawn";
    EXPECT_TRUE(read({0, 1}));
}

TEST(FrameCheck, anotherBufferIsCopiedWholeIntoADeviceBufferThatHoldsIt) {
    OneStep s;
    const BufferId upload = *s.backend->createBuffer({"upload", 32, BufferMemory::Upload}),
                   back = *s.backend->createBuffer({"back", 32, BufferMemory::Readback});
    const auto copied = [&](const CopyStep& copy) {
        auto frame = s.backend->createFrame({copy, FillStep{"fill", s.counts, 0}, s.step});  // s.step reads the copied bytes
        return frame ? Status() : Status(frame.error());
    };
    const Status status = copied({"copy", upload, s.sums, 32});
    EXPECT_TRUE(status) << status.error().message;
    EXPECT_FALSE(copied({"copy", upload, s.sums, 36})) << "beyond its end";
    EXPECT_FALSE(copied({"copy", upload, s.sums, 2}));
    EXPECT_FALSE(copied({"copy", upload, s.sums, ~0ull - 3}));
    EXPECT_FALSE(copied({"copy", upload, BufferId{99}}));
    EXPECT_FALSE(copied({"copy", back, s.sums})) << "not from read-back memory";
    EXPECT_FALSE(copied({"copy", s.sums, s.sums})) << "not into itself";
    EXPECT_TRUE(s.backend->createFrame({FillStep{"fill", s.counts, 0}, CopyStep{"copy", s.counts, s.sums}, s.step})) << "between them";
}

TEST(FrameCheck, aReadbackBufferIsFilledFromAnyPartOfADeviceBufferThatHasAsMuch) {
    OneStep s;
    const BufferId back = *s.backend->createBuffer({"back", 32, BufferMemory::Readback}), from = *s.backend->createBuffer({"from", 64});
    const auto copied = [&](uint64_t offset, bool filled = true) {
        std::vector<Step> steps;
        if (filled) steps.push_back(FillStep{"fill", from, 0});
        steps.push_back(CopyStep{"copy", from, back, offset});
        auto frame = s.backend->createFrame(std::move(steps));
        return frame ? Status() : Status(frame.error());
    };
    EXPECT_FALSE(copied(0, false)) << "nothing has written it";
    EXPECT_TRUE(copied(0));
    EXPECT_TRUE(copied(32));
    EXPECT_FALSE(copied(36)) << "beyond its end";
    EXPECT_FALSE(copied(2));
    EXPECT_FALSE(copied(~0ull - 3));
}

TEST(FrameCheck, aFrameDoesNotOutliveItsBuffers) {
    OneStep s;
    auto frame = s.create();
    ASSERT_TRUE(frame);
    s.backend->destroyBuffer(s.sums);
    EXPECT_FALSE(s.backend->run(*frame));
}

TEST(FrameCheck, refusesBuffersWithoutBytesAndUnknownShaders) {
    OneStep s;
    EXPECT_FALSE(s.backend->createBuffer({"none", 0}));
    EXPECT_FALSE(s.backend->computePipeline("no such shader"));
    EXPECT_FALSE(s.backend->createTarget({.widthPx = 0, .heightPx = 4}));
    EXPECT_FALSE(s.backend->createTarget({.widthPx = 1u << 20, .heightPx = 4}));
}

}  // namespace
}  // namespace dpl
