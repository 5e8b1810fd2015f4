// SPDX-License-Identifier: Apache-2.0
// What Vulkan and Metal share of a backend on an app's device, over an API that only notes what it is asked for.
#include <gtest/gtest.h>

#include "sdk/backend/slotted_backend.h"

namespace dpl {
namespace {

/** Encodes into strings. The test says how far the GPU has come, and whether it failed. */
class NotedApi final : public SlottedBackend {
public:
    explicit NotedApi(bool lent = true) : SlottedBackend({"wait, or drop it", "begin it", "SomePass"}), lent_(lent) {
        info_.halfDepth = true;
    }

    std::vector<std::string> calls;
    uint64_t reached = 0;  // the last mark that the GPU has come to
    bool failed = false;   // the GPU could not run the commands
    bool copied = false;   // the copy that was submitted has run

    ComposerId composer(const ComposerFacts& facts) { return addComposer(facts); }
    void create(const std::string& name) { born_[name] = encoded(); }
    void destroy(const std::string& name) {
        retired_.retire(name, born_.at(name), encoded(), [&](const std::string& freed) { calls.push_back("free " + freed); });
    }
    BufferId bufferOf(uint64_t bytes) {
        const BufferId id{newId()};
        buffers_[id.value] = {"buffer", bytes, BufferMemory::Device};
        return id;
    }
    void forget(BufferId id) { dropCopies(id); }

    Status encode(FrameId, uint32_t slot, AppCommands commands) override {
        DPL_RETURN_IF_ERROR(beginSlot(slot, commands));
        calls.push_back("frame");
        endSlot(slot, commands);
        return {};
    }
    /** What was called since the last take. */
    std::vector<std::string> take() { return std::exchange(calls, {}); }

    const DeviceInfo& info() const override { return info_; }
    Result<BufferId> createBuffer(const BufferDesc& desc) override { return bufferOf(desc.bytes); }
    void destroyBuffer(BufferId) override {}
    Status write(BufferId, uint64_t, std::span<const std::byte>) override { return {}; }
    std::span<std::byte> mapped(BufferId) override { return {}; }
    Result<PipelineId> computePipeline(std::string_view) override { return PipelineId{1}; }
    Result<PipelineId> drawPipeline(const DrawPipelineDesc&) override { return PipelineId{1}; }
    uint32_t workgroupSize(PipelineId) const override { return 1; }
    Result<TargetId> createTarget(const TargetDesc& desc) override { return target_ = desc, TargetId{newId()}; }
    void destroyTarget(TargetId) override {}
    Result<FrameId> createFrame(std::vector<Step>, FrameRun) override { return FrameId{newId()}; }
    void destroyFrame(FrameId) override {}
    uint64_t residentBytes() const override { return 0; }
    Status submit(FrameId) override { return {}; }
    bool finished(FrameId) override { return true; }
    Status wait(FrameId) override { return {}; }
    std::vector<PassTime> passTimes(FrameId) override { return {}; }
    double frameMs(FrameId) override { return 0; }

private:
    const BufferDesc* buffer(BufferId id) const override {
        const auto found = buffers_.find(id.value);
        return found == buffers_.end() ? nullptr : &found->second;
    }
    const TargetDesc* target(TargetId) const override { return &target_; }
    const Shader* shader(PipelineId) const override { return nullptr; }
    const Shader* fragment(PipelineId) const override { return nullptr; }
    bool written(BufferId) const override { return true; }
    bool drawn(TargetId) const override { return true; }

    bool lent() const override { return lent_; }
    void writeMark(uint32_t slot, uint64_t mark, AppCommands) override { calls.push_back(formatText("mark {} of slot {}", mark, slot)); }
    Result<bool> slotEnded(uint32_t, uint64_t mark) override {
        if (failed) return fail(Code::Device, "planted");
        return reached >= mark;
    }
    bool slotHasRun(uint32_t, uint64_t mark) const override { return !failed && reached >= mark; }
    void slotIsFree(uint32_t slot, bool ran) override { calls.push_back(formatText("slot {} {}", slot, ran ? "ran" : "dropped")); }
    void freeRetired(uint64_t oldest) override {
        retired_.freeBefore(oldest, [&](const std::string& freed) { calls.push_back("free " + freed); });
    }
    Status encodeCopy(const CopyQueue::Copy& copy, AppCommands) override {
        calls.push_back(formatText("copy {}", copy.number));
        return {};
    }
    void setWritten(BufferId) override {}
    Status submitCopy(const CopyQueue::Copy& copy) override {
        calls.push_back(formatText("submit {}", copy.number));
        return {};
    }
    Result<bool> submittedCopyHasRun(CopyQueue::Copy&) override { return copied; }
    void waitForCopy() override { calls.push_back("wait"); }
    bool viewsShareImage(const TargetDesc& desc) const override { return desc.multiview; }
    void setLayer(uint32_t slot, uint32_t view, const LayerPlace&) override { calls.push_back(formatText("layer {} {}", slot, view)); }
    Status drawPicture(const PictureDraw& what, PassCommands) override {
        std::string call =
            formatText("{} at {} {}:", what.depth ? what.greaterIsNearer ? "greater" : "less" : "colour", what.place.x, what.place.y);
        for (uint32_t i = 0; i < what.draws; ++i) call += formatText(" view {} of {}", what.push[i].view, what.push[i].views);
        calls.push_back(call);
        return {};
    }
    void retireComposer(ComposerId id) override { calls.push_back(formatText("retire composer {}", id.value)); }

