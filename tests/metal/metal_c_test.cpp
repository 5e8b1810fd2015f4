// SPDX-License-Identifier: Apache-2.0
// doppel_metal.h from C: every function is called, and what C composed is what the referee composes.
#include "tests/metal/metal_app.h"
#include "tests/metal/metal_from_c.h"

namespace dpl::mtl {
namespace {

constexpr PixelFormat kColourFormat = PixelFormat::RGBA8Unorm, kDepthFormat = PixelFormat::Depth32Float;

class MetalFromC : public MetalApp {
protected:
    static void* beginPass(void* program) {
        auto* test = static_cast<MetalFromC*>(program);
        test->encoder_ = test->begin(test->prepared_, {.colour = test->colour_, .depth = test->depth_, .clearDepth = 0});
        return test->encoder_.object;
    }
    static void finish(void* program) {
        auto* test = static_cast<MetalFromC*>(program);
        if (test->encoder_) {
            test->end(test->encoder_);
            test->commit(test->prepared_);
            test->commit(test->uploaded_);
            test->encoder_ = {};
        }
        test->device_->finish();
    }

    CommandsRef prepared_, uploaded_;
    RenderEncoderRef encoder_;
    TextureRef colour_, depth_;
};

TEST_F(MetalFromC, everyFunctionIsCalledAndDraws) {
    open();
    colour_ = texture(kColourFormat), depth_ = texture(kDepthFormat);
    const TextureRef submitted = texture(kColourFormat);
    CommandsRef cleared = app_->commandBuffer();
    end(begin(cleared, {.colour = submitted}));
    commit(cleared);
    prepared_ = app_->commandBuffer(), uploaded_ = app_->commandBuffer();
    const std::vector<uint8_t> file = tubeFile();
    FromC app{};
    app.device = device_->device(), app.queue = device_->queue();
    app.prepared = prepared_.object, app.uploaded = uploaded_.object, app.submitted = submitted.object;
    app.colourFormat = uint32_t(kColourFormat), app.depthFormat = uint32_t(kDepthFormat);
    app.beginPass = beginPass, app.finish = finish, app.program = this;
    BufferRef rows = app_->newBuffer(1 << 20, StorageMode::Shared, "rows");
    app.rows = rows.object, app.rowsBytes = 1 << 20;
    app.avatar = file.data(), app.avatarBytes = file.size(), app.view = camera();
    const char* failed = callMetalFromC(&app);
    const auto* position = reinterpret_cast<const float*>(app_->contents(rows));
    EXPECT_TRUE(std::abs(position[0]) < 1 && position[1] != 0) << "a splat of the tube";
    app_->release(rows);
    ASSERT_EQ(failed, nullptr) << failed << ": " << dplGetLastError();
    const std::vector<uint8_t> want = over(pictureOf(camera()), TargetFormat::Rgba8);
    EXPECT_LT(reference::psnrDb(TargetFormat::Rgba8, background(TargetFormat::Rgba8), want), 30) << "nothing is drawn";
    EXPECT_GT(reference::psnrDb(TargetFormat::Rgba8, download(colour_, 0, 4), want), 60);
    EXPECT_GT(reference::psnrDb(TargetFormat::Rgba8, download(submitted, 0, 4), want), 60);
    const std::vector<uint8_t> depth = download(depth_, 0, 4);
    EXPECT_GT(size_t(depth.size()) - size_t(std::count(depth.begin(), depth.end(), 0)), 1000u) << "reversed depth, cleared to 0";
}

}  // namespace
}  // namespace dpl::mtl
