// SPDX-License-Identifier: Apache-2.0
// The software device finds planted faults, and finds none in the same commands without them.
#include <gtest/gtest.h>

#include <cstring>

#include "shaders/shared/frame.h"
#include "tests/metal/cpu/msl_entry.h"
#include "tests/metal/software/software_device.h"

namespace dpl::mtl {
namespace {

constexpr uint32_t kPush = 29, kViewMask = 24;

/** A device with the kernel `fill`, which writes words, and `scan.sums`, which reads and writes them. */
class MetalDevice : public testing::Test {
protected:
    MetalDevice() : seam_(device_.seam()), fill_(compute("fill")), sums_(compute("scan.sums")) {}
    ~MetalDevice() override {
        seam_->release(fill_);
        seam_->release(sums_);
        device_.finish();
        EXPECT_EQ(device_.takeFaults(), std::vector<std::string>());
        EXPECT_EQ(device_.alive(), std::vector<std::string>());
    }

    FunctionRef function(const char* name) {
        std::string error;
        LibraryRef library = seam_->newLibrary(msl::entryNamed(name)->text, error);
        const FunctionRef made = seam_->newFunction(library, "main0");
        seam_->release(library);
        return made;
    }
    ComputePipelineRef compute(const char* name) {
        std::string error;
        FunctionRef made = function(name);
        const ComputePipelineRef pipeline = seam_->newComputePipeline(made, error);
        EXPECT_TRUE(pipeline) << error;
        seam_->release(made);
        return pipeline;
    }
    BufferRef words(uint32_t count, const char* label = "words") { return seam_->newBuffer(4 * count, StorageMode::Shared, label); }
    uint32_t word(BufferRef buffer, uint32_t at) {
        uint32_t value;
        std::memcpy(&value, seam_->contents(buffer) + 4 * at, 4);
        return value;
    }
    void fillWords(ComputeEncoderRef encoder, BufferRef buffer, uint32_t count, uint32_t value = 7) {
        const gpu::FillPush push{count, value};
        seam_->setPipeline(encoder, fill_);
        seam_->setBuffer(encoder, buffer, 0, 0);
        seam_->setBytes(encoder, &push, sizeof push, kPush);
        seam_->dispatch(encoder, {1}, {gpu::kFillGroup});
    }
    void sumWords(ComputeEncoderRef encoder, BufferRef buffer, uint32_t count) {
        const gpu::ScanPush push{0, count};
        seam_->setPipeline(encoder, sums_);
        seam_->setBuffer(encoder, buffer, 0, 0);
        seam_->setBytes(encoder, &push, sizeof push, kPush);
        seam_->dispatch(encoder, {1}, {gpu::kScanGroup});
    }
    /** Runs what `encode` writes into one compute encoder of a command buffer. */
    template <class Encode>
    void run(const Encode& encode) {
        CommandsRef commands = seam_->commandBuffer();
        ComputeEncoderRef encoder = seam_->computeEncoder(commands);
        encode(encoder);
        seam_->end(encoder);
        seam_->release(encoder);
        seam_->commit(commands);
        seam_->wait(commands);
        seam_->release(commands);
    }
    /** Expects one fault, which contains `text`. */
    void expectFault(const std::string& text) {
        const std::vector<std::string> faults = device_.takeFaults();
        ASSERT_EQ(faults.size(), 1u) << testing::PrintToString(faults);
        EXPECT_NE(faults[0].find(text), std::string::npos) << faults[0];
    }
    void expectFine() { EXPECT_EQ(device_.takeFaults(), std::vector<std::string>()); }

