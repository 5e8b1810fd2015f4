// SPDX-License-Identifier: Apache-2.0
// The mock runtime notices mistakes: every rule stands beside the right call that it allows.
#define XR_USE_GRAPHICS_API_VULKAN
#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "tests/xr/mock_runtime/control.h"

namespace dpl::test {
namespace {

constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};

/** A caller that does everything right, step by step; tests spoil one step. */
class MockXr : public testing::Test {
protected:
    void SetUp() override {
        ::setenv("XR_RUNTIME_JSON", DOPPEL_MOCK_XR, 1);
        mockxr::Settings settings;
        settings.capture = true;
        settings.validation = false;
        mockxr::reset(settings);
        ASSERT_EQ(createInstance(), XR_SUCCESS);
        XrSystemGetInfo get{XR_TYPE_SYSTEM_GET_INFO};
        get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
        ASSERT_EQ(xrGetSystem(instance_, &get, &system_), XR_SUCCESS);
        openVulkan();
    }
    void TearDown() override {
        if (instance_) {
            EXPECT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
        }
        if (device_) vkDestroyDevice(device_, nullptr);
        if (vulkan_) vkDestroyInstance(vulkan_, nullptr);
        EXPECT_EQ(mockxr::liveHandles(), 0u);
    }

    XrResult createInstance() {
        const char* extensions[] = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                                    XR_EXT_HAND_TRACKING_EXTENSION_NAME};
        XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
        std::strcpy(info.applicationInfo.applicationName, "test");
        info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
        info.enabledExtensionCount = 3, info.enabledExtensionNames = extensions;
        return xrCreateInstance(&info, &instance_);
    }
    template <class F>
    F function(const char* name) {
        PFN_xrVoidFunction found = nullptr;
        EXPECT_EQ(xrGetInstanceProcAddr(instance_, name, &found), XR_SUCCESS) << name;
        return reinterpret_cast<F>(found);
    }
    void openVulkan() {
        XrGraphicsRequirementsVulkan2KHR needs{XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR};
        ASSERT_EQ(function<PFN_xrGetVulkanGraphicsRequirements2KHR>("xrGetVulkanGraphicsRequirements2KHR")(instance_, system_, &needs),
                  XR_SUCCESS);
        VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
        application.apiVersion = VK_API_VERSION_1_1;
        VkInstanceCreateInfo vulkan{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        vulkan.pApplicationInfo = &application;
        XrVulkanInstanceCreateInfoKHR create{XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR};
        create.systemId = system_, create.pfnGetInstanceProcAddr = vkGetInstanceProcAddr, create.vulkanCreateInfo = &vulkan;
        VkResult made = VK_SUCCESS;
        ASSERT_EQ(function<PFN_xrCreateVulkanInstanceKHR>("xrCreateVulkanInstanceKHR")(instance_, &create, &vulkan_, &made), XR_SUCCESS);
        if (made != VK_SUCCESS) GTEST_SKIP() << "there is no Vulkan device (Debian: mesa-vulkan-drivers)";
        XrVulkanGraphicsDeviceGetInfoKHR get{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR};
        get.systemId = system_, get.vulkanInstance = vulkan_;
        ASSERT_EQ(function<PFN_xrGetVulkanGraphicsDevice2KHR>("xrGetVulkanGraphicsDevice2KHR")(instance_, &get, &physical_), XR_SUCCESS);
        const float priority = 1;
        VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
        queue.queueCount = 1, queue.pQueuePriorities = &priority;
        VkDeviceCreateInfo device{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
        device.queueCreateInfoCount = 1, device.pQueueCreateInfos = &queue;
        XrVulkanDeviceCreateInfoKHR createDevice{XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR};
        createDevice.systemId = system_, createDevice.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
        createDevice.vulkanPhysicalDevice = physical_, createDevice.vulkanCreateInfo = &device;
        ASSERT_EQ(function<PFN_xrCreateVulkanDeviceKHR>("xrCreateVulkanDeviceKHR")(instance_, &createDevice, &device_, &made), XR_SUCCESS);
    }
    XrResult createSession() {
        XrGraphicsBindingVulkan2KHR binding{XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR};
        binding.instance = vulkan_, binding.physicalDevice = physical_, binding.device = device_;
        XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, &binding};
        info.systemId = system_;
        return xrCreateSession(instance_, &info, &session_);
    }
    XrResult begin() {
        XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO};
        info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        return xrBeginSession(session_, &info);
    }
    void poll() {
        XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
        while (xrPollEvent(instance_, &event) == XR_SUCCESS) event = {XR_TYPE_EVENT_DATA_BUFFER};
    }
    /** A session that runs, with a space and a swapchain that has a released image. */
    void openSession() {
        ASSERT_EQ(createSession(), XR_SUCCESS);
        poll();
        ASSERT_EQ(begin(), XR_SUCCESS);
        XrReferenceSpaceCreateInfo space{XR_TYPE_REFERENCE_SPACE_CREATE_INFO};
        space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        space.poseInReferenceSpace = kHere;
        ASSERT_EQ(xrCreateReferenceSpace(session_, &space, &space_), XR_SUCCESS);
        colour_ = createSwapchain(VK_FORMAT_R8G8B8A8_SRGB, XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT);
        depth_ = createSwapchain(VK_FORMAT_D32_SFLOAT, XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT);
        for (const XrSwapchain swapchain : {colour_, depth_}) {
            acquire(swapchain);
            ASSERT_EQ(release(swapchain), XR_SUCCESS);
        }
    }
    XrSwapchain createSwapchain(int64_t format, XrSwapchainUsageFlags usage, XrResult expected = XR_SUCCESS) {
        XrSwapchainCreateInfo info{XR_TYPE_SWAPCHAIN_CREATE_INFO};
        info.format = format, info.usageFlags = usage;
        info.width = 16, info.height = 12, info.arraySize = 2, info.sampleCount = info.faceCount = info.mipCount = 1;
        XrSwapchain swapchain = XR_NULL_HANDLE;
        EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain), expected);
        return swapchain;
    }
    void acquire(XrSwapchain swapchain) {
        uint32_t index = 0;
        ASSERT_EQ(xrAcquireSwapchainImage(swapchain, nullptr, &index), XR_SUCCESS);
        XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
        wait.timeout = 1000;
        ASSERT_EQ(xrWaitSwapchainImage(swapchain, &wait), XR_SUCCESS);
    }
    static XrResult release(XrSwapchain swapchain) { return xrReleaseSwapchainImage(swapchain, nullptr); }

    struct Layer {
        XrCompositionLayerDepthInfoKHR depth[2];
        XrCompositionLayerProjectionView views[2];
        XrCompositionLayerProjection projection;
        XrFrameEndInfo end;
        const XrCompositionLayerBaseHeader* layers[1];
    };
    /** A frame whose layer `spoil` may change before it ends. */
    template <class Spoil>
    XrResult frame(Spoil spoil) {
        XrFrameState state{XR_TYPE_FRAME_STATE};
        EXPECT_EQ(xrWaitFrame(session_, nullptr, &state), XR_SUCCESS);
        EXPECT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
        Layer layer{};
        for (uint32_t i = 0; i < 2; ++i) {
            layer.depth[i] = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR, nullptr, {depth_, {{0, 0}, {16, 12}}, i}, 0, 1, INFINITY, 0.1f};
            layer.views[i] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                              &layer.depth[i],
                              kHere,
                              {-0.7f, 0.7f, 0.7f, -0.7f},
                              {colour_, {{0, 0}, {16, 12}}, i}};
        }
        layer.projection = {XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, space_, 2, layer.views};
        layer.layers[0] = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer.projection);
        layer.end = {XR_TYPE_FRAME_END_INFO, nullptr, state.predictedDisplayTime, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 1, layer.layers};
        spoil(layer);
        const XrResult result = xrEndFrame(session_, &layer.end);
        if (XR_FAILED(result)) {  // so that the next frame starts clean
            XrFrameEndInfo empty{XR_TYPE_FRAME_END_INFO, nullptr, state.predictedDisplayTime, XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
            EXPECT_EQ(xrEndFrame(session_, &empty), XR_SUCCESS);
        }
        return result;
    }
    /** Runs `call` and expects its error and a sentence with `text`. */
    template <class Call>
    void expectViolation(XrResult error, const char* text, Call call) {
        const size_t before = mockxr::violations().size();
        EXPECT_EQ(call(), error);
        ASSERT_EQ(mockxr::violations().size(), before + 1) << text;
        EXPECT_NE(mockxr::violations().back().find(text), std::string::npos) << mockxr::violations().back();
    }
    template <class Spoil>
    void expectLayerViolation(XrResult error, const char* text, Spoil spoil) {
        expectViolation(error, text, [&] { return frame(spoil); });
    }

    XrInstance instance_ = XR_NULL_HANDLE;
    XrSystemId system_ = 0;
    VkInstance vulkan_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    XrSession session_ = XR_NULL_HANDLE;
    XrSpace space_ = XR_NULL_HANDLE;
    XrSwapchain colour_ = XR_NULL_HANDLE, depth_ = XR_NULL_HANDLE;
};

