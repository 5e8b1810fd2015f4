// SPDX-License-Identifier: Apache-2.0
// Avatars in a Metal program's own frames, through doppel_metal.h on the software device: the pixels that the referee composes, in every
// format and layout of both eyes; depth in and out; slots, failures of the GPU, rebuilding; and what is refused.
#include <gtest/gtest.h>

#include <array>

#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel_metal.h"
#include "tests/metal/software/software_device.h"
#include "tests/reference/composition.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl::mtl {
namespace {

using reference::StoredDepth;
using reference::TargetFormat;

constexpr uint32_t kWidth = 72, kHeight = 60;
constexpr float kNear = 0.1f, kFar = 20;
constexpr double kBackground[4] = {0.25, 0.5, 0.75, 1};

struct FormatCase {
    PixelFormat format;
    TargetFormat referee;
};
constexpr FormatCase kFormats[] = {
    {PixelFormat::RGBA8Unorm, TargetFormat::Rgba8},         {PixelFormat::BGRA8Unorm, TargetFormat::Bgra8},
    {PixelFormat::RGBA8UnormSrgb, TargetFormat::Rgba8Srgb}, {PixelFormat::BGRA8UnormSrgb, TargetFormat::Bgra8Srgb},
    {PixelFormat::RGBA16Float, TargetFormat::Rgba16f},      {PixelFormat::RGB10A2Unorm, TargetFormat::A2b10g10r10},
};

std::vector<uint8_t> tubeFile() {
    AvatarData avatar = makeTube({.splatsPerTriangle = 4, .shDegree = 3});
    sortSplats(avatar);
    const auto bytes = writeAvatar(avatar);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<uint8_t>();
}

/** The program: a device, a queue, textures and passes; and a context of Doppel's on them. */
class MetalApp : public testing::Test {
protected:
    void open(DplFill fill = DPL_FILL_QUADS, const SoftwareOptions& options = {}) {
        device_ = std::make_unique<SoftwareDevice>(options);
        app_ = device_->seam();
        const DplMetalDevice mine = lent(*device_);
        const DplContextInfo info{sizeof info, DPL_RENDERER_AUTO, 1, 0, fill, nullptr};
        ASSERT_EQ(dplCreateMetalContext(&mine, &info, &context_), DPL_OK) << dplGetLastError();
        const auto bytes = tubeFile();
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    static DplMetalDevice lent(const SoftwareDevice& device) { return {sizeof(DplMetalDevice), 0, device.device(), device.queue()}; }
    void TearDown() override {
        if (!device_) return;
        device_->finish();
        EXPECT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        for (TextureRef& texture : textures_) app_->release(texture);
        EXPECT_EQ(device_->takeFaults(), std::vector<std::string>());
        EXPECT_EQ(device_->alive(), std::vector<std::string>());
    }

    TextureRef texture(PixelFormat format, uint32_t layers = 0, uint32_t samples = 1, uint32_t width = kWidth,
                       uint32_t usage = kUsageRenderTarget | kUsageShaderRead) {
        TextureDesc desc;
        desc.type = layers == 0 ? (samples == 1 ? TextureType::Flat : TextureType::FlatSamples)
                                : (samples == 1 ? TextureType::Array : TextureType::ArraySamples);
        desc.format = format, desc.widthPx = width, desc.heightPx = kHeight;
        desc.layers = std::max(layers, 1u), desc.samples = samples, desc.usage = usage, desc.tracked = true;
        textures_.push_back(app_->newTexture(desc, "of the app"));
        return textures_.back();
    }
    uint32_t composer(PixelFormat colour, uint32_t layers = 0, PixelFormat depth = PixelFormat::None, uint32_t writesDepth = 0,
                      uint32_t samples = 1) {
        const DplMetalPass pass{sizeof pass, uint32_t(colour), uint32_t(depth), 0, samples, layers, writesDepth};
        uint32_t made = 0;
        EXPECT_EQ(dplCreateMetalComposer(context_, &pass, &made), DPL_OK) << dplGetLastError();
        return made;
    }
    static DplCamera camera(float shiftM = 0, float turn = 0) {
        const Cameraf from = tubeCamera(kWidth, kHeight, 0.6f + turn, 1.6f, shiftM);
        DplCamera to{};
        to.structSize = sizeof to;
        to.widthPx = kWidth, to.heightPx = kHeight, to.fx = from.fx, to.fy = from.fy, to.cx = from.cx, to.cy = from.cy;
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) to.viewFromWorld[row * 4 + column] = from.viewFromWorldRotation[column][row];
            to.viewFromWorld[row * 4 + 3] = from.viewFromWorldTranslation[row];
        }
        return to;
    }