    SoftwareDevice device_;
    std::unique_ptr<Seam> seam_;
    ComputePipelineRef fill_, sums_;
};

TEST_F(MetalDevice, runsAKernel) {
    BufferRef buffer = words(100);
    run([&](ComputeEncoderRef e) { fillWords(e, buffer, 99); });
    EXPECT_EQ(word(buffer, 0), 7u);
    EXPECT_EQ(word(buffer, 98), 7u);
    EXPECT_EQ(word(buffer, 99), 0xCDCDCDCDu) << "memory that nobody wrote is garbage";
    seam_->release(buffer);
}

TEST_F(MetalDevice, runsCommandsNoSoonerThanTheProgramWaits) {
    BufferRef buffer = words(8);
    CommandsRef commands = seam_->commandBuffer();
    ComputeEncoderRef encoder = seam_->computeEncoder(commands);
    fillWords(encoder, buffer, 8);
    seam_->end(encoder);
    seam_->release(encoder);
    seam_->commit(commands);
    EXPECT_EQ(word(buffer, 0), 0xCDCDCDCDu);
    EXPECT_EQ(seam_->status(commands), CommandStatus::Committed);
    EXPECT_EQ(seam_->status(commands), CommandStatus::Completed) << "the device works between two looks";
    EXPECT_EQ(word(buffer, 0), 7u);
    seam_->release(commands);
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsAnIndexBeyondABuffer) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) { fillWords(e, buffer, 8); });
    expectFine();
    run([&](ComputeEncoderRef e) { fillWords(e, buffer, 9); });
    expectFault("fill uses an element beyond the 32 bytes of buffer(0)");
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsABufferThatIsSmallerThanTheStructItHolds) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) {
        const uint32_t half = 8;
        seam_->setPipeline(e, fill_);
        seam_->setBuffer(e, buffer, 0, 0);
        seam_->setBytes(e, &half, sizeof half, kPush);
        seam_->dispatch(e, {1}, {gpu::kFillGroup});
    });
    expectFault("needs 8 bytes in buffer(29)");
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsAMissingBarrierBetweenDispatches) {
    BufferRef buffer = words(8), other = words(8);
    for (const bool barrier : {true, false}) {
        run([&](ComputeEncoderRef e) {
            fillWords(e, buffer, 8);
            fillWords(e, other, 8);  // another buffer needs none
            if (barrier) seam_->barrier(e);
            sumWords(e, buffer, 4);
        });
        if (barrier)
            expectFine();
        else
            expectFault("without a barrier or fence between: buffer 'words'");
    }
    seam_->release(buffer);
    seam_->release(other);
}

TEST_F(MetalDevice, allowsDispatchesThatWritePartsOfOneBuffer) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) {
        fillWords(e, buffer, 4);
        const gpu::FillPush push{4, 9};
        seam_->setBuffer(e, buffer, 16, 0);
        seam_->setBytes(e, &push, sizeof push, kPush);
        seam_->dispatch(e, {1}, {gpu::kFillGroup});
    });
    EXPECT_EQ(word(buffer, 3), 7u);
    EXPECT_EQ(word(buffer, 4), 9u);
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsAMissingFenceBetweenEncoders) {
    BufferRef buffer = words(8);
    FenceRef fence = seam_->newFence();
    enum Case { Fenced, NoUpdate, NoWait, OtherFence };
    for (const Case c : {Fenced, NoUpdate, NoWait, OtherFence}) {
        CommandsRef commands[2];
        for (int i = 0; i < 2; ++i) {  // also from one command buffer to the next, because resources are not tracked
            commands[i] = seam_->commandBuffer();
            ComputeEncoderRef e = seam_->computeEncoder(commands[i]);
            FenceRef other = seam_->newFence();
            if (i == 1 && c != NoWait) seam_->waitFence(e, c == OtherFence ? other : fence);
            i == 0 ? fillWords(e, buffer, 8) : sumWords(e, buffer, 4);
            if (i == 0 && c != NoUpdate) seam_->updateFence(e, fence);
            seam_->end(e);
            seam_->release(e);
            seam_->commit(commands[i]);
            device_.finish();
            seam_->release(other);
        }
        for (CommandsRef& c : commands) seam_->release(c);
        if (c == Fenced)
            expectFine();
        else
            expectFault("without a barrier or fence between");
        seam_->release(fence);  // what one case updated must not help the next
        fence = seam_->newFence();
    }
    seam_->release(fence);
    seam_->release(buffer);
}