TEST_F(MockXr, aRightFrameBreaksNoRule) {
    openSession();
    EXPECT_EQ(frame([](Layer&) {}), XR_SUCCESS);
    EXPECT_EQ(mockxr::violations(), std::vector<std::string>{});
    const mockxr::SubmittedFrame frame = mockxr::lastFrame();
    ASSERT_EQ(frame.layers.size(), 1u);
    ASSERT_EQ(frame.layers[0].views.size(), 2u);
    EXPECT_EQ(frame.layers[0].views[1].layer, 1u);
    EXPECT_EQ(frame.layers[0].views[1].pixels.size(), 16u * 12 * 4);
    EXPECT_EQ(frame.layers[0].views[1].depth.size(), 16u * 12);
}

TEST_F(MockXr, checksLayers) {
    openSession();
    const auto all = [&](XrResult error, const char* text, auto spoil) { expectLayerViolation(error, text, spoil); };
    all(XR_ERROR_VALIDATION_FAILURE, "frameEndInfo has type", [](Layer& l) { l.end.type = XR_TYPE_FRAME_BEGIN_INFO; });
    all(XR_ERROR_TIME_INVALID, "displayTime", [](Layer& l) { ++l.end.displayTime; });
    all(XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "blend mode",
        [](Layer& l) { l.end.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ADDITIVE; });
    all(XR_ERROR_LAYER_INVALID, "a layer is null", [](Layer& l) { l.layers[0] = nullptr; });
    all(XR_ERROR_LAYER_INVALID, "a layer has type", [](Layer& l) { l.projection.type = XR_TYPE_COMPOSITION_LAYER_CUBE_KHR; });
    all(XR_ERROR_VALIDATION_FAILURE, "unknown flags", [](Layer& l) { l.projection.layerFlags = 1 << 20; });
    all(XR_ERROR_HANDLE_INVALID, "space", [](Layer& l) { l.projection.space = XR_NULL_HANDLE; });
    all(XR_ERROR_VALIDATION_FAILURE, "1 views instead of 2", [](Layer& l) { l.projection.viewCount = 1; });
    all(XR_ERROR_VALIDATION_FAILURE, "a projection view has type", [](Layer& l) { l.views[1].type = XR_TYPE_VIEW; });
    all(XR_ERROR_POSE_INVALID, "length 1", [](Layer& l) { l.views[1].pose.orientation.w = 0.9f; });
    all(XR_ERROR_POSE_INVALID, "length 1", [](Layer& l) { l.views[1].pose.orientation.x = NAN; });
    all(XR_ERROR_POSE_INVALID, "finite", [](Layer& l) { l.views[0].pose.position.y = NAN; });
    all(XR_ERROR_VALIDATION_FAILURE, "empty", [](Layer& l) { std::swap(l.views[0].fov.angleUp, l.views[0].fov.angleDown); });
    all(XR_ERROR_VALIDATION_FAILURE, "90 degrees", [](Layer& l) { l.views[0].fov.angleRight = 1.6f; });
    all(XR_ERROR_HANDLE_INVALID, "swapchain", [](Layer& l) { l.views[0].subImage.swapchain = XR_NULL_HANDLE; });
    all(XR_ERROR_VALIDATION_FAILURE, "array index 2", [](Layer& l) { l.views[1].subImage.imageArrayIndex = 2; });
    all(XR_ERROR_SWAPCHAIN_RECT_INVALID, "rectangle", [](Layer& l) { l.views[1].subImage.imageRect.extent.width = 17; });
    all(XR_ERROR_SWAPCHAIN_RECT_INVALID, "rectangle", [](Layer& l) { l.views[1].subImage.imageRect.offset.y = -1; });
    all(XR_ERROR_SWAPCHAIN_RECT_INVALID, "rectangle", [](Layer& l) { l.views[1].subImage.imageRect.extent.height = 0; });
    all(XR_ERROR_LAYER_INVALID, "the colour image has", [&](Layer& l) { l.views[1].subImage.swapchain = depth_; });
    all(XR_ERROR_LAYER_INVALID, "the depth image has", [&](Layer& l) { l.depth[1].subImage.swapchain = colour_; });
    all(XR_ERROR_VALIDATION_FAILURE, "does not belong there", [](Layer& l) { l.depth[0].type = XR_TYPE_VIEW; });
    all(XR_ERROR_VALIDATION_FAILURE, "twice", [](Layer& l) { l.depth[0].next = &l.depth[1]; });
    all(XR_ERROR_VALIDATION_FAILURE, "minDepth", [](Layer& l) { l.depth[0].maxDepth = 1.5f; });
    all(XR_ERROR_VALIDATION_FAILURE, "nearZ", [](Layer& l) { l.depth[0].nearZ = l.depth[0].farZ; });
    EXPECT_EQ(frame([](Layer&) {}), XR_SUCCESS) << "mistakes do not stick";
}

