// SPDX-License-Identifier: Apache-2.0
// What goes wrong in a Metal program: slots that come too early, command buffers that the GPU refuses, a device that fails, wrong
// arguments. And the form that commits by itself, and loads between frames.
#include "tests/metal/metal_app.h"

namespace dpl::mtl {
namespace {

constexpr PixelFormat kFormat = PixelFormat::RGBA8Unorm;
constexpr TargetFormat kReferee = TargetFormat::Rgba8;

class MetalAppFaults : public MetalApp {
protected:
    static bool errorSays(const char* text) { return std::string(dplGetLastError()).find(text) != std::string::npos; }
    /** Prepares, composes and commits a frame. Returns what prepare did. */
    DplResult frame(uint32_t slot, uint32_t into, TextureRef colour, const DplCamera& view) {
        CommandsRef commands = app_->commandBuffer();
        const DplResult result = dplMetalPrepare(context_, commands.object, slot, &avatar_, 1, &view, 1, nullptr);
        if (result == DPL_OK) {
            const RenderEncoderRef encoder = begin(commands, {.colour = colour});
            EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
            end(encoder);
            app_->commit(commands);
        }
        app_->release(commands);
        return result;
    }
    DplResult submit(uint32_t into, uint32_t slot, const DplCamera& view, const DplMetalSubmission& how) {
        return dplMetalSubmit(context_, into, slot, &avatar_, 1, &view, 1, nullptr, &how);
    }
    void expectPicture(TextureRef colour, const DplCamera& view, const std::vector<uint8_t>* want = nullptr) {
        EXPECT_GT(reference::psnrDb(kReferee, download(colour, 0, 4), want ? *want : over(pictureOf(view), kReferee)), 60);
    }
};

TEST_F(MetalAppFaults, framesOfAProgramAreNotTimedAndTheStatisticsSaySo) {
    open();
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat);
    ASSERT_EQ(dplSetFrameBudget(context_, 0.001), DPL_OK) << dplGetLastError();
    for (uint32_t i = 0; i < 9; ++i) {
        ASSERT_EQ(frame(i % DPL_METAL_SLOTS, into, colour, view), DPL_OK) << dplGetLastError();
        device_->finish();
    }
    DplFrameStats stats{};
    stats.structSize = sizeof stats;
    ASSERT_EQ(dplGetFrameStats(avatar_, &stats), DPL_OK) << dplGetLastError();
    EXPECT_GT(stats.splatsDrawn, 0u) << "what was drawn is known";
    EXPECT_EQ(stats.passCount, 0u);
    EXPECT_EQ(stats.gpuMs, 0);
    EXPECT_EQ(stats.frameMs, 0);
    EXPECT_EQ(stats.budgetState, DPL_BUDGET_UNTIMED);
    EXPECT_EQ(stats.keptLimit, 0u) << "nothing is limited by a time that nobody measured";
    DplPassTime time{};
    time.structSize = sizeof time;
    EXPECT_EQ(dplGetPassTime(avatar_, 0, &time), DPL_ERROR_NOT_FOUND);
}

TEST_F(MetalAppFaults, aSlotThatComesTooEarlyIsNoticed) {
    open(DPL_FILL_QUADS, {.looks = 1000});
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat);
    ASSERT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    EXPECT_EQ(frame(0, into, colour, view), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("completion handler")) << dplGetLastError();
    EXPECT_EQ(frame(1, into, colour, view), DPL_OK) << "another slot: " << dplGetLastError();
    device_->finish();
    EXPECT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    EXPECT_EQ(frame(3, into, colour, view), DPL_ERROR_INVALID_ARGUMENT);

    // Commands that are never committed.
    CommandsRef dropped = app_->commandBuffer();
    EXPECT_EQ(dplMetalPrepare(context_, dropped.object, 2, &avatar_, 1, &view, 1, nullptr), DPL_OK) << dplGetLastError();
    app_->release(dropped);
    EXPECT_EQ(frame(2, into, colour, view), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplMetalDropSlot(context_, 2), DPL_OK);
    EXPECT_EQ(frame(2, into, colour, view), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplMetalDropSlot(context_, 3), DPL_ERROR_INVALID_ARGUMENT);
    device_->finish();
    expectPicture(colour, view);
}

