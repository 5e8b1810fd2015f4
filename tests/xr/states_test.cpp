// SPDX-License-Identifier: Apache-2.0
// A runtime that stops, hides, moves and misbehaves: the session goes on wherever it can, and says why where it cannot.
#include <cmath>
#include <limits>

#include "tests/xr/xr_fixture.h"

namespace dpl::test {
namespace {

constexpr XrVector3f kHead{0, 1, 2.9f};

class XrStates : public XrTest {
protected:
    void openAndDraw(const mockxr::Settings& settings, xr::SessionOptions options = opaque()) {
        open(settings, options);
        if (!HasFatalFailure()) {
            ASSERT_TRUE(run(xr::Step::Drew));
        }
    }
    /** frame() until it is an error, whose sentence has `text`. */
    void expectError(const char* text) {
        for (int i = 0; i < 20; ++i)
            if (const auto did = session_->frame(*scene_); !did) {
                EXPECT_NE(did.error().message.find(text), std::string::npos) << did.error().message;
                return;
            }
        ADD_FAILURE() << "no error with \"" << text << "\"; last complaint: " << session_->lastComplaint();
    }
    /** Views or formats that cannot be drawn are an error of frame(), not of the runtime. */
    void expectErrorWith(const mockxr::Settings& settings, const char* text) {
        open(settings, opaque());
        if (!HasFatalFailure()) expectError(text);
        close();
    }
};

TEST_F(XrStates, aHiddenFrameHasNoLayer) {
    openAndDraw(userAt(kHead));
    mockxr::settings().shouldRender = false;
    EXPECT_EQ(step(), xr::Step::Hidden);
    EXPECT_TRUE(mockxr::lastFrame().layers.empty());
    mockxr::settings().shouldRender.reset();
    EXPECT_EQ(step(), xr::Step::Drew);
    EXPECT_FALSE(mockxr::lastFrame().layers.empty());
}

TEST_F(XrStates, stopsAndStartsAgain) {
    openAndDraw(userAt(kHead));
    mockxr::sendState(XR_SESSION_STATE_STOPPING);
    EXPECT_NE(step(), xr::Step::Drew);
    EXPECT_EQ(mockxr::calls()["xrEndSession"], 1u);
    EXPECT_TRUE(run(xr::Step::Drew)) << "READY came again";
    EXPECT_EQ(mockxr::calls()["xrBeginSession"], 2u);
    EXPECT_EQ(mockxr::calls()["xrCreateSession"], 1u) << "the session was begun again, not made again";
}

TEST_F(XrStates, endsWhenAsked) {
    openAndDraw(userAt(kHead));
    session_->requestExit();
    EXPECT_TRUE(run(xr::Step::Ended));
    EXPECT_EQ(step(), xr::Step::Ended);
    EXPECT_EQ(mockxr::calls()["xrRequestExitSession"], 1u);
    EXPECT_EQ(mockxr::calls()["xrEndSession"], 1u);
}

TEST_F(XrStates, endsWhenTheUserEndsIt) {
    openAndDraw(userAt(kHead));
    mockxr::settings().automaticStates = false;
    for (const XrSessionState state : {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING})
        mockxr::sendState(state);
    EXPECT_EQ(step(), xr::Step::Idle);
    EXPECT_FALSE(mockxr::sessionRunning());
    mockxr::sendState(XR_SESSION_STATE_IDLE);
    mockxr::sendState(XR_SESSION_STATE_EXITING);
    EXPECT_TRUE(run(xr::Step::Ended));
}

TEST_F(XrStates, lossPendingMakesANewSession) {
    openAndDraw(userAt(kHead));
    mockxr::sendState(XR_SESSION_STATE_LOSS_PENDING);
    EXPECT_TRUE(run(xr::Step::Lost));
    EXPECT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(mockxr::calls()["xrCreateSession"], 2u);
    EXPECT_EQ(mockxr::calls()["xrDestroySession"], 1u);
}

TEST_F(XrStates, instanceLossPendingIsAnError) {
    openAndDraw(userAt(kHead));
    mockxr::sendInstanceLossPending();
    expectError("about to go away");
}

TEST_F(XrStates, statesOutOfOrderBreakNothing) {
    mockxr::Settings settings = userAt(kHead);
    settings.automaticStates = false;
    open(settings, opaque());
    if (HasFatalFailure()) return;
    EXPECT_EQ(step(), xr::Step::Idle);
    for (const XrSessionState early : {XR_SESSION_STATE_STOPPING, XR_SESSION_STATE_FOCUSED, XR_SESSION_STATE_VISIBLE,
                                       XR_SESSION_STATE_UNKNOWN, XR_SESSION_STATE_MAX_ENUM, XR_SESSION_STATE_IDLE}) {
        mockxr::sendState(early);
        EXPECT_EQ(step(), xr::Step::Idle) << early;
    }
    mockxr::sendState(XR_SESSION_STATE_READY);
    mockxr::sendState(XR_SESSION_STATE_READY);
    EXPECT_EQ(step(), xr::Step::Hidden);
    mockxr::sendState(XR_SESSION_STATE_FOCUSED);
    EXPECT_EQ(step(), xr::Step::Drew);
    mockxr::sendState(XR_SESSION_STATE_READY);
    step();
    mockxr::sendState(XR_SESSION_STATE_FOCUSED);
    EXPECT_EQ(step(), xr::Step::Drew) << "READY while it runs";
    EXPECT_EQ(mockxr::calls()["xrBeginSession"], 1u);
}

TEST_F(XrStates, drawsOnlyWhatSomebodySees) {
    openAndDraw(userAt(kHead));
    mockxr::sendState(XR_SESSION_STATE_SYNCHRONIZED);
    EXPECT_EQ(step(), xr::Step::Hidden);
    mockxr::sendState(XR_SESSION_STATE_VISIBLE);
    EXPECT_EQ(step(), xr::Step::Drew);
    EXPECT_EQ(session_->state(), XR_SESSION_STATE_VISIBLE);
}

TEST_F(XrStates, viewsThatCannotBeDrawnHideTheFrame) {
    openAndDraw(userAt(kHead));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    using Spoil = void (*)(XrViewState&, std::span<XrView>, float);
    const std::pair<const char*, Spoil> spoils[] = {
        {"no valid orientation", [](XrViewState& s, std::span<XrView>, float) { s.viewStateFlags = XR_VIEW_STATE_POSITION_VALID_BIT; }},
        {"no valid position", [](XrViewState& s, std::span<XrView>, float) { s.viewStateFlags = XR_VIEW_STATE_ORIENTATION_VALID_BIT; }},
        {"position NaN", [](XrViewState&, std::span<XrView> v, float nan) { v[1].pose.position.y = nan; }},
        {"orientation NaN", [](XrViewState&, std::span<XrView> v, float nan) { v[0].pose.orientation.x = nan; }},
        {"orientation zero",
         [](XrViewState&, std::span<XrView> v, float) {
             v[1].pose.orientation = {0, 0, 0, 0};
         }},
        {"orientation too long",
         [](XrViewState&, std::span<XrView> v, float) {
             v[1].pose.orientation = {0, 0, 0, 1.5f};
         }},
        {"angle NaN", [](XrViewState&, std::span<XrView> v, float nan) { v[1].fov.angleUp = nan; }},
        {"no field of view",
         [](XrViewState&, std::span<XrView> v, float) {
             v[0].fov = {0, 0, 0, 0};
         }},
        {"turned field of view", [](XrViewState&, std::span<XrView> v, float) { v[0].fov.angleLeft = 0.9f; }},
        {"more than a half space", [](XrViewState&, std::span<XrView> v, float) { v[0].fov.angleRight = 2; }}};
    for (const auto& [name, spoil] : spoils) {
        SCOPED_TRACE(name);
        mockxr::settings().spoilViews = [&, spoil = spoil](XrTime, XrViewState& state, std::span<XrView> views) {
            spoil(state, views, nan);
        };
        EXPECT_EQ(step(), xr::Step::Hidden);
        EXPECT_TRUE(mockxr::lastFrame().layers.empty());
        EXPECT_FALSE(session_->lastComplaint().empty());
        mockxr::settings().spoilViews = nullptr;
        EXPECT_EQ(step(), xr::Step::Drew);
    }
}

TEST_F(XrStates, aSlightlyLongOrientationIsNormalised) {
    openAndDraw(userAt(kHead));
    mockxr::settings().spoilViews = [](XrTime, XrViewState&, std::span<XrView> views) { views[0].pose.orientation.w = 1.004f; };
    EXPECT_EQ(step(), xr::Step::Drew);
    EXPECT_NEAR(mockxr::lastFrame().layers.at(0).views[0].pose.orientation.w, 1, 1e-6f);
}

TEST_F(XrStates, imagesThatComeLate) {
    openAndDraw(userAt(kHead));
    const uint64_t next = mockxr::calls()["xrWaitSwapchainImage"] + 1;
    mockxr::fail({"xrWaitSwapchainImage", next, 2, XR_TIMEOUT_EXPIRED});
    EXPECT_EQ(step(), xr::Step::Hidden);
    EXPECT_TRUE(mockxr::lastFrame().layers.empty());
    EXPECT_TRUE(run(xr::Step::Drew));
    EXPECT_EQ(step(), xr::Step::Drew);
    EXPECT_TRUE(mockxr::lastFrame().layers.at(0).views[0].fresh);
}

TEST_F(XrStates, imagesThatNeverCome) {
    openAndDraw(userAt(kHead));
    mockxr::fail({"xrWaitSwapchainImage", mockxr::calls()["xrWaitSwapchainImage"] + 1, 1000, XR_TIMEOUT_EXPIRED});
    expectError("image");
}

TEST_F(XrStates, formatsThatDoNotFit) {
    mockxr::Settings settings = userAt(kHead);
    settings.formats = {};
    expectErrorWith(settings, "neither in R8G8B8A8_SRGB");
    settings.formats = {VK_FORMAT_A2B10G10R10_UNORM_PACK32, VK_FORMAT_BC7_SRGB_BLOCK, -1, INT64_MAX, VK_FORMAT_D32_SFLOAT};
    expectErrorWith(settings, "neither in R8G8B8A8_SRGB");
}

TEST_F(XrStates, viewsThatDoNotFit) {
    mockxr::Settings settings = userAt(kHead);
    settings.views.clear();
    expectErrorWith(settings, "view");
    settings = userAt(kHead);
    settings.views.resize(3, settings.views[0]);
    expectErrorWith(settings, "view");
    settings = userAt(kHead);
    settings.widthPx = 0;
    expectErrorWith(settings, "without pixels");
}

TEST_F(XrStates, sizesAreClampedToWhatTheSystemAllows) {
    mockxr::Settings settings = userAt(kHead);
    settings.widthPx = 200, settings.heightPx = 40, settings.maxSidePx = 48;
    openAndDraw(settings);
    const XrExtent2Di extent = mockxr::lastFrame().layers.at(0).views[0].rect.extent;
    EXPECT_EQ(extent.width, 48);
    EXPECT_EQ(extent.height, 40);
}

TEST_F(XrStates, runtimesThatCannotBeUsed) {
    mockxr::Settings settings;
    settings.hasSystem = false;
    mockxr::reset(settings);
    auto runtime = xr::Runtime::create({});
    ASSERT_FALSE(runtime);
    EXPECT_NE(runtime.error().message.find("headset"), std::string::npos) << runtime.error().message;
    settings = {};
    std::erase(settings.extensions, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME);
    mockxr::reset(settings);
    runtime = xr::Runtime::create({});
    ASSERT_FALSE(runtime);
    EXPECT_NE(runtime.error().message.find("XR_KHR_vulkan_enable2"), std::string::npos) << runtime.error().message;
    // The loader keeps the list of extensions until it has made an instance or failed to: let it fail.
    mockxr::reset({});
    EXPECT_FALSE(xr::Runtime::create({}));
}

TEST_F(XrStates, onAndroidTheRuntimeIsToldTheApp) {
    struct {
        XrStructureType type = XR_TYPE_INSTANCE_CREATE_INFO_ANDROID_KHR;
        const void* next = nullptr;
        void *vm = this, *activity = this;
    } app;  // XrInstanceCreateInfoAndroidKHR, which only Android's headers declare
    xr::RuntimeOptions options;
    options.instanceExtensions = {"XR_KHR_android_create_instance"};
    options.instanceNext = &app;
    mockxr::Settings settings = userAt(kHead);
    settings.extensions.push_back(options.instanceExtensions[0]);
    mockxr::reset(settings);
    auto runtime = xr::Runtime::create(options);  // the mock refuses an instance without the app
    ASSERT_TRUE(runtime) << runtime.error().message;
    runtime->reset();
    mockxr::reset(userAt(kHead));
    runtime = xr::Runtime::create(options);
    ASSERT_FALSE(runtime);
    EXPECT_NE(runtime.error().message.find("XR_KHR_android_create_instance"), std::string::npos) << runtime.error().message;
}

TEST_F(XrStates, theUserMovesTheOrigin) {
    openAndDraw(userAt(kHead));
    const DplCamera before = session_->cameras()[0];
    mockxr::recentre({{0, 0, 0, 1}, {0.25f, 1.6f, -0.5f}});
    std::optional<XrPosef> moved;
    for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(step(), xr::Step::Drew);
        if (session_->originMoved()) {
            EXPECT_FALSE(moved) << "it is told once";
            moved = session_->originMoved();
        }
    }
    ASSERT_TRUE(moved);
    EXPECT_FLOAT_EQ(moved->position.x, 0.25f);
    EXPECT_FLOAT_EQ(moved->position.z, -0.5f);
    const DplCamera& after = session_->cameras()[0];
    EXPECT_NEAR(after.viewFromWorld[3], before.viewFromWorld[3] + 0.25f, 1e-5f) << "the camera has moved against the world";
    EXPECT_NEAR(after.viewFromWorld[11], before.viewFromWorld[11] + 0.5f, 1e-5f) << "along the view, which looks along -z";
}

TEST_F(XrStates, theFloorIsWhereTheRuntimeKnowsIt) {
    mockxr::Settings settings = userAt(kHead);
    for (const bool stage : {true, false}) {
        std::erase(settings.extensions, "XR_EXT_local_floor");
        if (!stage) std::erase(settings.referenceSpaces, XR_REFERENCE_SPACE_TYPE_STAGE);
        openAndDraw(settings);
        EXPECT_NEAR(session_->cameras()[0].viewFromWorld[7], kHead.y, 1e-5f)
            << (stage ? "the stage" : "the local space, 1.6 m above the floor");
        close();
    }
}

TEST_F(XrStates, theDisplaysRate) {
    xr::SessionOptions options = opaque();
    options.refreshHz = 88;
    openAndDraw(userAt(kHead), options);
    EXPECT_EQ(mockxr::refreshRateHz(), 90) << "the nearest of 72 and 90";
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_FLOAT_EQ(session_->refreshHz(), 90);
    mockxr::changeRefreshRate(72);
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_FLOAT_EQ(session_->refreshHz(), 72);
    EXPECT_NEAR(session_->lastFrame().periodS, 1.0 / 72, 1e-6);
}

TEST_F(XrStates, controllersPointAndSelect) {
    mockxr::Settings settings = userAt(kHead);
    settings.interactionProfile = "/interaction_profiles/khr/simple_controller";
    settings.hands[1].held = true;
    settings.hands[1].worldFromAim = {{0, 0, 0, 1}, {0.3f, 1.2f, 2.5f}};
    openAndDraw(settings);
    ASSERT_EQ(step(), xr::Step::Drew);
    const xr::Controller& right = session_->controllers().hands[1];
    EXPECT_FALSE(session_->controllers().hands[0].tracked);
    ASSERT_TRUE(right.tracked);
    EXPECT_NEAR(right.aim.position.x, 0.3f, 1e-6f);
    EXPECT_NEAR(right.aim.position.y, 1.2f, 1e-6f);
    EXPECT_FALSE(right.select);
    mockxr::settings().hands[1].inputs["input/select/click"] = {1, 0};
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_TRUE(right.select);
    EXPECT_TRUE(right.selected);
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_TRUE(right.select);
    EXPECT_FALSE(right.selected) << "pressed once";
    mockxr::settings().hands[1].held = false;
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_FALSE(right.tracked);
    EXPECT_FALSE(right.select);
}

TEST_F(XrStates, sticksTurn) {
    mockxr::Settings settings = userAt(kHead);
    settings.interactionProfile = "/interaction_profiles/oculus/touch_controller";
    settings.hands[0].held = true;
    settings.hands[0].inputs["input/thumbstick/x"] = {-0.75f, 0};
    settings.hands[0].inputs["input/thumbstick"] = {-0.75f, 0};
    openAndDraw(settings);
    ASSERT_EQ(step(), xr::Step::Drew);
    EXPECT_FLOAT_EQ(session_->controllers().hands[0].turn, -0.75f);
    EXPECT_FLOAT_EQ(session_->controllers().hands[1].turn, 0);
}

TEST_F(XrStates, theSurroundingsByBlendMode) {
    mockxr::Settings settings = userAt(kHead);
    settings.blendModes = {XR_ENVIRONMENT_BLEND_MODE_OPAQUE, XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND};
    xr::SessionOptions options = opaque();
    options.blend = xr::Blend::Alpha;
    openAndDraw(settings, options);
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    EXPECT_EQ(scene_->blend, xr::Blend::Alpha);
    EXPECT_EQ(frame.blendMode, XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND);
    ASSERT_EQ(frame.layers.size(), 1u);
    EXPECT_TRUE(frame.layers[0].flags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT);
    EXPECT_FALSE(frame.layers[0].flags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT);
}

TEST_F(XrStates, theSurroundingsByPassthrough) {
    xr::SessionOptions options = opaque();
    options.blend = xr::Blend::Alpha;
    openAndDraw(userAt(kHead), options);
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_EQ(frame.layers.size(), 2u);
    EXPECT_EQ(frame.blendMode, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
    EXPECT_EQ(frame.layers[0].type, XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB) << "the layer below";
    EXPECT_TRUE(frame.layers[1].flags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT);
}

TEST_F(XrStates, aSceneThatFails) {
    openAndDraw(userAt(kHead));
    scene_->failNextDraw = true;
    expectError("does not want to draw");
    closeSession();
    openSession(opaque());
    scene_->failNextBegin = true;
    expectError("does not want to begin");
    closeSession();
    openSession(opaque());
    EXPECT_TRUE(run(xr::Step::Drew));
}

}  // namespace
}  // namespace dpl::test