    /** Commands of the program with an avatar prepared. */
    CommandsRef prepared(uint32_t slot, std::span<const DplCamera> views, const DplMetalSceneDepth* depths = nullptr) {
        const CommandsRef commands = app_->commandBuffer();
        EXPECT_EQ(dplMetalPrepare(context_, commands.object, slot, &avatar_, 1, views.data(), uint32_t(views.size()), depths), DPL_OK)
            << dplGetLastError();
        return commands;
    }
    struct Pass {
        TextureRef colour, depth, resolve;
        uint32_t slice = 0, layers = 0;
        double clearDepth = 1;
        bool clears = true;
    };
    RenderEncoderRef begin(CommandsRef commands, const Pass& pass) {
        RenderPassDesc desc;
        desc.colours[0].texture = pass.colour, desc.colours[0].slice = pass.slice;
        desc.colours[0].load = pass.clears ? LoadAction::Clear : LoadAction::Load;
        if (pass.resolve) desc.colours[0].resolve = pass.resolve, desc.colours[0].store = StoreAction::Resolve;
        std::copy_n(kBackground, 4, desc.colours[0].clear);
        desc.depth.texture = pass.depth, desc.depth.slice = pass.slice;
        desc.depth.clear[0] = pass.clearDepth;
        desc.layers = pass.layers;
        return app_->renderEncoder(commands, desc);
    }
    void end(RenderEncoderRef encoder) {
        app_->end(encoder);
        app_->release(encoder);
    }
    void commit(CommandsRef commands) {
        app_->commit(commands);
        app_->release(commands);
    }
    std::vector<uint8_t> download(TextureRef from, uint32_t slice, size_t pixelBytes, uint32_t width = kWidth) {
        const size_t bytes = size_t(width) * kHeight * pixelBytes;
        BufferRef buffer = app_->newBuffer(bytes, StorageMode::Shared, "download");
        CommandsRef commands = app_->commandBuffer();
        BlitEncoderRef encoder = app_->blitEncoder(commands);
        app_->copyTexture(encoder, from, slice, width, kHeight, buffer, 0, uint32_t(width * pixelBytes));
        app_->end(encoder);
        app_->release(encoder);
        app_->commit(commands);
        app_->wait(commands);
        app_->release(commands);
        const auto* data = reinterpret_cast<const uint8_t*>(app_->contents(buffer));
        std::vector<uint8_t> pixels(data, data + bytes);
        app_->release(buffer);
        return pixels;
    }

    struct Picture {
        std::vector<uint8_t> rgba;
        std::vector<float> depthM;
    };
    /** What dplRender of the same context draws. */
    Picture pictureOf(DplCamera view, float wallM = 0) {
        const size_t count = size_t(kWidth) * kHeight;
        Picture made{std::vector<uint8_t>(count * 4), std::vector<float>(count)};
        const std::vector<float> wall(count, wallM);
        if (wallM > 0) view.sceneDepthM = wall.data(), view.sceneDepthCount = count;
        const DplImage image{sizeof(DplImage), 0, made.rgba.data(), made.rgba.size(), 0, made.depthM.data(), count};
        EXPECT_EQ(dplRender(context_, avatar_, &view, 1, &image), DPL_OK) << dplGetLastError();
        return made;
    }
    static std::vector<uint8_t> background(TargetFormat format) {
        std::vector<uint8_t> pixels(size_t(kWidth) * kHeight * reference::bytesOf(format));
        reference::StoredPixel stored{kBackground[0], kBackground[1], kBackground[2], kBackground[3]};
        if (reference::isSrgb(format))  // a clear colour is linear light there
            for (int c = 0; c < 3; ++c) stored[c] = reference::encodeSrgb(kBackground[c]);
        for (size_t i = 0; i < size_t(kWidth) * kHeight; ++i) reference::pack(format, stored, &pixels[i * reference::bytesOf(format)]);
        return pixels;
    }
    static std::vector<uint8_t> over(const Picture& picture, TargetFormat format) {
        std::vector<uint8_t> pixels = background(format);
        reference::compose(format, picture.rgba, pixels);
        return pixels;
    }

    std::unique_ptr<SoftwareDevice> device_;
    std::unique_ptr<Seam> app_;
    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    std::vector<TextureRef> textures_;
};