TEST_F(MockXr, checksTheOrderOfCalls) {
    ASSERT_EQ(createSession(), XR_SUCCESS);
    expectViolation(XR_ERROR_SESSION_NOT_READY, "READY", [&] { return begin(); });
    XrFrameState state{XR_TYPE_FRAME_STATE};
    expectViolation(XR_ERROR_SESSION_NOT_RUNNING, "run", [&] { return xrWaitFrame(session_, nullptr, &state); });
    poll();
    ASSERT_EQ(begin(), XR_SUCCESS);
    expectViolation(XR_ERROR_SESSION_RUNNING, "already", [&] { return begin(); });
    expectViolation(XR_ERROR_SESSION_NOT_STOPPING, "STOPPING", [&] { return xrEndSession(session_); });
    expectViolation(XR_ERROR_CALL_ORDER_INVALID, "xrWaitFrame", [&] { return xrBeginFrame(session_, nullptr); });
    ASSERT_EQ(xrWaitFrame(session_, nullptr, &state), XR_SUCCESS);
    expectViolation(XR_ERROR_CALL_ORDER_INVALID, "not begun", [&] { return xrWaitFrame(session_, nullptr, &state); });
    XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO, nullptr, state.predictedDisplayTime, XR_ENVIRONMENT_BLEND_MODE_OPAQUE};
    expectViolation(XR_ERROR_CALL_ORDER_INVALID, "xrBeginFrame", [&] { return xrEndFrame(session_, &end); });
    ASSERT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
    EXPECT_EQ(xrEndFrame(session_, &end), XR_SUCCESS);
    poll();
    EXPECT_EQ(mockxr::lastState(), XR_SESSION_STATE_FOCUSED);
}

