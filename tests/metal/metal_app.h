// SPDX-License-Identifier: Apache-2.0
// A Metal program with a device, textures, passes and an avatar: what the tests of doppel_metal.h have in common.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel_metal.h"
#include "sdk/include/doppel/doppel_vulkan.h"
#include "tests/metal/software/software_device.h"
#include "tests/reference/composition.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl::mtl {
using reference::StoredDepth;
using reference::TargetFormat;

constexpr uint32_t kWidth = 72, kHeight = 60;
constexpr float kNear = 0.1f, kFar = 20;
constexpr double kBackground[4] = {0.25, 0.5, 0.75, 1};

inline std::vector<uint8_t> tubeFile() {
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

}  // namespace dpl::mtl