TEST_F(MetalAppFaults, anAppInTheBackgroundLosesFramesOnly) {
    open();
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat);
    device_->failNext(CommandError::NotPermitted, "Insufficient Permission (to submit GPU work from background)");
    ASSERT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    device_->finish();
    EXPECT_EQ(frame(0, into, colour, view), DPL_ERROR_DEVICE);
    EXPECT_TRUE(errorSays("background")) << dplGetLastError();
    ASSERT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    device_->finish();
    expectPicture(colour, view);
}

TEST_F(MetalAppFaults, aSurfaceThatIsLostBetweenPrepareAndComposeCostsThatFrame) {
    open();
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat);
    for (uint32_t i = 0; i < 2 * DPL_METAL_SLOTS; ++i) {
        commit(prepared(i % DPL_METAL_SLOTS, {&view, 1}));  // there is no drawable to compose into
        device_->finish();
    }
    ASSERT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    device_->finish();
    expectPicture(colour, view);
}

TEST_F(MetalAppFaults, aDeviceThatFailsIsReplacedAndAvatarsStay) {
    open();
    const DplCamera view = camera();
    uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat);
    const std::vector<uint8_t> want = over(pictureOf(view), kReferee);
    device_->failNext(CommandError::Timeout, "Caused GPU Timeout Error");
    ASSERT_EQ(frame(0, into, colour, view), DPL_OK) << dplGetLastError();
    device_->finish();
    EXPECT_EQ(frame(0, into, colour, view), DPL_ERROR_DEVICE);
    EXPECT_TRUE(errorSays("Timeout")) << dplGetLastError();
    EXPECT_EQ(frame(1, into, colour, view), DPL_ERROR_DEVICE) << "and so is all that follows";
    EXPECT_TRUE(errorSays("dplRebuildMetal")) << dplGetLastError();
    EXPECT_EQ(dplRebuildMetal(context_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplRebuildVulkan(context_, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    const DplMetalDevice same = lent(*device_);
    ASSERT_EQ(dplRebuildMetal(context_, &same), DPL_OK) << dplGetLastError();
    const CommandsRef commands = prepared(0, {&view, 1});
    const RenderEncoderRef encoder = begin(commands, {.colour = colour});
    EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, 0, 0, 0, 0), DPL_ERROR_NOT_FOUND) << "composers are gone";
    end(encoder), commit(commands);
    into = composer(kFormat);
    ASSERT_EQ(frame(1, into, colour, view), DPL_OK) << dplGetLastError();
    device_->finish();
    expectPicture(colour, view, &want);
}

TEST_F(MetalAppFaults, submitDrawsOverTexturesInTheOrderOfEvents) {
    open(DPL_FILL_QUADS, {.looks = 1000});
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat), withDepth = composer(kFormat, 0, PixelFormat::Depth32Float);
    const TextureRef colour = texture(kFormat), floats = texture(PixelFormat::RGBA16Float),
                     readOnly = texture(kFormat, 0, 1, kWidth, kUsageShaderRead);
    EventRef drawn = app_->newSharedEvent(), done = app_->newSharedEvent();
    CommandsRef scene = app_->commandBuffer();
    end(begin(scene, {.colour = colour}));
    DplMetalSubmission how{};
    how.structSize = sizeof how;
    how.textureCount = 1, how.textures[0] = colour.object;
    how.waitEvent = drawn.object, how.waitValue = 1;
    how.signalEvent = done.object, how.signalValue = 5;
    app_->encodeSignal(scene, drawn, 1);
    commit(scene);
    ASSERT_EQ(submit(into, 0, view, how), DPL_OK) << dplGetLastError();
    EXPECT_EQ(app_->signaledValue(done), 0u);
    EXPECT_EQ(submit(into, 0, view, how), DPL_ERROR_INVALID_ARGUMENT) << "the slot is in flight";
    device_->finish();
    EXPECT_EQ(app_->signaledValue(done), 5u);
    expectPicture(colour, view);
    how.waitEvent = nullptr, how.signalEvent = nullptr;

    const auto refused = [&](uint32_t composer, auto change, DplResult want, const char* text) {
        DplMetalSubmission wrong = how;
        change(wrong);
        EXPECT_EQ(submit(composer, 0, view, wrong), want);
        EXPECT_TRUE(errorSays(text)) << dplGetLastError();
    };
    refused(
        into, [&](auto& h) { h.textures[0] = floats.object; }, DPL_ERROR_INVALID_ARGUMENT, "does not fit");
    refused(
        into, [&](auto& h) { h.textures[0] = readOnly.object; }, DPL_ERROR_INVALID_ARGUMENT, "usage 1");
    refused(
        into, [&](auto& h) { h.textures[0] = nullptr; }, DPL_ERROR_INVALID_ARGUMENT, "NULL");
    refused(
        into, [&](auto& h) { h.textureCount = 2, h.textures[1] = colour.object; }, DPL_ERROR_INVALID_ARGUMENT, "2 textures");
    refused(
        into, [&](auto& h) { h.textureCount = 9; }, DPL_ERROR_INVALID_ARGUMENT, "textureCount");
    refused(
        withDepth, [](auto&) {}, DPL_ERROR_INVALID_ARGUMENT, "has a depth");
    refused(
        999, [](auto&) {}, DPL_ERROR_NOT_FOUND, "no composer");
    ASSERT_EQ(submit(into, 0, view, how), DPL_OK) << "the slot is free after each error: " << dplGetLastError();
    device_->finish();
    app_->release(drawn), app_->release(done);
}

