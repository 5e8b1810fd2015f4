// SPDX-License-Identifier: Apache-2.0
// What a headset is given: for every kind of view the picture that the software renderer draws of the same camera, with the room's depth
// beside it, and nothing allocated on the way.
#include <cmath>

#include "apps/bench/count_allocations.h"
#include "tests/reference/composition.h"
#include "tests/xr/xr_fixture.h"

namespace dpl::test {
namespace {

using mockxr::SubmittedLayer;
using mockxr::SubmittedView;
using mockxr::ViewSetting;

constexpr XrVector3f kHead{0.1f, 1.05f, 2.9f};

XrQuaternionf turned(float yawRad, float pitchRad) {
    const float cy = std::cos(yawRad / 2), sy = std::sin(yawRad / 2), cp = std::cos(pitchRad / 2), sp = std::sin(pitchRad / 2);
    return {cy * sp, sy * cp, -sy * sp, cy * cp};
}

/** The projection layer of the last frame, if it has one. */
const SubmittedLayer* projection(const mockxr::SubmittedFrame& frame) {
    for (const SubmittedLayer& layer : frame.layers)
        if (layer.type == XR_TYPE_COMPOSITION_LAYER_PROJECTION) return &layer;
    return nullptr;
}

/** Each view: where the runtime said, fresh, the picture of the software renderer, not empty. */
void expectPictures(const mockxr::SubmittedFrame& frame, const mockxr::Settings& settings) {
    const SubmittedLayer* layer = projection(frame);
    ASSERT_TRUE(layer);
    ASSERT_EQ(layer->views.size(), settings.views.size());
    for (size_t i = 0; i < layer->views.size(); ++i) {
        SCOPED_TRACE("view " + std::to_string(i));
        const SubmittedView& view = layer->views[i];
        const XrPosef head = settings.worldFromHead(frame.displayTime);
        const ViewSetting& set = settings.views[i];
        EXPECT_TRUE(view.fresh);
        EXPECT_EQ(view.fov.angleLeft, set.fov.angleLeft);
        EXPECT_EQ(view.fov.angleDown, set.fov.angleDown);
        // The tests turn views and not heads, so that this sum is right.
        const XrPosef worldFromView{set.headFromView.orientation,
                                    {head.position.x + set.headFromView.position.x, head.position.y + set.headFromView.position.y,
                                     head.position.z + set.headFromView.position.z}};
        const auto width = uint32_t(view.rect.extent.width), height = uint32_t(view.rect.extent.height);
        EXPECT_EQ(width, settings.widthPx);
        EXPECT_EQ(height, settings.heightPx);
        const DplCamera camera = cameraOf(worldFromView, set.fov, width, height);
        const auto expected = expectedPicture(camera), drawn = asRgba8Srgb(view);
        EXPECT_GE(reference::psnrDb(reference::TargetFormat::Rgba8Srgb, drawn, expected, 3), 50.0);
        EXPECT_GT(differingPixels(expected, expectedPicture(camera, false)), width * height / 100) << "the avatar is in the picture";
    }
}

class XrFrames : public XrTest {
protected:
    void draw(const mockxr::Settings& settings, xr::SessionOptions options = opaque()) {
        open(settings, options);
        if (HasFatalFailure()) return;
        ASSERT_TRUE(run(xr::Step::Drew));
        ASSERT_EQ(step(), xr::Step::Drew) << "a second one, in images whose contents were destroyed";
        expectPictures(mockxr::lastFrame(), settings);
    }
};

mockxr::Settings canted() {
    mockxr::Settings settings;
    settings.views = {{{turned(0.15f, 0.05f), {-0.033f, 0.01f, 0}}, {-0.75f, 0.6f, 0.5f, -0.7f}},
                      {{turned(-0.2f, -0.1f), {0.031f, 0, 0.005f}}, {-0.5f, 0.8f, 0.75f, -0.55f}}};
    return settings;
}

TEST_F(XrFrames, twoAsymmetricViews) {
    draw(userAt(kHead));
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_TRUE(projection(frame));
    EXPECT_NE(projection(frame)->views[0].pixels, projection(frame)->views[1].pixels);
}

TEST_F(XrFrames, cantedViews) {
    mockxr::Settings settings = userAt(kHead);
    settings.views = canted().views;
    settings.widthPx = 72, settings.heightPx = 56;
    draw(settings);
}

TEST_F(XrFrames, oneView) {
    mockxr::Settings settings = userAt(kHead);
    settings.viewConfiguration = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
    settings.views = {{{{0, 0, 0, 1}, {0, 0, 0}}, {-0.4f, 0.5f, 0.6f, -0.3f}}};
    draw(settings);
}

TEST_F(XrFrames, fourViews) {
    mockxr::Settings settings = userAt(kHead);
    settings.viewConfiguration = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_QUAD_VARJO;
    settings.extensions.push_back(XR_VARJO_QUAD_VIEWS_EXTENSION_NAME);
    settings.views.insert(settings.views.end(), {{{turned(0.1f, 0), {-0.032f, 0, 0}}, {-0.3f, 0.25f, 0.3f, -0.3f}},
                                                 {{turned(-0.1f, 0), {0.032f, 0, 0}}, {-0.25f, 0.3f, 0.3f, -0.3f}}});
    draw(settings);
}

TEST_F(XrFrames, anImageForEachView) {
    xr::SessionOptions options = opaque();
    options.array = false;
    draw(userAt(kHead), options);
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_TRUE(projection(frame));
    EXPECT_NE(projection(frame)->views[0].swapchain, projection(frame)->views[1].swapchain);
}

TEST_F(XrFrames, oneArrayImageForBothViews) {
    draw(userAt(kHead));
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_TRUE(projection(frame));
    EXPECT_EQ(projection(frame)->views[0].swapchain, projection(frame)->views[1].swapchain);
    EXPECT_EQ(projection(frame)->views[0].layer, 0u);
    EXPECT_EQ(projection(frame)->views[1].layer, 1u);
    EXPECT_EQ(scene_->multiview, runtime_->multiview());
}

TEST_F(XrFrames, everyColourFormat) {
    for (const int64_t format : {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R16G16B16A16_SFLOAT}) {
        SCOPED_TRACE(format);
        mockxr::Settings settings = userAt(kHead);
        settings.formats = {VK_FORMAT_A2B10G10R10_UNORM_PACK32, format, VK_FORMAT_D16_UNORM};
        draw(settings);
        EXPECT_EQ(scene_->colourFormat, VkFormat(format));
        close();
    }
}

/** Depth as the headset gets it: reversed, infinite, nearM / z. */
void expectDepth(const mockxr::SubmittedFrame& frame, float tolerance) {
    const SubmittedLayer* layer = projection(frame);
    ASSERT_TRUE(layer);
    for (const SubmittedView& view : layer->views) {
        ASSERT_TRUE(view.hasDepth);
        EXPECT_EQ(view.minDepth, 0);
        EXPECT_EQ(view.maxDepth, 1);
        EXPECT_TRUE(std::isinf(view.nearZ)) << "depth 0 is infinitely far";
        EXPECT_FLOAT_EQ(view.farZ, kNearM) << "depth 1 is the near plane";
        const auto width = uint32_t(view.rect.extent.width);
        ASSERT_EQ(view.depth.size(), size_t(width) * uint32_t(view.rect.extent.height));
        for (uint32_t x = 0; x < width; ++x) {
            const float depth = view.depth[width * 5 + x];
            EXPECT_NEAR(depth, x < wallFromPx(width) ? 0 : kNearM / kWallM, tolerance) << "column " << x;
        }
    }
}

TEST_F(XrFrames, theLayerHasTheRoomsDepth) {
    draw(userAt(kHead));
    expectDepth(mockxr::lastFrame(), 1e-7f);
}

TEST_F(XrFrames, depthOf16Bits) {
    mockxr::Settings settings = userAt(kHead);
    settings.formats = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D16_UNORM};
    draw(settings);
    expectDepth(mockxr::lastFrame(), 0.6f / 65535);
}

TEST_F(XrFrames, depthBesideStencil) {
    mockxr::Settings settings = userAt(kHead);
    settings.formats = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D32_SFLOAT_S8_UINT};
    draw(settings);
    expectDepth(mockxr::lastFrame(), 1e-7f);
}

