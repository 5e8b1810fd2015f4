// SPDX-License-Identifier: Apache-2.0
// Test fixture: a context with one thread, a tiny avatar, a silent log.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel.h"
#include "tests/package/tiny_avatar.h"

namespace dpl::test {

inline std::vector<uint8_t> tinyFile() {
    AvatarData avatar = tinyAvatar();
    sortSplats(avatar);
    auto bytes = writeAvatar(avatar);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().message);
    return bytes ? *bytes : std::vector<uint8_t>{};
}

inline DplCamera frontCamera(uint32_t width = 64, uint32_t height = 64, float shiftX = 0) {
    const float f = 60.0f * float(height) / 64;
    return {sizeof(DplCamera), width, height, f, f, float(width) / 2, float(height) / 2, {1, 0, 0, shiftX, 0, -1, 0, 1, 0, 0, -1, 3}};
}

class ApiTest : public ::testing::Test {
protected:
    void SetUp() override {
        dplSetLogCallback([](void* user, DplLogLevel, const char* text) { static_cast<ApiTest*>(user)->log_ += std::string(text) + "\n"; },
                          this);
        const DplContextInfo info{sizeof(DplContextInfo), DPL_RENDERER_SOFTWARE, 1};
        ASSERT_EQ(dplCreateContext(&info, &context_), DPL_OK) << dplGetLastError();
        const auto bytes = tinyFile();
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &avatar_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(avatar_), DPL_OK);
        EXPECT_EQ(dplDestroyContext(context_), DPL_OK);
        dplSetLogCallback(nullptr, nullptr);
    }
    DplImage imageFor(const DplCamera& camera, std::vector<uint8_t>& pixels, std::vector<float>* depth = nullptr) {
        pixels.assign(size_t(camera.widthPx) * camera.heightPx * 4, 0xAA);
        DplImage image{sizeof(DplImage), 0, pixels.data(), pixels.size(), 0, nullptr, 0};
        if (depth) {
            depth->assign(size_t(camera.widthPx) * camera.heightPx, -1);
            image.depthM = depth->data();
            image.depthCount = depth->size();
        }
        return image;
    }
    bool errorSays(const char* text) const { return std::string(dplGetLastError()).find(text) != std::string::npos; }

    DplContext context_ = nullptr;
    DplAvatar avatar_ = nullptr;
    std::string log_;
};

}  // namespace dpl::test