TEST_F(MetalApp, composesWhatTheRefereeComposesInEveryFormat) {
    open();
    const DplCamera view = camera();
    const Picture picture = pictureOf(view);
    uint32_t slot = 0;
    for (const auto& [format, referee] : kFormats) {
        SCOPED_TRACE(uint32_t(format));
        const uint32_t into = composer(format);
        const TextureRef colour = texture(format);
        const CommandsRef commands = prepared(slot, {&view, 1});
        const RenderEncoderRef encoder = begin(commands, {.colour = colour});
        EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
        end(encoder), commit(commands);
        slot = (slot + 1) % DPL_METAL_SLOTS;
        const size_t bytes = reference::bytesOf(referee);
        const auto drawn = download(colour, 0, bytes), want = over(picture, referee), under = background(referee);
        const double db = reference::psnrDb(referee, drawn, want);
        std::printf("[   METAL  ] MTLPixelFormat %u: %.1f dB to the referee's composition\n", uint32_t(format), db);
        EXPECT_GT(db, 60);
        size_t empty = 0;
        for (size_t i = 0; i < picture.rgba.size() / 4; ++i)
            if (picture.rgba[4 * i + 3] == 0) {
                ++empty;
                ASSERT_EQ(std::memcmp(&drawn[i * bytes], &under[i * bytes], bytes), 0) << "an empty pixel of the picture changed";
            }
        EXPECT_GT(empty, 500u);
        EXPECT_LT(empty, picture.rgba.size() / 4 - 500) << "the avatar covers pixels";
    }
}

class MetalEyes : public MetalApp, public testing::WithParamInterface<DplFill> {};
INSTANTIATE_TEST_SUITE_P(Fill, MetalEyes, testing::Values(DPL_FILL_QUADS, DPL_FILL_TILES),
                         [](const auto& info) { return std::string(info.param == DPL_FILL_TILES ? "Tiles" : "Quads"); });

TEST_P(MetalEyes, layeredDedicatedAndSharedTexturesGetBothEyes) {
    open(GetParam());
    constexpr PixelFormat kFormat = PixelFormat::BGRA8UnormSrgb, kDepth = PixelFormat::Depth32Float;
    constexpr TargetFormat kReferee = TargetFormat::Bgra8Srgb;
    // With depth, because the device of these tests has only those kernels that fill tiles.
    const uint32_t layered = composer(kFormat, 2, kDepth, DPL_DRAW_DEPTH), single = composer(kFormat, 0, kDepth, DPL_DRAW_DEPTH);
    const TextureRef array = texture(kFormat, 2), wide = texture(kFormat, 0, 1, 2 * kWidth), arrayDepth = texture(kDepth, 2),
                     wideDepth = texture(kDepth, 0, 1, 2 * kWidth);
    for (const float turn : {0.0f, 0.07f}) {  // the eyes of a canted pair are a frame each
        const DplCamera eyes[2] = {camera(-0.03f), camera(0.03f, turn)};
        const std::vector<uint8_t> want[2] = {over(pictureOf(eyes[0]), kReferee), over(pictureOf(eyes[1]), kReferee)};
        const auto expect = [&](const char* layout, uint32_t eye, const std::vector<uint8_t>& drawn) {
            const double db = reference::psnrDb(kReferee, drawn, want[eye]), other = reference::psnrDb(kReferee, drawn, want[1 - eye]);
            std::printf("[   METAL  ] %s, turned by %.2f, eye %u: %.1f dB (the other eye's: %.1f)\n", layout, double(turn), eye, db, other);
            EXPECT_GT(db, 50);
            EXPECT_LT(other, db - 10) << "the eyes differ";
        };
        CommandsRef commands = prepared(0, eyes);
        RenderEncoderRef encoder = begin(commands, {.colour = array, .depth = arrayDepth, .layers = 2});
        EXPECT_EQ(dplMetalCompose(context_, layered, encoder.object, 0, 0, 0, 0), DPL_OK) << dplGetLastError();
        end(encoder), commit(commands);
        for (uint32_t eye : {0u, 1u}) expect("layered", eye, download(array, eye, 4));

        commands = prepared(1, eyes);
        for (uint32_t eye : {0u, 1u}) {
            encoder = begin(commands, {.colour = array, .depth = arrayDepth, .slice = eye});
            EXPECT_EQ(dplMetalCompose(context_, single, encoder.object, 1, eye, 0, 0), DPL_OK) << dplGetLastError();
            end(encoder);
        }
        commit(commands);
        for (uint32_t eye : {0u, 1u}) expect("dedicated", eye, download(array, eye, 4));

        commands = prepared(2, eyes);
        encoder = begin(commands, {.colour = wide, .depth = wideDepth});
        for (uint32_t eye : {0u, 1u})
            EXPECT_EQ(dplMetalCompose(context_, single, encoder.object, 2, eye, int32_t(eye * kWidth), 0), DPL_OK) << dplGetLastError();
        end(encoder), commit(commands);
        const auto both = download(wide, 0, 4, 2 * kWidth);
        for (uint32_t eye : {0u, 1u}) {
            std::vector<uint8_t> half;
            for (uint32_t y = 0; y < kHeight; ++y)
                half.insert(half.end(), &both[(size_t(y) * 2 + eye) * kWidth * 4], &both[(size_t(y) * 2 + eye) * kWidth * 4] + kWidth * 4);
            expect("shared", eye, half);
        }
    }
}