TEST_F(MetalDevice, aFenceStandsForItsLastUpdateOnly) {
    BufferRef buffer = words(8), other = words(8);
    FenceRef fence = seam_->newFence();
    CommandsRef commands = seam_->commandBuffer();
    for (int i = 0; i < 3; ++i) {
        ComputeEncoderRef e = seam_->computeEncoder(commands);
        if (i == 2) seam_->waitFence(e, fence);
        fillWords(e, i == 1 ? other : buffer, 8);
        if (i < 2) seam_->updateFence(e, fence);  // the second did not wait for the first
        seam_->end(e);
        seam_->release(e);
    }
    seam_->commit(commands);
    seam_->wait(commands);
    seam_->release(commands);
    expectFault("without a barrier or fence between");
    seam_->release(fence);
    seam_->release(buffer);
    seam_->release(other);
}

TEST_F(MetalDevice, theProcessorOrdersWhatItHasWaitedFor) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) { fillWords(e, buffer, 8); });  // waits
    run([&](ComputeEncoderRef e) { sumWords(e, buffer, 4); });
    expectFine();
    seam_->release(buffer);
}

TEST_F(MetalDevice, anEventOrdersCommandBuffers) {
    BufferRef buffer = words(8);
    EventRef event = seam_->newSharedEvent();
    uint64_t value = 0;
    for (const bool waits : {true, false}) {
        CommandsRef commands[2] = {seam_->commandBuffer(), seam_->commandBuffer()};
        ++value;
        for (int i = 0; i < 2; ++i) {
            if (i == 1 && waits) seam_->encodeWait(commands[i], event, value);
            ComputeEncoderRef e = seam_->computeEncoder(commands[i]);
            fillWords(e, buffer, 8);
            seam_->end(e);
            seam_->release(e);
            if (i == 0) seam_->encodeSignal(commands[i], event, value);
            seam_->commit(commands[i]);
        }
        seam_->wait(commands[1]);
        for (CommandsRef& c : commands) seam_->release(c);
        if (waits)
            expectFine();
        else
            expectFault("without a barrier or fence between");
    }
    EXPECT_EQ(seam_->signaledValue(event), 2u);
    seam_->release(event);
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsAWaitThatNeverEnds) {
    EventRef event = seam_->newSharedEvent();
    CommandsRef commands = seam_->commandBuffer();
    seam_->encodeWait(commands, event, 1);
    seam_->commit(commands);
    seam_->wait(commands);
    EXPECT_EQ(seam_->status(commands), CommandStatus::Error);
    seam_->release(commands);
    seam_->release(event);
    expectFault("waits for an event that nothing signals");
}

TEST_F(MetalDevice, findsIndicesThatMetalDoesNotHave) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) { seam_->setBuffer(e, buffer, 0, 31); });
    expectFault("buffer(31) is bound");
    run([&](ComputeEncoderRef e) {
        seam_->setBuffer(e, buffer, 0, 0);
        fillWords(e, buffer, 8);
    });
    expectFault("buffer(0) is bound twice before a use");
    run([&](ComputeEncoderRef e) { seam_->setBuffer(e, buffer, 32, 0); });
    expectFault("lies behind");
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsWhatIsNotBound) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) {
        seam_->setPipeline(e, fill_);
        seam_->setBuffer(e, buffer, 0, 0);
        seam_->dispatch(e, {1}, {gpu::kFillGroup});
    });
    expectFault("fill needs buffer(29)");
    run([&](ComputeEncoderRef e) { seam_->dispatch(e, {1}, {gpu::kFillGroup}); });
    expectFault("a dispatch without a pipeline");
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsThreadgroupsOfAnotherSize) {
    BufferRef buffer = words(8);
    run([&](ComputeEncoderRef e) {
        const gpu::FillPush push{8, 7};
        seam_->setPipeline(e, fill_);
        seam_->setBuffer(e, buffer, 0, 0);
        seam_->setBytes(e, &push, sizeof push, kPush);
        seam_->dispatch(e, {1}, {64});
        seam_->dispatch(e, {1}, {gpu::kFillGroup});
    });
    expectFault("is dispatched with 64 x 1 x 1 threads, and was written for 256 x 1 x 1");
    seam_->release(buffer);
}