class MetalLoads : public MetalAppFaults {
protected:
    /** Loads the same file again while frames go on, and compares its picture. refused: of each five command buffers, this many
     *  are, so that each slot is refused at times. */
    void loadWithFrames(uint32_t refused) {
        open();
        const auto bytes = tubeFile();
        DplLoad load = nullptr;
        DplLoadInfo info{};
        info.structSize = sizeof info, info.data = bytes.data(), info.size = bytes.size();
        ASSERT_EQ(dplStartLoad(context_, &info, &load), DPL_OK) << dplGetLastError();
        DplLoadStatus status{};
        status.structSize = sizeof status;
        uint32_t frames = 0, lost = 0, seen = 0;
        do {
            const CommandsRef commands = app_->commandBuffer();
            const uint32_t slot = frames % DPL_METAL_SLOTS;
            DplResult uploaded = dplMetalUpload(context_, commands.object, slot);
            if (uploaded == DPL_ERROR_DEVICE && seen < lost) ++seen, uploaded = dplMetalUpload(context_, commands.object, slot);
            ASSERT_EQ(uploaded, DPL_OK) << dplGetLastError();
            if (frames % 5 < refused) ++lost, device_->failNext(CommandError::NotPermitted, "Insufficient Permission");
            commit(commands);
            device_->finish();
            ASSERT_EQ(dplGetLoadStatus(load, &status), DPL_OK);
        } while (status.state < DPL_LOAD_READY && ++frames < 100000);
        ASSERT_EQ(status.state, DPL_LOAD_READY);
        DplAvatar second = nullptr;
        ASSERT_EQ(dplFinishLoad(load, &second), DPL_OK) << dplGetLastError();
        std::swap(avatar_, second);
        const DplCamera view = camera();
        const Picture loaded = pictureOf(view);
        std::swap(avatar_, second);
        EXPECT_TRUE(loaded.rgba == pictureOf(view).rgba) << "the same file";
        EXPECT_EQ(dplDestroyAvatar(second), DPL_OK);
    }
};

TEST_F(MetalLoads, framesCarryALoad) {
    loadWithFrames(0);
}

TEST_F(MetalLoads, anAppInTheBackgroundWhileItLoadsLosesNothingOfTheLoad) {
    loadWithFrames(2);
}

TEST_F(MetalLoads, aLoadAtOnceThatIsRefusedInTheBackgroundMayBeTriedAgain) {
    open();
    const auto bytes = tubeFile();
    const size_t before = device_->alive().size();
    DplAvatar second = nullptr;
    device_->failNext(CommandError::NotPermitted, "Insufficient Permission");
    EXPECT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &second), DPL_ERROR_DEVICE);
    EXPECT_TRUE(errorSays("background")) << dplGetLastError();
    EXPECT_EQ(second, nullptr);
    EXPECT_EQ(device_->alive().size(), before) << "nothing of the avatar is left";
    ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &second), DPL_OK) << dplGetLastError();
    std::swap(avatar_, second);
    const DplCamera view = camera();
    const Picture loaded = pictureOf(view);
    std::swap(avatar_, second);
    EXPECT_TRUE(loaded.rgba == pictureOf(view).rgba);
    EXPECT_EQ(dplDestroyAvatar(second), DPL_OK);
}

