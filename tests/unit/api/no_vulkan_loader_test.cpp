// SPDX-License-Identifier: Apache-2.0
// A machine without the Vulkan loader: asking for Vulkan gives an error that names the loader; DPL_RENDERER_AUTO draws on the CPU.
// This program defines its own dlopen, which finds no file with "vulkan" in its name.
#include <dlfcn.h>

#include <algorithm>

#include "tests/unit/api/api_fixture.h"

namespace {
int askedForVulkan = 0;
}

extern "C" void* dlopen(const char* file, int mode) noexcept {
    if (file && std::string(file).find("ulkan") != std::string::npos) {
        ++askedForVulkan;
        return nullptr;
    }
    static const auto systemDlopen = reinterpret_cast<void* (*)(const char*, int)>(dlsym(RTLD_NEXT, "dlopen"));
    return systemDlopen(file, mode);
}

namespace dpl::test {
namespace {

class NoVulkanLoader : public ApiTest {};

TEST_F(NoVulkanLoader, askingForVulkanIsAnErrorThatNamesTheLoader) {
    askedForVulkan = 0;
    const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_VULKAN, 1};
    DplContext context = nullptr;
    EXPECT_EQ(dplCreateContext(&info, &context), DPL_ERROR_UNSUPPORTED);
    EXPECT_EQ(context, nullptr);
    if (errorSays("DOPPEL_VULKAN=OFF")) GTEST_SKIP() << dplGetLastError();
    EXPECT_GT(askedForVulkan, 0) << "the loader was not looked for through dlopen";
    EXPECT_TRUE(errorSays("the Vulkan loader")) << dplGetLastError();
    EXPECT_TRUE(errorSays("not installed")) << dplGetLastError();
    EXPECT_TRUE(errorSays("DPL_RENDERER_SOFTWARE")) << "the sentence names the way out: " << dplGetLastError();
}

TEST_F(NoVulkanLoader, autoDrawsOnTheCpu) {
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(nullptr, &context), DPL_OK) << dplGetLastError();
    const char* name = nullptr;
    ASSERT_EQ(dplGetRendererName(context, &name), DPL_OK);
    EXPECT_EQ(std::string(name).find("software"), 0u) << name;
    const auto bytes = tinyFile();
    DplAvatar avatar = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes.data(), bytes.size(), &avatar), DPL_OK) << dplGetLastError();
    const DplCamera camera = frontCamera();
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(camera, pixels);
    ASSERT_EQ(dplRender(context, avatar, &camera, 1, &image), DPL_OK) << dplGetLastError();
    size_t covered = 0;
    for (size_t i = 3; i < pixels.size(); i += 4) covered += pixels[i] > 200;
    EXPECT_GT(covered, 100u) << "the avatar is in the picture";
    EXPECT_EQ(dplDestroyAvatar(avatar), DPL_OK);
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

}  // namespace
}  // namespace dpl::test