TEST_F(MockXr, checksSwapchains) {
    openSession();
    const XrSwapchainUsageFlags usage = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    expectViolation(XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED, "not enumerated", [&] {
        createSwapchain(VK_FORMAT_R32_SFLOAT, usage, XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
        return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
    });
    expectViolation(XR_ERROR_VALIDATION_FAILURE, "usage", [&] {
        createSwapchain(VK_FORMAT_D32_SFLOAT, usage, XR_ERROR_VALIDATION_FAILURE);
        return XR_ERROR_VALIDATION_FAILURE;
    });
    expectViolation(XR_ERROR_CALL_ORDER_INVALID, "waited for", [&] { return release(colour_); });
    uint32_t index = 0;
    for (int i = 0; i < 3; ++i) ASSERT_EQ(xrAcquireSwapchainImage(colour_, nullptr, &index), XR_SUCCESS);
    expectViolation(XR_ERROR_CALL_ORDER_INVALID, "acquired already", [&] { return xrAcquireSwapchainImage(colour_, nullptr, &index); });
    expectViolation(XR_ERROR_VALIDATION_FAILURE, "an element of images has type", [&] {
        XrSwapchainImageVulkan2KHR images[3]{};
        return xrEnumerateSwapchainImages(colour_, 3, &index, reinterpret_cast<XrSwapchainImageBaseHeader*>(images));
    });
    EXPECT_EQ(xrDestroySwapchain(colour_), XR_SUCCESS);
    expectLayerViolation(XR_ERROR_HANDLE_INVALID, "the swapchain of the colour image is not alive", [](Layer&) {});
}

TEST_F(MockXr, checksDevices) {
    const VkDevice mine = device_;
    device_ = VK_NULL_HANDLE;
    expectViolation(XR_ERROR_GRAPHICS_DEVICE_INVALID, "is not the one", [&] { return createSession(); });
    device_ = mine;
    XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO};
    info.systemId = system_;
    expectViolation(XR_ERROR_GRAPHICS_DEVICE_INVALID, "no Vulkan device", [&] { return xrCreateSession(instance_, &info, &session_); });
}

