// SPDX-License-Identifier: Apache-2.0
#include "tests/xr/xr_fixture.h"

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "sdk/math/half.h"
#include "sdk/math/srgb.h"
#include "tests/unit/api/api_fixture.h"

namespace dpl::test {
namespace {

bool hasVulkanDevice() {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    VkInstance instance = VK_NULL_HANDLE;
    if (vkCreateInstance(&info, nullptr, &instance) != VK_SUCCESS) return false;
    uint32_t count = 0;
    vkEnumeratePhysicalDevices(instance, &count, nullptr);
    vkDestroyInstance(instance, nullptr);
    return count > 0;
}

uint8_t code(double value) {
    return uint8_t(std::lround(std::min(1.0, std::max(0.0, value)) * 255));
}

}  // namespace

void XrTest::SetUp() {
    ::setenv("XR_RUNTIME_JSON", DOPPEL_MOCK_XR, 1);
    static const bool device = hasVulkanDevice();
    if (!device) GTEST_SKIP() << "there is no Vulkan device (Debian: mesa-vulkan-drivers)";
}

void XrTest::TearDown() {
    close();
    EXPECT_EQ(mockxr::liveHandles(), 0u);
    for (const std::string& sentence : mockxr::violations()) ADD_FAILURE() << sentence;
    for (const std::string& message : mockxr::vulkanMessages()) ADD_FAILURE() << message;
    if (mockxr::vulkanValidated() || !mockxr::settings().validation) return;
    static bool said = false;
    if (!said)
        std::fprintf(stderr, "the Vulkan validation layer is not installed (Debian: vulkan-validationlayers), so it checked nothing\n");
    said = true;
}

void XrTest::open(const mockxr::Settings& settings, xr::SessionOptions options) {
    mockxr::reset(settings);
    auto runtime = xr::Runtime::create({});
    ASSERT_TRUE(runtime) << runtime.error().message;
    runtime_ = std::move(*runtime);
    const auto bytes = tinyFile();
    ASSERT_EQ(dplLoadAvatar(runtime_->context(), bytes.data(), bytes.size(), &avatar_), DPL_OK) << dplGetLastError();
    scene_.emplace(*runtime_, std::vector{avatar_});
    openSession(options);
}

void XrTest::openSession(const xr::SessionOptions& options) {
    session_.emplace(*runtime_, options);
}

void XrTest::closeSession() {
    session_.reset();
    EXPECT_EQ(scene_->begun, scene_->ended) << "each begin() of a scene has its end()";
}

void XrTest::close() {
    if (session_) closeSession();
    scene_.reset();
    EXPECT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
    avatar_ = nullptr;
    runtime_.reset();
}

bool XrTest::run(xr::Step wanted, int atMost) {
    for (int i = 0; i < atMost; ++i) {
        const auto did = session_->frame(*scene_);
        if (!did) {
            ADD_FAILURE() << did.error().message;
            return false;
        }
        if (*did == wanted) return true;
    }
    ADD_FAILURE() << "the step did not come within " << atMost << " calls; last complaint: " << session_->lastComplaint();
    return false;
}

xr::Step XrTest::step() {
    const auto did = session_->frame(*scene_);
    EXPECT_TRUE(did) << did.error().message;
    return did ? *did : xr::Step::Ended;
}

mockxr::Settings XrTest::userAt(XrVector3f head) {
    mockxr::Settings settings;
    settings.capture = true;
    settings.worldFromHead = [head](XrTime) { return XrPosef{{0, 0, 0, 1}, head}; };
    return settings;
}

xr::SessionOptions XrTest::opaque() {
    xr::SessionOptions options;
    options.nearM = kNearM;
    return options;
}

DplCamera cameraOf(const XrPosef& worldFromView, const XrFovf& fov, uint32_t widthPx, uint32_t heightPx) {
    const double left = std::tan(double(fov.angleLeft)), right = std::tan(double(fov.angleRight));
    const double up = std::tan(double(fov.angleUp)), down = std::tan(double(fov.angleDown));
    DplCamera camera{};
    camera.structSize = sizeof camera;
    camera.widthPx = widthPx, camera.heightPx = heightPx;
    camera.fx = float(widthPx / (right - left)), camera.fy = float(heightPx / (up - down));
    camera.cx = float(-left * widthPx / (right - left)), camera.cy = float(up * heightPx / (up - down));
    const XrQuaternionf& q = worldFromView.orientation;
    const double x = q.x, y = q.y, z = q.z, w = q.w;
    const double world[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                                {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    const double at[3] = {worldFromView.position.x, worldFromView.position.y, worldFromView.position.z};
    for (int row = 0; row < 3; ++row) {  // Doppel's view looks along +z with y down, OpenXR's along -z with y up
        const double sign = row == 0 ? 1 : -1;
        double t = 0;
        for (int column = 0; column < 3; ++column) {
            camera.viewFromWorld[row * 4 + column] = float(sign * world[column][row]);
            t -= sign * world[column][row] * at[column];
        }
        camera.viewFromWorld[row * 4 + 3] = float(t);
    }
    return camera;
}

std::vector<uint8_t> expectedPicture(DplCamera camera, bool withAvatar) {
    std::vector<uint8_t> pixels(size_t(camera.widthPx) * camera.heightPx * 4);
    std::vector<float> depth(size_t(camera.widthPx) * camera.heightPx, 0.0f);
    for (size_t i = 0; i < depth.size(); ++i) {
        const bool wall = i % camera.widthPx >= wallFromPx(camera.widthPx);
        if (wall) depth[i] = kWallM;
        for (size_t c = 0; c < 3; ++c) pixels[i * 4 + c] = code(srgbFromLinear(double((wall ? kWall : kPlain)[c])));
        pixels[i * 4 + 3] = 255;
    }
    if (!withAvatar) return pixels;
    camera.sceneDepthM = depth.data(), camera.sceneDepthCount = depth.size();
    const DplContextInfo info{sizeof info, DPL_RENDERER_SOFTWARE, 1};
    DplContext context = nullptr;
    DplAvatar avatar = nullptr;
    const auto bytes = tinyFile();
    EXPECT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
    DplImage image{sizeof image, DPL_IMAGE_OVER, pixels.data(), pixels.size(), 0, nullptr, 0};
    image.format = DPL_FORMAT_RGBA8_SRGB;
    EXPECT_EQ(dplRender(context, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
    return pixels;
}

std::vector<uint8_t> asRgba8Srgb(const mockxr::SubmittedView& view) {
    const size_t pixels = size_t(view.rect.extent.width) * size_t(view.rect.extent.height);
    if (view.format != VK_FORMAT_R16G16B16A16_SFLOAT) {
        std::vector<uint8_t> out = view.pixels;
        if (view.format == VK_FORMAT_B8G8R8A8_SRGB)
            for (size_t i = 0; i < pixels; ++i) std::swap(out[i * 4], out[i * 4 + 2]);
        return out;
    }
    std::vector<uint8_t> out;
    for (size_t i = 0; i < pixels * 4; ++i) {
        uint16_t half;
        std::memcpy(&half, &view.pixels[i * 2], 2);
        const double value = double(floatFromHalf(half));
        out.push_back(code(i % 4 == 3 ? value : srgbFromLinear(value)));
    }
    return out;
}

size_t differingPixels(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size() && i < b.size(); i += 4) {
        bool differs = false;
        for (size_t c = 0; c < 3; ++c) differs = differs || std::abs(int(a[i + c]) - int(b[i + c])) > 8;
        count += differs;
    }
    return count;
}

}  // namespace dpl::test