TEST_P(MetalEyes, writesTheDepthThatIsReadBack) {
    open(GetParam());
    constexpr float kSpan = kFar - kNear;
    constexpr std::array<float, 2> kStored[] = {{kFar / kSpan, -kFar * kNear / kSpan}, {0, kNear}};  // usual; reversed and infinite
    constexpr PixelFormat kColour = PixelFormat::RGBA16Float;
    const DplCamera view = camera();
    const Picture picture = pictureOf(view);
    const uint32_t into = composer(kColour, 0, PixelFormat::Depth32Float, DPL_DRAW_DEPTH);
    for (uint32_t slot = 0; slot < 2; ++slot) {
        const auto [scale, offset] = kStored[slot];
        const StoredDepth stored{scale, offset};
        const TextureRef colour = texture(kColour), depth = texture(PixelFormat::Depth32Float);
        const CommandsRef commands = prepared(slot, {&view, 1});
        // Nearer than a part of the avatar, which stands at 1.42 to 1.78 m.
        const double before = stored.of(1.6);
        const RenderEncoderRef encoder = begin(commands, {.colour = colour, .depth = depth, .clearDepth = before});
        EXPECT_EQ(dplMetalComposeDepth(context_, into, encoder.object, slot, 0, 0, 0, scale, offset), DPL_OK) << dplGetLastError();
        end(encoder), commit(commands);
        const auto bytes = download(depth, 0, 4);
        std::vector<double> want(picture.depthM.size(), double(float(before)));
        reference::composeDepth(picture.rgba, picture.depthM, stored, 1, want);
        size_t written = 0;
        double worst = 0;
        for (size_t i = 0; i < want.size(); ++i) {
            float got;
            std::memcpy(&got, &bytes[4 * i], 4);
            written += want[i] != double(float(before));
            worst = std::max(worst, std::abs(double(got) - want[i]));
        }
        std::printf("[   METAL  ] depth of %zu pixels, at most %.2g apart\n", written, worst);
        EXPECT_GT(written, 100u);
        EXPECT_LT(worst, 1e-6) << "a few steps of a float below 1";
    }
}

TEST_P(MetalEyes, hidesWhatLiesBehindADepthTextureOfAnyType) {
    open(GetParam());
    constexpr float kWallM = 1.6f;
    const DplCamera view = camera();
    constexpr PixelFormat kColour = PixelFormat::RGBA8Unorm;
    const uint32_t into = composer(kColour, 0, PixelFormat::Depth32Float, DPL_DRAW_DEPTH);
    const TextureRef colour = texture(kColour), own = texture(PixelFormat::Depth32Float);
    const auto want = over(pictureOf(view, kWallM), TargetFormat::Rgba8), free = over(pictureOf(view), TargetFormat::Rgba8);
    EXPECT_LT(reference::psnrDb(TargetFormat::Rgba8, want, free), 40) << "the wall hides nothing";
    uint32_t slot = 0;
    for (const uint32_t samples : {1u, 4u}) {
        for (const uint32_t layers : {0u, 2u}) {
            const TextureRef wall = texture(PixelFormat::Depth32Float, layers, samples), other = texture(kColour, layers, samples);
            const uint32_t slice = layers ? 1 : 0;
            CommandsRef commands = app_->commandBuffer();
            end(begin(commands, {.colour = other, .depth = wall, .slice = slice, .clearDepth = double(kNear / kWallM)}));
            const DplMetalSceneDepth depth{sizeof depth, slice, wall.object, 0, 0, 0, kNear};
            EXPECT_EQ(dplMetalPrepare(context_, commands.object, slot, &avatar_, 1, &view, 1, &depth), DPL_OK) << dplGetLastError();
            const RenderEncoderRef encoder = begin(commands, {.colour = colour, .depth = own});
            EXPECT_EQ(dplMetalCompose(context_, into, encoder.object, slot, 0, 0, 0), DPL_OK) << dplGetLastError();
            end(encoder), commit(commands);
            const double db = reference::psnrDb(TargetFormat::Rgba8, download(colour, 0, 4), want);
            std::printf("[   METAL  ] behind a wall of %u samples, %u layers: %.1f dB\n", samples, layers, db);
            EXPECT_GT(db, 60);
            slot = (slot + 1) % DPL_METAL_SLOTS;
        }
    }
}

}  // namespace
}  // namespace dpl::mtl