TEST_F(MockXr, checksHandTrackers) {
    openSession();
    const auto create = function<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT");
    const auto locate = function<PFN_xrLocateHandJointsEXT>("xrLocateHandJointsEXT");
    XrHandTrackerCreateInfoEXT info{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT};
    XrHandTrackerEXT tracker = XR_NULL_HANDLE;
    info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
    expectViolation(XR_ERROR_VALIDATION_FAILURE, "neither the left", [&] { return create(session_, &info, &tracker); });
    info.hand = XR_HAND_RIGHT_EXT;
    ASSERT_EQ(create(session_, &info, &tracker), XR_SUCCESS);
    XrHandJointLocationEXT joints[XR_HAND_JOINT_COUNT_EXT];
    XrHandJointsLocateInfoEXT where{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, space_, 1};
    XrHandJointLocationsEXT locations{XR_TYPE_HAND_JOINT_LOCATIONS_EXT};
    locations.jointCount = 25, locations.jointLocations = joints;
    expectViolation(XR_ERROR_VALIDATION_FAILURE, "26 joints", [&] { return locate(tracker, &where, &locations); });
    locations.jointCount = XR_HAND_JOINT_COUNT_EXT;
    where.time = 0;
    expectViolation(XR_ERROR_TIME_INVALID, "not positive", [&] { return locate(tracker, &where, &locations); });
    where.time = 1;
    EXPECT_EQ(locate(tracker, &where, &locations), XR_SUCCESS);
    EXPECT_FALSE(locations.isActive) << "no hand is seen";
    const auto destroy = function<PFN_xrDestroyHandTrackerEXT>("xrDestroyHandTrackerEXT");
    EXPECT_EQ(destroy(tracker), XR_SUCCESS);
    expectViolation(XR_ERROR_HANDLE_INVALID, "hand tracker is not alive", [&] { return locate(tracker, &where, &locations); });
}

TEST_F(MockXr, failsTheCallThatItIsTold) {
    openSession();
    mockxr::fail({"xrWaitFrame", 2, 1, XR_ERROR_RUNTIME_FAILURE});
    XrFrameState state{XR_TYPE_FRAME_STATE};
    EXPECT_EQ(frame([](Layer&) {}), XR_SUCCESS);
    EXPECT_EQ(xrWaitFrame(session_, nullptr, &state), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_EQ(frame([](Layer&) {}), XR_SUCCESS) << "it failed once, without an effect";
    mockxr::fail({"xrBeginFrame", 3, 1, XR_ERROR_SESSION_LOST});
    ASSERT_EQ(xrWaitFrame(session_, nullptr, &state), XR_SUCCESS);
    EXPECT_EQ(xrBeginFrame(session_, nullptr), XR_ERROR_SESSION_LOST);
    EXPECT_EQ(xrWaitFrame(session_, nullptr, &state), XR_ERROR_SESSION_LOST) << "a loss stays";
    EXPECT_EQ(release(colour_), XR_ERROR_SESSION_LOST);
    EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
    EXPECT_EQ(mockxr::violations(), std::vector<std::string>{});
    openSession();
    EXPECT_EQ(frame([](Layer&) {}), XR_SUCCESS);
}

}  // namespace
}  // namespace dpl::test
