// SPDX-License-Identifier: Apache-2.0
// Avatars in a Metal program's own frames, through doppel_metal.h on the software device: the pixels that the referee composes, in every
// format and layout of both eyes; depth in and out.
#include "tests/metal/metal_app.h"

namespace dpl::mtl {
namespace {

struct FormatCase {
    PixelFormat format;
    TargetFormat referee;
};
constexpr FormatCase kFormats[] = {
    {PixelFormat::RGBA8Unorm, TargetFormat::Rgba8},         {PixelFormat::BGRA8Unorm, TargetFormat::Bgra8},
    {PixelFormat::RGBA8UnormSrgb, TargetFormat::Rgba8Srgb}, {PixelFormat::BGRA8UnormSrgb, TargetFormat::Bgra8Srgb},
    {PixelFormat::RGBA16Float, TargetFormat::Rgba16f},      {PixelFormat::RGB10A2Unorm, TargetFormat::A2b10g10r10},
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
