// SPDX-License-Identifier: Apache-2.0
// Work-arounds apply to the driver that needs them and to no other. Each is logged once.
#include "sdk/backend/vulkan/vk_quirks.h"

#include <gtest/gtest.h>

#include "sdk/core/log.h"

namespace dpl::vk {
namespace {

TEST(VulkanQuirks, everyRowSaysWhatWhyAndWhen) {
    for (const Quirk& quirk : quirks()) {
        EXPECT_GT(std::string(quirk.device).size(), 3u) << "an empty match would be every device";
        EXPECT_NE(quirk.apply, nullptr);
        EXPECT_FALSE(std::string(quirk.what).empty());
        EXPECT_FALSE(std::string(quirk.reason).empty());
        EXPECT_EQ(std::string(quirk.date).size(), 10u) << "year-month-day";
    }
}

TEST(VulkanQuirks, rowsOfLlvmpipeApplyToItAloneAndAreLoggedOnce) {
    std::vector<std::string> lines;
    setLogSink([&](LogLevel, std::string_view text) { lines.emplace_back(text); });
    for (int k = 0; k < 2; ++k) {
        DeviceInfo lavapipe{.name = "llvmpipe (LLVM 15.0.6, 256 bits)", .multiview = true, .timestamps = true, .typedFormats = true};
        applyQuirks(lavapipe);
        EXPECT_FALSE(lavapipe.multiview);
        EXPECT_TRUE(lavapipe.texels);
        EXPECT_TRUE(lavapipe.timestamps);
        DeviceInfo swiftShader{.name = "SwiftShader Device (LLVM 16.0.0)", .multiview = true, .typedFormats = true};
        applyQuirks(swiftShader);
        EXPECT_TRUE(swiftShader.multiview);
        EXPECT_FALSE(swiftShader.texels);
    }
    setLogSink({});
    ASSERT_EQ(lines.size(), quirks().size());
    for (const std::string& line : lines) EXPECT_NE(line.find("llvmpipe"), std::string::npos) << line;
}

}  // namespace
}  // namespace dpl::vk