TEST_F(XrFrames, withoutDepthLayers) {
    mockxr::Settings settings = userAt(kHead);
    std::erase(settings.extensions, XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME);
    draw(settings);
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_TRUE(projection(frame));
    EXPECT_FALSE(projection(frame)->views[0].hasDepth);
}

TEST_F(XrFrames, withoutDepthFormats) {
    mockxr::Settings settings = userAt(kHead);
    settings.formats = {VK_FORMAT_R8G8B8A8_SRGB};
    draw(settings);
}

TEST_F(XrFrames, thePredictedTimeMovesTheEyes) {
    mockxr::Settings settings = userAt(kHead);
    settings.worldFromHead = [](XrTime time) { return XrPosef{{0, 0, 0, 1}, {0.1f * float(std::sin(double(time) * 1e-8)), 1, 2.9f}}; };
    draw(settings);
    ASSERT_EQ(step(), xr::Step::Drew);
    expectPictures(mockxr::lastFrame(), settings);
}

TEST_F(XrFrames, capturedViewsAreTheSubmittedOnes) {
    xr::SessionOptions options = opaque();
    options.capture = true;
    const mockxr::Settings settings = userAt(kHead);
    draw(settings, options);
    session_->captureNextFrame();
    ASSERT_EQ(step(), xr::Step::Drew);
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_TRUE(projection(frame));
    ASSERT_EQ(session_->captured().size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
        const xr::CapturedView& captured = session_->captured()[i];
        EXPECT_EQ(captured.colour, projection(frame)->views[i].pixels);
        EXPECT_EQ(captured.widthPx, settings.widthPx);
        EXPECT_FLOAT_EQ(captured.depthM[captured.widthPx - 1], kWallM);
        EXPECT_EQ(captured.depthM[0], 0);
    }
}