TEST_F(MetalDevice, findsTextThatBreaksTheRulesOfMetal) {
    std::string error;
    EXPECT_FALSE(seam_->newLibrary("kernel void main0()\n{\n    threadgroup uint a[8193];\n}\n", error));
    EXPECT_NE(error.find("32772 bytes of threadgroup memory"), std::string::npos) << error;
    EXPECT_FALSE(seam_->newLibrary("kernel void main0(device uint& a [[buffer(1)]], device uint& b [[buffer(1)]])\n{\n}\n", error));
    EXPECT_NE(error.find("[[buffer(1)]] is used twice"), std::string::npos) << error;
    EXPECT_FALSE(seam_->newLibrary("kernel void main0(device uint& a [[buffer(1)]])\n{\n}\n", error));
    EXPECT_NE(error.find("has not compiled this text"), std::string::npos) << error;
}

TEST_F(MetalDevice, findsCommandBuffersAndEncodersUsedInTheWrongOrder) {
    CommandsRef commands = seam_->commandBuffer();
    ComputeEncoderRef encoder = seam_->computeEncoder(commands);
    EXPECT_FALSE(seam_->blitEncoder(commands));
    expectFault("has an open compute encoder");
    seam_->end(encoder);
    seam_->barrier(encoder);
    expectFault("memoryBarrierWithScope: the encoder has ended");
    seam_->end(encoder);
    expectFault("endEncoding: the encoder has ended");
    seam_->release(encoder);
    seam_->commit(commands);
    seam_->commit(commands);
    expectFault("committed twice");
    EXPECT_FALSE(seam_->computeEncoder(commands));
    expectFault("committed before");
    seam_->wait(commands);
    seam_->release(commands);

    commands = seam_->commandBuffer();
    encoder = seam_->computeEncoder(commands);
    seam_->commit(commands);
    expectFault("before endEncoding");
    seam_->end(encoder);
    seam_->release(encoder);
    seam_->wait(commands);
    seam_->release(commands);

    commands = seam_->commandBuffer();
    encoder = seam_->computeEncoder(commands);
    seam_->release(encoder);
    expectFault("is released before endEncoding");
    seam_->release(commands);
}

TEST_F(MetalDevice, findsObjectsThatAreReleasedTooEarlyOrTwice) {
    BufferRef buffer = words(8), kept = buffer;
    CommandsRef commands = seam_->commandBuffer();
    ComputeEncoderRef encoder = seam_->computeEncoder(commands);
    fillWords(encoder, buffer, 8);
    seam_->end(encoder);
    seam_->release(encoder);
    seam_->commit(commands);
    seam_->release(buffer);
    expectFault("buffer 'words' is released while commands that use it have not run");
    seam_->wait(commands);
    seam_->release(commands);
    seam_->release(kept);
    expectFault("the handle is no such object, or was released");
}

TEST_F(MetalDevice, tellsOfAFailureThatATestAsksFor) {
    BufferRef buffer = words(8);
    device_.failNext(CommandError::NotPermitted, "in the background");
    CommandsRef commands = seam_->commandBuffer();
    ComputeEncoderRef encoder = seam_->computeEncoder(commands);
    fillWords(encoder, buffer, 8);
    seam_->end(encoder);
    seam_->release(encoder);
    seam_->commit(commands);
    seam_->wait(commands);
    std::string text;
    EXPECT_EQ(seam_->status(commands), CommandStatus::Error);
    EXPECT_EQ(seam_->error(commands, text), CommandError::NotPermitted);
    EXPECT_EQ(text, "in the background");
    EXPECT_EQ(word(buffer, 0), 0xCDCDCDCDu);
    seam_->release(commands);
    seam_->release(buffer);
}

TEST_F(MetalDevice, lendsASeamOnItsOwnQueueOnly) {
    SoftwareDevice other;
    EXPECT_TRUE(lendSeam(device_.device(), device_.queue()));
    EXPECT_FALSE(lendSeam(device_.device(), other.queue()));
    EXPECT_FALSE(lendSeam(device_.device(), nullptr));
    EXPECT_FALSE(lendSeam(&other, other.queue()));
}

}  // namespace
}  // namespace dpl::mtl
