// SPDX-License-Identifier: Apache-2.0
// What the Metal backend does on the CPU: which calls a frame becomes, slots, failed command buffers, and what lives how long.
#include <algorithm>

#include "sdk/backend/metal/mtl_backend.h"
#include "tests/metal/recording_seam.h"

namespace dpl::mtl {

// The backend asks the linker for a body of the seam. These tests give it one by hand.
Result<std::unique_ptr<Seam>> openSeam() {
    return fail(Code::Unsupported, "no device");
}
Result<std::unique_ptr<Seam>> lendSeam(void*, void*) {
    return fail(Code::Unsupported, "no device");
}

namespace {

/** A backend over the recorder, and the buffers and pipeline of one draw. */
struct Bench {
    RecordingSeam::Record record;
    std::unique_ptr<MetalBackend> backend;
    BufferId counts, order, projected, scene;

    explicit Bench(bool lent = true, RecordingSeam::Record with = {}) : record(std::move(with)) {
        auto made = createBackendOn(std::make_unique<RecordingSeam>(record), lent);
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        if (!made) return;
        backend = std::move(*made);
        counts = buffer("counts", sizeof(gpu::FrameCounts)), order = buffer("order", 64), projected = buffer("projected", 640);
        scene = buffer("scene", 64 * 48 * 2 * 4);
        record.calls.clear();
    }
    BufferId buffer(const char* name, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        const auto made = backend->createBuffer({name, bytes, memory});
        EXPECT_TRUE(made);
        return made ? *made : BufferId{};
    }
    std::vector<Step> filled() const {
        return {FillStep{"fill", counts, 0}, FillStep{"fill", order, 0}, FillStep{"fill", projected, 0}, FillStep{"fill", scene, 7}};
    }
    /** A draw of both views behind a scene. */
    DrawStep draw(TargetId target, bool multiview, uint32_t samples, uint32_t view) {
        DrawStep step;
        step.label = "draw.splats";
        const auto pipeline = backend->drawPipeline(
            {multiview ? "draw.vert.multiview" : "draw.vert", "draw.frag.depth.scene", 2, multiview, true, samples, Topology::List});
        EXPECT_TRUE(pipeline) << (pipeline ? "" : pipeline.error().message);
        step.pipeline = *pipeline, step.target = target, step.view = view;
        step.bindings = {{counts}, {order}, {projected}, {scene}};
        step.push.size = sizeof(gpu::DrawPush);
        step.args = {counts, offsetof(gpu::FrameCounts, drawVertices)};
        return step;
    }
    FrameId frame(std::vector<Step> steps, FrameRun run = FrameRun::Submitted) {
        const auto made = backend->createFrame(std::move(steps), run);
        EXPECT_TRUE(made) << (made ? "" : made.error().message);
        return made ? *made : FrameId{};
    }
    size_t placeOf(const std::string& call) const {
        const auto found = std::find(record.calls.begin(), record.calls.end(), call);
        EXPECT_NE(found, record.calls.end()) << call << " is missing among\n" << all();
        return size_t(found - record.calls.begin());
    }
    std::string all() const {
        std::string text;
        for (const std::string& call : record.calls) text += call + "\n";
        return text;
    }
};

TEST(MetalHost, buffersPushConstantsAndThreadsComeFromReflection) {
    Bench b;
    const BufferId sums = b.buffer("sums", 64);
    ComputeStep step;
    step.label = "compact.args";
    step.pipeline = *b.backend->computePipeline("compact.args");
    step.bindings = {{sums, Access::Read}, {b.counts, Access::Update}};
    step.push.size = sizeof(gpu::ArgsPush);
    step.groups = 3;
    std::vector<Step> steps = {FillStep{"fill", sums, 5}, FillStep{"fill", b.counts, 0}, step};
    ASSERT_TRUE(b.backend->submit(b.frame(steps)));
    b.placeOf("bytes 29 (8) 16 5");  // the fill: 16 words of 5
    b.placeOf("dispatch 1,1,1 x 256,1,1");
    EXPECT_LT(b.placeOf("label compact.args"), b.placeOf("buffer 1 = counts"));
    b.placeOf("buffer 0 = sums");
    b.placeOf("bytes 29 (16) 0 0");
    b.placeOf("dispatch 3,1,1 x 1,1,1");
}

TEST(MetalHost, barriersStandWhereAStepNeedsAnEarlierOne) {
    Bench b;
    const BufferId back = b.buffer("back", 64, BufferMemory::Readback);
    std::vector<Step> steps = {FillStep{"one", b.order, 0}, FillStep{"two", b.projected, 0}, FillStep{"three", b.order, 1},
                               CopyStep{"copy", b.order, back}};
    ASSERT_TRUE(b.backend->submit(b.frame(steps)));
    EXPECT_EQ(b.record.count("barrier"), 1u) << "only the second fill of a buffer waits\n" << b.all();
    const size_t barrier = b.placeOf("barrier");
    EXPECT_LT(b.placeOf("label two"), barrier);
    EXPECT_LT(barrier, b.placeOf("label three"));
    EXPECT_EQ(b.record.count("compute"), 1u);
    EXPECT_LT(b.placeOf("update fence written"), b.placeOf("blit")) << "the copy is in another encoder, which waits for the fence";
    EXPECT_EQ(b.record.count("wait fence written"), 2u);
    EXPECT_EQ(b.record.count("update fence written"), 2u);
}

TEST(MetalHost, oneLayeredDrawReachesAllViews) {
    Bench b;
    const TargetId target = *b.backend->createTarget({64, 48, 2, true, true, 1, false});
    std::vector<Step> steps = b.filled();
    steps.push_back(b.draw(target, true, 1, 0));
    ASSERT_TRUE(b.backend->submit(b.frame(steps)));
    EXPECT_EQ(b.record.count("render"), 1u);
    b.placeOf("render layers 2 slice 0 of colour");
    b.placeOf("vertex bytes 24 (8) 0 2");
    for (const char* call : {"vertex buffer 0 = counts", "vertex buffer 1 = order", "vertex buffer 2 = projected",
                             "fragment buffer 3 = scene", "wait fence written before 1", "update fence written after 2"})
        b.placeOf(call);
    EXPECT_EQ(b.record.count("vertex bytes 29"), 1u);
    EXPECT_EQ(b.record.count("fragment bytes 29"), 1u);
    b.placeOf("draw by counts + " + std::to_string(offsetof(gpu::FrameCounts, drawVertices)));
    EXPECT_TRUE(b.backend->info().viewsAreInstances) << "so the arguments count instances × views";
}

TEST(MetalHost, withoutLayersEachViewIsAPass) {
    Bench b(true, {.apple5 = false});
    ASSERT_FALSE(b.backend->info().multiview);
    EXPECT_FALSE(b.backend->createTarget({64, 48, 2, true, true})) << "layered";
    for (const uint32_t samples : {1u, 4u}) {
        b.record.calls.clear();
        const TargetId target = *b.backend->createTarget({64, 48, 2, true, false, samples, false});
        std::vector<Step> steps = b.filled();
        for (const uint32_t view : {0u, 1u}) steps.push_back(b.draw(target, false, samples, view));
        ASSERT_TRUE(b.backend->submit(b.frame(steps)));
        EXPECT_EQ(b.record.count("render layers 0"), 2u);
        if (samples == 1)
            b.placeOf("render layers 0 slice 1 of colour");
        else
            EXPECT_EQ(b.record.count("render layers 0 slice 0 of colour samples"), 2u) << "both views use the same samples";
        EXPECT_EQ(b.record.count("vertex bytes 24"), 0u);
    }
}

TEST(MetalHost, refusesWrongStepsAsEveryBackendDoes) {
    Bench b;
    DrawStep step = b.draw(*b.backend->createTarget({64, 48, 2, true, true}), true, 1, 0);
    const auto refused = [&](DrawStep wrong, const char* part, std::vector<Step> before) {
        before.push_back(wrong);
        const auto made = b.backend->createFrame(before, FrameRun::Submitted);
        ASSERT_FALSE(made) << part;
        EXPECT_NE(made.error().message.find(part), std::string::npos) << made.error().message;
    };
    refused(step, "nothing has written", {});
    DrawStep wrong = step;
    wrong.bindings.pop_back();
    refused(wrong, "binds 3 buffers", b.filled());
    wrong = step, wrong.push.size = 4;
    refused(wrong, "pushes 4 bytes", b.filled());
    wrong = step, wrong.args.offset = sizeof(gpu::FrameCounts);
    refused(wrong, "do not fit buffer counts", b.filled());
    wrong = step, wrong.target = {};
    refused(wrong, "target that does not exist", b.filled());
    EXPECT_FALSE(b.backend->createTarget({0, 48}));
    EXPECT_FALSE(b.backend->createTarget({20000, 48}));
    EXPECT_FALSE(b.backend->createTarget({64, 48, 1, false, true, 2})) << "two samples";
    EXPECT_FALSE(b.backend->computePipeline("no such kernel"));
}

TEST(MetalHost, aGpuThatIsTooOldIsRefused) {
    RecordingSeam::Record record;
    record.apple4 = record.apple5 = false;
    const auto made = createBackendOn(std::make_unique<RecordingSeam>(record), true);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, Code::Unsupported);
    EXPECT_EQ(record.alive, 0);
}

TEST(MetalHost, framesEndWithoutAWaitAndTellTheirTime) {
    Bench b(false);
    const FrameId frame = b.frame(b.filled());
    EXPECT_TRUE(b.backend->passTimes(frame).empty());
    b.record.runsAtOnce = false;
    ASSERT_TRUE(b.backend->submit(frame));
    EXPECT_FALSE(b.backend->finished(frame));
    RecordingSeam::run(b.record.committed.back());
    EXPECT_TRUE(b.backend->finished(frame));
    const auto waits = [&] { return std::count(b.record.calls.begin(), b.record.calls.end(), "wait"); };
    EXPECT_EQ(waits(), 0);
    EXPECT_DOUBLE_EQ(b.backend->frameMs(frame), 250);
    EXPECT_EQ(b.backend->passTimes(frame).size(), 1u);
    ASSERT_TRUE(b.backend->submit(frame));
    ASSERT_TRUE(b.backend->submit(frame)) << "waits for the run before";
    EXPECT_EQ(waits(), 1);
}

TEST(MetalHost, aFailedFrameIsAnErrorOfTheNextWait) {
    for (const CommandError error : {CommandError::NotPermitted, CommandError::Timeout}) {
        Bench b(false);
        const FrameId frame = b.frame(b.filled());
        b.record.runsAtOnce = false;
        ASSERT_TRUE(b.backend->submit(frame));
        RecordingSeam::failWith(b.record.committed.back(), error);
        EXPECT_FALSE(b.backend->finished(frame));
        const Status status = b.backend->wait(frame);
        ASSERT_FALSE(status);
        EXPECT_EQ(status.error().code, Code::Device);
        const bool background = error == CommandError::NotPermitted;
        EXPECT_EQ(b.backend->lost(), !background) << "an app that went to the background loses a frame only";
        EXPECT_EQ(bool(b.backend->submit(frame)), background);
    }
}

/** Commands of an app. */
struct AppCommandsOf {
    RecordingSeam seam;
    CommandsRef commands = seam.commandBuffer();
    explicit AppCommandsOf(RecordingSeam::Record& record) : seam(record) {}
    ~AppCommandsOf() { seam.release(commands); }
    operator AppCommands() const { return {commands.object}; }
    void run() { seam.commit(commands), RecordingSeam::run(commands.object); }
};

TEST(MetalHost, aSlotIsFreeOnceItsCommandsHaveRun) {
    Bench b;
    const FrameId frame = b.frame(b.filled(), FrameRun::Encoded);
    b.record.runsAtOnce = false;
    AppCommandsOf first(b.record), second(b.record);
    ASSERT_TRUE(b.backend->takeSlot(1));
    ASSERT_TRUE(b.backend->encode(frame, 1, first));
    const Status early = b.backend->takeSlot(1);
    ASSERT_FALSE(early);
    EXPECT_EQ(early.error().code, Code::InvalidArgument);
    EXPECT_NE(early.error().message.find("dplMetalDropSlot"), std::string::npos);
    EXPECT_TRUE(b.backend->takeSlot(0)) << "another slot";
    first.run();
    EXPECT_TRUE(b.backend->takeSlot(1));
    ASSERT_TRUE(b.backend->encode(frame, 1, second));
    EXPECT_TRUE(b.backend->dropSlot(1)) << "these commands will never run";
    EXPECT_TRUE(b.backend->takeSlot(1));
    EXPECT_FALSE(b.backend->takeSlot(3));
    EXPECT_FALSE(b.backend->encode(frame, 3, second));
    EXPECT_FALSE(b.backend->encode(frame, 0, {}));
    EXPECT_FALSE(b.backend->submit(frame)) << "it is for an app's commands";
}

TEST(MetalHost, failedCommandsOfASlotCostAFrameOrTheDevice) {
    for (const CommandError error : {CommandError::NotPermitted, CommandError::PageFault}) {
        Bench b;
        b.record.runsAtOnce = false;
        const BufferId staging = b.buffer("staging", 64, BufferMemory::Upload), loaded = b.buffer("loaded", 64);
        const uint64_t copy = *b.backend->queueCopy(staging, 0, loaded, 0, 64);
        AppCommandsOf commands(b.record);
        ASSERT_TRUE(b.backend->takeSlot(0));
        ASSERT_TRUE(b.backend->encodeCopies(0, commands, true));
        EXPECT_EQ(b.record.count("copy staging"), 1u);
        RecordingSeam::failWith(commands.commands.object, error);
        const Status status = b.backend->takeSlot(0);
        ASSERT_FALSE(status);
        EXPECT_EQ(status.error().code, Code::Device);
        EXPECT_NE(status.error().message.find("planted"), std::string::npos);
        EXPECT_EQ(b.backend->lost(), error == CommandError::PageFault);
        if (b.backend->lost()) continue;
        EXPECT_FALSE(*b.backend->hasRun(copy));
        AppCommandsOf again(b.record);
        ASSERT_TRUE(b.backend->takeSlot(0)) << "the slot is free";
        ASSERT_TRUE(b.backend->encodeCopies(0, again, true));
        EXPECT_EQ(b.record.count("copy staging"), 2u) << "the copy is made again";
        again.run();
        EXPECT_TRUE(*b.backend->hasRun(copy));
    }
}

TEST(MetalHost, commandsThatRunBehindRefusedOnesDoNotFinishTheirCopies) {
    Bench b;
    b.record.runsAtOnce = false;
    const BufferId staging = b.buffer("staging", 64, BufferMemory::Upload), loaded = b.buffer("loaded", 64);
    const uint64_t copy = *b.backend->queueCopy(staging, 0, loaded, 0, 64);
    AppCommandsOf refused(b.record), later(b.record);
    ASSERT_TRUE(b.backend->takeSlot(0));
    ASSERT_TRUE(b.backend->encodeCopies(0, refused, true));
    ASSERT_TRUE(b.backend->takeSlot(1));
    ASSERT_TRUE(b.backend->encodeCopies(1, later, true));
    RecordingSeam::failWith(refused.commands.object, CommandError::NotPermitted);
    later.run();
    EXPECT_FALSE(*b.backend->hasRun(copy));
    EXPECT_FALSE(b.backend->takeSlot(0)) << "tells of the refusal";
    EXPECT_FALSE(*b.backend->hasRun(copy)) << "a later frame carries it";
    AppCommandsOf again(b.record);
    ASSERT_TRUE(b.backend->takeSlot(0));
    ASSERT_TRUE(b.backend->encodeCopies(0, again, true));
    EXPECT_FALSE(*b.backend->hasRun(copy));
    again.run();
    EXPECT_TRUE(*b.backend->hasRun(copy));
}

TEST(MetalHost, destroyedObjectsLiveUntilEverySlotHasComeRound) {
    Bench b;
    b.record.runsAtOnce = false;
    const FrameId frame = b.frame(b.filled(), FrameRun::Encoded);
    const BufferId old = b.buffer("old", 16);
    std::vector<std::unique_ptr<AppCommandsOf>> commands;
    const auto encode = [&](uint32_t slot) {
        commands.push_back(std::make_unique<AppCommandsOf>(b.record));
        ASSERT_TRUE(b.backend->takeSlot(slot));
        ASSERT_TRUE(b.backend->encode(frame, slot, *commands.back()));
        commands.back()->run();
    };
    for (uint32_t slot = 0; slot < kAppSlots; ++slot) encode(slot);
    const BufferId fresh = b.buffer("fresh", 16);
    const int before = b.record.alive;
    b.backend->destroyBuffer(fresh);
    EXPECT_EQ(b.record.alive, before - 1) << "no commands can need it";
    b.backend->destroyBuffer(old);
    EXPECT_EQ(b.record.alive, before - 1) << "commands of three slots may need it";
    const auto isAlive = [&] { return b.record.alive - int(commands.size()); };
    const int held = isAlive();
    encode(0), encode(1);
    EXPECT_EQ(isAlive(), held);
    encode(2), encode(0);
    EXPECT_EQ(isAlive(), held - 1);
}

TEST(MetalHost, nothingOfABackendOutlivesIt) {
    RecordingSeam::Record record;
    {
        Bench b(true, {});
        const TargetId target = *b.backend->createTarget({64, 48, 2, true, true, 4, true});
        std::vector<Step> steps = b.filled();
        steps.push_back(b.draw(target, true, 4, 0));
        const FrameId frame = b.frame(steps, FrameRun::Encoded);
        AppPass pass{PixelFormat::BGRA8UnormSrgb, PixelFormat::Depth32Float, PixelFormat::None, 4, 2, PictureDepth::Mesh};
        const auto composer = b.backend->createComposer(pass);
        ASSERT_TRUE(composer) << composer.error().message;
        {
            AppCommandsOf commands(b.record);
            ASSERT_TRUE(b.backend->takeSlot(0));
            ASSERT_TRUE(b.backend->encode(frame, 0, commands));
            commands.run();
        }
        EXPECT_TRUE(b.backend->destroyComposer(*composer));
        EXPECT_FALSE(b.backend->destroyComposer(*composer));
        EXPECT_GT(b.record.alive, 20);
        b.backend.reset();
        EXPECT_EQ(b.record.alive, 0);
    }
}

TEST(MetalHost, composersRefusePassesThatTheyCannotFill) {
    Bench b;
    const AppPass good{PixelFormat::RGBA16Float, PixelFormat::Depth32Float, PixelFormat::None, 1, 2, PictureDepth::Splats};
    ASSERT_TRUE(b.backend->createComposer(good));
    EXPECT_EQ(b.backend->depthsWritten(), uint32_t(PictureDepth::Splats));
    const auto refused = [&](auto change, const char* part) {
        AppPass pass = good;
        change(pass);
        const auto made = b.backend->createComposer(pass);
        ASSERT_FALSE(made) << part;
        EXPECT_EQ(made.error().code, Code::Unsupported);
        EXPECT_NE(made.error().message.find(part), std::string::npos) << made.error().message;
    };
    refused([](AppPass& p) { p.colour = PixelFormat::RG32Float; }, "MTLPixelFormat 105");
    refused([](AppPass& p) { p.samples = 2; }, "2 samples");
    refused([](AppPass& p) { p.layers = 3; }, "3 layers");
    refused([](AppPass& p) { p.depth = PixelFormat::None; }, "writes depth");
    Bench old(true, {.apple5 = false});
    EXPECT_FALSE(old.backend->createComposer(good)) << "layered rendering is missing";
    Bench own(false);
    EXPECT_FALSE(own.backend->createComposer(good)) << "the device is not the app's";
}

TEST(MetalHost, composeOrdersTheAppsEncoderBehindPrepareAndSetsAllThatItNeeds) {
    Bench b;
    const TargetId target = *b.backend->createTarget({64, 48, 2, true, true, 1, true});
    const ComposerId layered =
        *b.backend->createComposer({PixelFormat::RGBA16Float, PixelFormat::Depth32Float, {}, 1, 2, PictureDepth::Splats});
    const ComposerId single = *b.backend->createComposer({PixelFormat::BGRA8Unorm});
    ASSERT_TRUE(b.backend->takeSlot(0));
    RecordingSeam::Record mine;
    RecordingSeam seam(mine);
    RenderEncoderRef encoder{seam.newFence().object};
    EXPECT_FALSE(b.backend->compose(layered, 0, 0, {0, 0}, {encoder.object})) << "not prepared";
    const LayerPlace places[] = {{64, 48, target, 0}, {64, 48, target, 1}};
    ASSERT_TRUE(b.backend->setLayers(0, places));
    b.record.calls.clear();
    ASSERT_TRUE(b.backend->compose(layered, 0, 0, {-3, 5}, {encoder.object}));
    EXPECT_EQ(b.record.count("draw 3 x 2"), 1u) << "one draw, an instance for each layer\n" << b.all();
    b.placeOf("vertex bytes 24 (8) 0 2");
    b.placeOf("fragment bytes 24 (8) 0 2");
    b.placeOf("one amplification");
    b.placeOf("viewport -3 5 64 48");
    b.placeOf("depth stencil keep depth");
    b.placeOf("fragment texture 0 = colour");
    b.placeOf("fragment buffer 1 = unread");
    EXPECT_LT(b.placeOf("wait fence written before 2"), b.placeOf("draw 3 x 2"));
    EXPECT_LT(b.placeOf("draw 3 x 2"), b.placeOf("update fence composed 0 after 2"));
    b.record.calls.clear();
    ASSERT_TRUE(b.backend->composeDepth(layered, 0, 0, {}, {0, 0.1f}, {encoder.object}));
    b.placeOf("depth stencil nearer");
    b.placeOf("fragment texture 2 = depth sums");
    b.placeOf("update fence composed 1 after 2");
    b.record.calls.clear();
    ASSERT_TRUE(b.backend->compose(single, 0, 1, {0, 0}, {encoder.object}));
    b.placeOf("draw 3 x 1");
    EXPECT_EQ(b.record.count("vertex bytes"), 0u);
    EXPECT_FALSE(b.backend->compose(single, 0, 2, {0, 0}, {encoder.object})) << "there are two views";
    EXPECT_FALSE(b.backend->composeDepth(single, 0, 0, {}, {0, 0.1f}, {encoder.object})) << "it writes no depth";
    b.record.calls.clear();
    const FrameId next = b.frame(b.filled(), FrameRun::Encoded);
    ASSERT_TRUE(b.backend->takeSlot(1));
    ASSERT_TRUE(b.backend->encode(next, 1, {encoder.object}));
    for (const char* fence : {"wait fence composed 0", "wait fence composed 1", "wait fence composed 2"})
        EXPECT_EQ(b.record.count(fence), 1u) << "the next frame begins behind each compose";
    b.record.calls.clear();
    ASSERT_TRUE(b.backend->compose(single, 0, 1, {0, 0}, {encoder.object}));
    b.placeOf("update fence composed 0 after 2");
    EXPECT_TRUE(b.backend->dropSlot(1));
    seam.release(encoder);
}

}  // namespace
}  // namespace dpl::mtl