TEST_F(MetalAppFaults, refusesWhatCannotBeDrawn) {
    open();
    const DplCamera view = camera();
    const uint32_t into = composer(kFormat);
    const TextureRef colour = texture(kFormat), secret = texture(PixelFormat::Depth32Float, 0, 1, kWidth, kUsageRenderTarget),
                     depth = texture(PixelFormat::Depth32Float);
    DplContext other = nullptr;
    DplMetalDevice device = lent(*device_);
    EXPECT_EQ(dplCreateMetalContext(nullptr, nullptr, &other), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplCreateMetalContext(&device, nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    device.queue = nullptr;
    EXPECT_EQ(dplCreateMetalContext(&device, nullptr, &other), DPL_ERROR_INVALID_ARGUMENT);
    SoftwareDevice another;
    device.queue = another.queue();
    EXPECT_EQ(dplCreateMetalContext(&device, nullptr, &other), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("another device")) << dplGetLastError();
    device = lent(*device_), device.reserved = 1;
    EXPECT_EQ(dplCreateMetalContext(&device, nullptr, &other), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(other, nullptr);

    CommandsRef commands = app_->commandBuffer();
    const auto prepare = [&](const DplMetalSceneDepth* depths, void* given) {
        return dplMetalPrepare(context_, given, 0, &avatar_, 1, &view, 1, depths);
    };
    EXPECT_EQ(prepare(nullptr, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    const auto refused = [&](DplMetalSceneDepth wrong, const char* text) {
        EXPECT_EQ(prepare(&wrong, commands.object), DPL_ERROR_INVALID_ARGUMENT) << text;
        EXPECT_TRUE(errorSays(text)) << dplGetLastError();
    };
    refused({sizeof(DplMetalSceneDepth), 0, nullptr, 0, 0, 0, kNear}, "no texture");
    refused({sizeof(DplMetalSceneDepth), 0, depth.object, 0, 0, 0, 0}, "offset 0");
    refused({sizeof(DplMetalSceneDepth), 0, depth.object, 0, 0, NAN, kNear}, "finite");
    refused({sizeof(DplMetalSceneDepth), 1, depth.object, 0, 0, 0, kNear}, "slice 1");
    refused({sizeof(DplMetalSceneDepth), 0, secret.object, 0, 0, 0, kNear}, "MTLTextureUsageShaderRead");
    refused({sizeof(DplMetalSceneDepth), 0, colour.object, 0, 0, 0, kNear}, "no depth");
    app_->release(commands);

    commands = prepared(0, {&view, 1});
    const RenderEncoderRef encoder = begin(commands, {.colour = colour});
    EXPECT_EQ(dplMetalCompose(context_, into, nullptr, 0, 0, 0, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, 0, 1, 0, 0), DPL_ERROR_INVALID_ARGUMENT) << "one view was prepared";
    EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, 1, 0, 0, 0), DPL_ERROR_INVALID_ARGUMENT) << "not prepared";
    EXPECT_EQ(dplMetalCompose(context_, 999, encoder.object, 0, 0, 0, 0), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(dplMetalComposeDepth(context_, into, encoder.object, 0, 0, 0, 0, 0, kNear), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("writesDepth")) << dplGetLastError();
    EXPECT_EQ(dplMetalComposeDepth(context_, into, encoder.object, 0, 0, 0, 0, 0, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, 0, 0, 0, 0), DPL_OK) << dplGetLastError();
    end(encoder), commit(commands);

    DplMetalPass pass{sizeof pass, 9999};
    uint32_t made = 0;
    EXPECT_EQ(dplCreateMetalComposer(context_, &pass, &made), DPL_ERROR_UNSUPPORTED);
    pass.colourFormat = uint32_t(kFormat), pass.writesDepth = 7;
    EXPECT_EQ(dplCreateMetalComposer(context_, &pass, &made), DPL_ERROR_INVALID_ARGUMENT);
    pass.writesDepth = DPL_DRAW_DEPTH;
    EXPECT_EQ(dplCreateMetalComposer(context_, &pass, &made), DPL_ERROR_UNSUPPORTED) << "there is no depth attachment";
    EXPECT_EQ(dplDestroyMetalComposer(context_, into), DPL_OK);
    EXPECT_EQ(dplDestroyMetalComposer(context_, into), DPL_ERROR_NOT_FOUND);

    const DplContextInfo software{sizeof software, DPL_RENDERER_SOFTWARE, 1};
    ASSERT_EQ(dplCreateContext(&software, &other), DPL_OK);
    EXPECT_EQ(dplMetalDropSlot(other, 0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("dplCreateMetalContext")) << dplGetLastError();
    const DplMetalDevice good = lent(*device_);
    EXPECT_EQ(dplRebuildMetal(other, &good), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplDestroyContext(other), DPL_OK);
}

}  // namespace
}  // namespace dpl::mtl