    const bool lent_;
    DeviceInfo info_;
    TargetDesc target_;
    std::map<uint32_t, BufferDesc> buffers_;
    std::map<std::string, uint64_t> born_;
    RetiredObjects<std::string> retired_;
};

int someObject;
const AppCommands kCommands{&someObject};
const PassCommands kPass{&someObject};
using Calls = std::vector<std::string>;

TEST(SlottedBackend, aSlotIsTakenAgainOnceTheGpuHasComeToItsMark) {
    NotedApi api;
    ASSERT_TRUE(api.takeSlot(1));
    ASSERT_TRUE(api.encode({}, 1, kCommands));
    EXPECT_EQ(api.take(), (Calls{"slot 1 ran", "frame", "mark 1 of slot 1"}));
    const Status early = api.takeSlot(1);
    ASSERT_FALSE(early);
    EXPECT_EQ(early.error().code, Code::InvalidArgument);
    EXPECT_NE(early.error().message.find("slot 1 is prepared again"), std::string::npos) << early.error().message;
    EXPECT_NE(early.error().message.find("wait, or drop it"), std::string::npos) << early.error().message;
    EXPECT_TRUE(api.take().empty()) << "nothing changed";
    EXPECT_TRUE(api.takeSlot(0)) << "another slot";
    api.reached = 1;
    EXPECT_TRUE(api.takeSlot(1));
    EXPECT_EQ(api.take(), (Calls{"slot 0 ran", "slot 1 ran"}));
    for (const Status& wrong :
         {api.takeSlot(kAppSlots), api.dropSlot(kAppSlots), api.encode({}, kAppSlots, kCommands), api.encode({}, 0, {})})
        EXPECT_FALSE(wrong);
    EXPECT_TRUE(api.take().empty());
}

TEST(SlottedBackend, commandsJoinOnlyASlotThatAFrameHasBegun) {
    NotedApi api;
    EXPECT_FALSE(api.joinSlot(0)) << "nothing was encoded";
    EXPECT_FALSE(api.joinSlot(kAppSlots));
    ASSERT_TRUE(api.takeSlot(0));
    EXPECT_NE(api.joinSlot(0).error().message.find("begin it"), std::string::npos);
    ASSERT_TRUE(api.encode({}, 0, kCommands));
    const auto first = api.joinSlot(0), again = api.joinSlot(0);
    ASSERT_TRUE(first);
    EXPECT_EQ(*first, *again);
    EXPECT_FALSE(api.joinSlot(1)) << "another slot";
    ASSERT_TRUE(api.encode({}, 0, kCommands));  // what joins marks the slot again
    api.reached = 1;
    EXPECT_FALSE(api.takeSlot(0)) << "what has joined has not run";
    api.reached = 2;
    ASSERT_TRUE(api.takeSlot(0));
    EXPECT_FALSE(api.joinSlot(0)) << "taken, and not begun";
    ASSERT_TRUE(api.encode({}, 0, kCommands));
    const auto next = api.joinSlot(0);
    ASSERT_TRUE(next);
    EXPECT_NE(*next, *first);
    ASSERT_TRUE(api.dropSlot(0));
    EXPECT_FALSE(api.joinSlot(0));
}

TEST(SlottedBackend, copiesOfCommandsThatNeverRanAreEncodedAgain) {
    for (const bool failed : {false, true}) {
        NotedApi api;
        const BufferId from = api.bufferOf(64), to = api.bufferOf(64);
        const uint64_t copy = *api.queueCopy(from, 0, to, 0, 64);
        ASSERT_TRUE(api.takeSlot(0));
        ASSERT_TRUE(api.encodeCopies(0, kCommands, /*endsSlot=*/true));
        EXPECT_EQ(api.take(), (Calls{"slot 0 ran", formatText("copy {}", copy), "mark 1 of slot 0"}));
        EXPECT_FALSE(*api.hasRun(copy)) << "the GPU has not come to the mark";
        api.failed = failed;
        if (failed) {
            EXPECT_EQ(api.takeSlot(0).error().code, Code::Device);
        } else {
            EXPECT_TRUE(api.dropSlot(0));
        }
        EXPECT_EQ(api.take(), (Calls{"slot 0 dropped"}));
        EXPECT_FALSE(*api.hasRun(copy));
        api.failed = false;
        ASSERT_TRUE(api.takeSlot(0)) << "the slot is free";
        ASSERT_TRUE(api.encodeCopies(0, kCommands, true));
        EXPECT_EQ(api.take(), (Calls{"slot 0 ran", formatText("copy {}", copy), "mark 2 of slot 0"}));
        api.reached = 2;
        EXPECT_TRUE(*api.hasRun(copy));
        ASSERT_TRUE(api.takeSlot(0));
        ASSERT_TRUE(api.encodeCopies(0, kCommands, false));
        EXPECT_EQ(api.take(), (Calls{"slot 0 ran"})) << "nothing waits";
    }
}

TEST(SlottedBackend, aFrameCarriesAMegabyteOfCopies) {
    NotedApi api;
    const BufferId from = api.bufferOf(4 * kCopiedBytesAFrame), to = api.bufferOf(4 * kCopiedBytesAFrame);
    for (const uint64_t bytes : {kCopiedBytesAFrame / 2, kCopiedBytesAFrame / 2, 2 * kCopiedBytesAFrame})
        ASSERT_TRUE(api.queueCopy(from, 0, to, 0, bytes));
    EXPECT_FALSE(api.queueCopy(from, 0, to, 2, 4)) << "offsets are multiples of 4";
    EXPECT_FALSE(api.queueCopy(from, 4 * kCopiedBytesAFrame, to, 0, 4)) << "beyond the buffer";
    EXPECT_FALSE(api.queueCopy({99}, 0, to, 0, 4)) << "no such buffer";
    ASSERT_TRUE(api.encodeCopies(0, kCommands, false));
    EXPECT_EQ(api.take(), (Calls{"copy 1", "copy 2"}));
    ASSERT_TRUE(api.encodeCopies(1, kCommands, false));
    EXPECT_EQ(api.take(), (Calls{"copy 3"})) << "one of any size";
}

TEST(SlottedBackend, onADeviceOfItsOwnOneCopyRunsAtATime) {
    NotedApi api(/*lent=*/false);
    const BufferId from = api.bufferOf(64), to = api.bufferOf(64);
    const uint64_t first = *api.queueCopy(from, 0, to, 0, 64), second = *api.queueCopy(from, 0, to, 0, 64);
    EXPECT_EQ(api.take(), (Calls{"submit 1"}));
    EXPECT_FALSE(*api.hasRun(first));
    api.copied = true;
    EXPECT_TRUE(*api.hasRun(first));
    EXPECT_EQ(api.take(), (Calls{"submit 2"}));
    api.copied = false;
    api.forget(from);
    EXPECT_EQ(api.take(), (Calls{"wait"})) << "it is about to go, and the copy reads it";
    EXPECT_TRUE(*api.hasRun(second)) << "forgotten";
}

TEST(SlottedBackend, objectsRetireUntilEverySlotHasComeRound) {
    NotedApi api;
    api.create("old");
    for (uint32_t slot = 0; slot < kAppSlots; ++slot) ASSERT_TRUE(api.encode({}, slot, kCommands));
    api.create("fresh");
    api.take();
    api.destroy("fresh");
    EXPECT_EQ(api.take(), (Calls{"free fresh"})) << "no commands can need it";
    api.destroy("old");
    for (const uint32_t slot : {0u, 1u}) ASSERT_TRUE(api.encode({}, slot, kCommands));
    EXPECT_EQ(std::count(api.calls.begin(), api.calls.end(), "free old"), 0) << "the frame that slot 2 has may need it";
    api.take();
    ASSERT_TRUE(api.encode({}, 2, kCommands));
    EXPECT_EQ(api.take().front(), "free old");
}

TEST(SlottedBackend, picturesAreComposedByOneDrawForEachImage) {
    NotedApi api;
    const ComposerId single = api.composer({}), layered = api.composer({false, 2, PictureDepth::Splats}),
                     mesh = api.composer({true, 0, PictureDepth::Mesh});
    EXPECT_EQ(api.depthsWritten(), uint32_t(PictureDepth::Splats) | uint32_t(PictureDepth::Mesh));
    const TargetId one = *api.createTarget({64, 48, 2, true, /*multiview=*/true}), other = *api.createTarget({64, 48, 2, true, true});
    const BufferId left = api.bufferOf(64), right = api.bufferOf(64);
    ASSERT_TRUE(api.takeSlot(0));
    EXPECT_FALSE(api.compose(single, 0, 0, {}, kPass)) << "not prepared";
    const LayerPlace shared[] = {{64, 48, one, 0}, {64, 48, one, 1}}, apart[] = {{64, 48, one, 0}, {64, 48, other, 0}},
                     tiled[] = {{64, 48, {}, 0, left}, {64, 48, {}, 1, left}},
                     tiledApart[] = {{64, 48, {}, 0, left}, {64, 48, {}, 0, right}};
    ASSERT_TRUE(api.setLayers(0, shared));
    EXPECT_EQ(api.take(), (Calls{"slot 0 ran", "layer 0 0", "layer 0 1"}));
    ASSERT_TRUE(api.compose(layered, 0, 0, {-3, 5}, kPass));
    ASSERT_TRUE(api.compose(single, 0, 1, {}, kPass));
    ASSERT_TRUE(api.composeDepth(layered, 0, 0, {}, {0, 0.1f}, kPass));
    ASSERT_TRUE(api.composeDepth(layered, 0, 0, {}, {1, -0.1f}, kPass));
    EXPECT_EQ(api.take(), (Calls{"colour at -3 5: view 0 of 3", "colour at 0 0: view 1 of 3", "greater at 0 0: view 0 of 3",
                                 "less at 0 0: view 0 of 3"}));
    ASSERT_TRUE(api.setLayers(0, apart));
    api.take();
    ASSERT_TRUE(api.compose(layered, 0, 0, {}, kPass));
    EXPECT_EQ(api.take(), (Calls{"colour at 0 0: view 0 of 1 view 1 of 2"}));
    ASSERT_TRUE(api.setLayers(0, tiledApart));
    api.take();
    ASSERT_TRUE(api.compose(layered, 0, 0, {}, kPass));
    EXPECT_EQ(api.take(), (Calls{"colour at 0 0: view 0 of 1 view 1 of 2"})) << "a buffer for each eye";
    ASSERT_TRUE(api.setLayers(0, tiled));
    api.take();
    ASSERT_TRUE(api.compose(layered, 0, 0, {}, kPass));
    EXPECT_EQ(api.take(), (Calls{"colour at 0 0: view 0 of 3"})) << "tiles fill without a target";
    EXPECT_FALSE(api.compose(single, 0, 2, {}, kPass)) << "there are two views";
    const Status noDepth = api.composeDepth(single, 0, 0, {}, {0, 1}, kPass);
    ASSERT_FALSE(noDepth);
    EXPECT_NE(noDepth.error().message.find("SomePass"), std::string::npos) << noDepth.error().message;
    EXPECT_TRUE(api.composeDepth(mesh, 0, 0, {}, {0, 1}, kPass));
    EXPECT_TRUE(api.take().empty()) << "the picture has no mesh";
    EXPECT_TRUE(api.destroyComposer(single));
    EXPECT_EQ(api.destroyComposer(single).error().code, Code::NotFound);
    EXPECT_EQ(api.compose(single, 0, 0, {}, kPass).error().code, Code::NotFound);
    ASSERT_TRUE(api.takeSlot(0));
    EXPECT_FALSE(api.compose(layered, 0, 0, {}, kPass)) << "its next frame is not encoded yet";
    EXPECT_FALSE(api.setLayers(0, {}));
    EXPECT_FALSE(api.setLayers(kAppSlots, shared));
}

TEST(SlottedBackend, aSlotLacksTheDepthOfComposersThatWereMadeLater) {
    NotedApi api;
    const TargetId target = *api.createTarget({64, 48, 1, true, true});
    const LayerPlace places[] = {{64, 48, target, 0}};
    ASSERT_TRUE(api.takeSlot(0));
    const ComposerId later = api.composer({false, 0, PictureDepth::Splats});
    ASSERT_TRUE(api.setLayers(0, places));
    EXPECT_TRUE(api.compose(later, 0, 0, {}, kPass));
    EXPECT_FALSE(api.composeDepth(later, 0, 0, {}, {0, 1}, kPass));
    ASSERT_TRUE(api.takeSlot(0));
    ASSERT_TRUE(api.setLayers(0, places));
    EXPECT_TRUE(api.composeDepth(later, 0, 0, {}, {0, 1}, kPass));
}

TEST(SlottedBackend, aBackendThatReplacesAnotherGivesAwayNewNumbers) {
    NotedApi lost, fresh;
    for (int i = 0; i < 5; ++i) lost.bufferOf(16);
    fresh.numberAfter(lost.lastNumber());
    EXPECT_EQ(fresh.bufferOf(16).value, 6u);
    fresh.numberAfter(2);
    EXPECT_EQ(fresh.bufferOf(16).value, 7u);
}

}  // namespace
}  // namespace dpl