TEST_F(XrFrames, camerasAreThoseOfTheViews) {
    const mockxr::Settings settings = userAt(kHead);
    draw(settings);
    ASSERT_EQ(session_->cameras().size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
        const DplCamera& camera = session_->cameras()[i];
        const DplCamera expected =
            cameraOf({{0, 0, 0, 1}, {kHead.x + (i ? 0.032f : -0.032f), kHead.y, kHead.z}}, settings.views[i].fov, 64, 64);
        EXPECT_NEAR(camera.fx, expected.fx, 1e-4f);
        EXPECT_NEAR(camera.fy, expected.fy, 1e-4f);
        EXPECT_NEAR(camera.cx, expected.cx, 1e-4f);
        EXPECT_NEAR(camera.cy, expected.cy, 1e-4f);
        for (size_t k = 0; k < 12; ++k) EXPECT_NEAR(camera.viewFromWorld[k], expected.viewFromWorld[k], 1e-6f) << k;
    }
}

/** Allocations outside the mock: the hook stops the count while a call is inside it. */
TEST_F(XrFrames, aWarmFrameAllocatesNothing) {
    mockxr::Settings settings = userAt(kHead);
    settings.capture = settings.validation = false;
    open(settings, opaque());
    ASSERT_TRUE(run(xr::Step::Drew));
    for (int i = 0; i < 4; ++i) ASSERT_EQ(step(), xr::Step::Drew);
    std::optional<AllocationCount> count;
    uint64_t allocations = 0;
    mockxr::settings().onCall = [&](bool enters) {
        if (enters)
            allocations += count->stop(), count.reset();
        else
            count.emplace(CountedThreads::Own);
    };
    count.emplace(CountedThreads::Own);
    const auto did = session_->frame(*scene_);
    allocations += count->stop();
    count.reset();
    mockxr::settings().onCall = nullptr;
    ASSERT_TRUE(did);
    EXPECT_EQ(*did, xr::Step::Drew);
    EXPECT_EQ(allocations, 0u);
}

}  // namespace
}  // namespace dpl::test
