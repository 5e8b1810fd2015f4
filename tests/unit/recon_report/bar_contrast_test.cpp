// SPDX-License-Identifier: Apache-2.0
// Contrast kept of printed bars: linear in their contrast, 0 without them, and by place.
#include "reconstruction/judging/report/bar_contrast.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kWidth = 240, kHeight = 100;

/** A field of 3 mm bars, slanted, whose right part recedes. */
PrintedBars field() {
    PrintedBars bars;
    bars.widthMm = 3;
    for (int k = 0; k < 4; ++k) {
        const double x = 30 + 60 * k - 4.0 * k * k, lift = 3.0 * k;
        bars.topPx.push_back({x, 20 + lift}), bars.bottomPx.push_back({x + 5, 80 - lift});
    }
    return bars;
}

/** What a camera sees of the field: the sign of a sine along it, of this contrast, moved by a share of a period. */
std::vector<uint8_t> printed(double contrast, double moved = 0) {
    const PrintedBars bars = field();
    std::vector<uint8_t> rgba(size_t(kWidth) * kHeight * 4, 200);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            double sum = 0;
            for (int i = 0; i < 8; ++i) {
                const double px = x + (i + 0.5) / 8, down = (y + 0.5 - 20) / 60;
                for (size_t s = 0; s + 1 < bars.topPx.size(); ++s) {
                    const double left = glm::mix(bars.topPx[s].x, bars.bottomPx[s].x, down),
                                 right = glm::mix(bars.topPx[s + 1].x, bars.bottomPx[s + 1].x, down);
                    if (px < left || px >= right) continue;
                    const double across = (double(s) + (px - left) / (right - left)) / 3;
                    sum += std::sin(6.283185307 * (5 * across - moved)) > 0 ? -1 : 1;
                }
            }
            for (int c = 0; c < 3; ++c)
                rgba[4 * (size_t(y) * kWidth + x) + size_t(c)] = uint8_t(std::lround(120 + 100 * contrast * sum / 8));
        }
    return rgba;
}

double kept(const std::vector<uint8_t>& drawn, const std::vector<uint8_t>& photograph) {
    const auto share = barContrast(drawn, photograph, kWidth, kHeight, field());
    EXPECT_TRUE(share);
    return share.value_or(-9);
}

TEST(BarContrast, isTheShareOfTheContrastAtItsPlace) {
    const auto photograph = printed(0.8);
    EXPECT_NEAR(kept(photograph, photograph), 1, 1e-9);
    EXPECT_NEAR(kept(printed(0.4), photograph), 0.5, 0.01);
    EXPECT_NEAR(kept(printed(0), photograph), 0, 0.01);
    EXPECT_NEAR(kept(printed(0.8, 0.25), photograph), 0, 0.08) << "a quarter of a period away";
    EXPECT_NEAR(kept(printed(0.8, 0.5), photograph), -1, 0.08) << "bars where gaps are";
}

TEST(BarContrast, needsAPhotographThatShowsTheBars) {
    EXPECT_FALSE(barContrast(printed(0.8), printed(0.02), kWidth, kHeight, field()));
    PrintedBars small = field();
    for (Vec2d& p : small.topPx) p *= 0.05;
    for (Vec2d& p : small.bottomPx) p *= 0.05;
    EXPECT_FALSE(barContrast(printed(0.8), printed(0.8), kWidth, kHeight, small)) << "a dozen pixels";
    EXPECT_FALSE(barContrast({}, printed(0.8), kWidth, kHeight, field()));
}

class PrintedBarsFile : public testing::Test {
protected:
    PrintedBarsFile() { fs::create_directories(folder_); }
    ~PrintedBarsFile() override { fs::remove_all(folder_); }
    auto read(const std::string& truth) {
        std::ofstream(folder_ / "truth.json") << truth;
        return readPrintedBars(folder_);
    }
    const fs::path folder_ = fs::temp_directory_path() / ("doppel_printed_bars_" + std::to_string(::getpid()));
};

TEST_F(PrintedBarsFile, isReadByFrame) {
    const auto none = readPrintedBars(folder_);
    ASSERT_TRUE(none);
    EXPECT_TRUE(none->empty());
    const auto bars = read(R"({"frames": [{"name": "full_000"}, {"name": "close_001", "bars":
        [{"width_mm": 1.5, "top_px": [[1, 2], [3, 2.5]], "bottom_px": [[1, 9], [3, 9]]}]}]})");
    ASSERT_TRUE(bars) << bars.error().message;
    ASSERT_EQ(bars->size(), 1u);
    const PrintedBars& only = bars->at("close_001").at(0);
    EXPECT_EQ(only.widthMm, 1.5);
    EXPECT_EQ(only.topPx.at(1), Vec2d(3, 2.5));
    EXPECT_EQ(only.bottomPx.at(0), Vec2d(1, 9));
}

TEST_F(PrintedBarsFile, whatIsNoFieldIsRefusedByName) {
    for (const char* bars : {"7", "[7]", R"([{"width_mm": 1, "top_px": [[1, 2]], "bottom_px": [[1, 9]]}])",
                             R"([{"width_mm": 0, "top_px": [[1, 2], [3, 2]], "bottom_px": [[1, 9], [3, 9]]}])",
                             R"([{"width_mm": 1, "top_px": [[1, 2], [3, 2]], "bottom_px": [[1, 9], [2, 9], [3, 9]]}])",
                             R"([{"width_mm": 1, "top_px": [[1, 2], [3, "x"]], "bottom_px": [[1, 9], [3, 9]]}])",
                             R"([{"width_mm": 1, "top_px": [[1, 2], [3, 1e300]], "bottom_px": [[1, 9], [3, 9]]}])"}) {
        const auto read_ = read(std::string(R"({"frames": [{"name": "close_001", "bars": )") + bars + "}]}");
        ASSERT_FALSE(read_) << bars;
        EXPECT_EQ(read_.error().code, Code::CorruptData);
        EXPECT_NE(read_.error().message.find("close_001"), std::string::npos) << read_.error().message;
    }
    EXPECT_FALSE(read("[]"));
    EXPECT_FALSE(read("{"));
}

}  // namespace
}  // namespace dpl
