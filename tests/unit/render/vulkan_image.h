// SPDX-License-Identifier: Apache-2.0
// Shared by tests of Vulkan pictures: both fills, both colour formats, the difference from the referee.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "apps/reference/reference_renderer.h"
#include "tests/reference/image_compare.h"
#include "tests/unit/render/tube_avatar.h"
#include "tests/unit/render/vulkan_test_device.h"

namespace dpl {

// Two errors are left: splats with equal 16-bit depth keys are drawn in splat order, and the 1/255 cut-off. At least 50 dB.
constexpr double kMinPsnrDb = 50;

/** Every test runs with both fills. */
class VulkanImage : public testing::TestWithParam<Fill> {};

inline std::shared_ptr<const AvatarData> share(AvatarData a) {
    return std::make_shared<const AvatarData>(codedOnce(std::move(a)));
}

struct Difference {
    double psnrDb = 0, maxError = 0, alphaPsnrDb = 0, maxDepthErrorM = 0, covered = 0;
};

inline Difference compare(const RenderedView& image, const ReferenceImage& want) {
    std::vector<double> rgb, alpha;
    for (size_t i = 0; i < image.rgba.size(); i += 4) {
        for (size_t c = 0; c < 3; ++c) rgb.push_back(image.rgba[i + c] / 255.0);
        alpha.push_back(image.rgba[i + 3] / 255.0);
    }
    const ImageDifference colour = compareImages(rgb, want.rgb), coverageDifference = compareImages(alpha, want.alpha);
    Difference d{colour.psnrDb, colour.maxError, coverageDifference.psnrDb, 0, coverage(want.alpha)};
    for (size_t i = 0; i < image.depthM.size(); ++i)
        if (want.alpha[i] > 0.5) d.maxDepthErrorM = std::max(d.maxDepthErrorM, std::abs(image.depthM[i] - want.depthM[i]));
    return d;
}

/** Compares pictures of two kernels that the driver compiled separately, so that each may round differently. On a host with AVX2 and
 *  without AVX-512, 1 of 46,560 or 2 of 84,600 bytes differed by one code. That is rounding, not a race: every run gave the same bytes
 *  (docs/notebook/archive/2026-11-23-lavapipe.md). */
inline testing::AssertionResult sameButForRounding(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    if (a.size() != b.size()) return testing::AssertionFailure() << a.size() << " and " << b.size() << " bytes";
    size_t different = 0;
    int largest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        different += a[i] != b[i];
        largest = std::max(largest, std::abs(int(a[i]) - int(b[i])));
    }
    if (largest <= 1 && different <= a.size() / 10000) return testing::AssertionSuccess();
    return testing::AssertionFailure() << different << " of " << a.size() << " bytes differ, by up to " << largest << " codes";
}

inline void dumpPicture(const char* name, const RenderedView& image) {
    const char* folder = std::getenv("DOPPEL_TEST_PICTURES");
    if (!folder) return;
    std::FILE* file = std::fopen((std::string(folder) + "/" + name + ".ppm").c_str(), "wb");
    if (!file) return;
    std::fprintf(file, "P6\n%u %u\n255\n", image.widthPx, image.heightPx);
    for (size_t i = 0; i < image.rgba.size(); i += 4) std::fwrite(&image.rgba[i], 1, 3, file);
    std::fclose(file);
}

inline RenderedView drawOne(Renderer& r, RenderAvatarId id, const Pose& pose, const Cameraf& camera, bool depth = false) {
    std::vector<RenderedView> out(1);
    const Status status = r.render(id, pose, {&camera, 1}, depth, out);
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    return std::move(out[0]);
}

/** Expects that the last frame of the avatar, in which it must be visible, was drawn with this fill. */
inline void expectFilledBy(Renderer& r, RenderAvatarId id, Fill fill) {
    const auto stats = r.stats(id);
    ASSERT_TRUE(stats) << stats.error().message;
    EXPECT_EQ(stats->tileEntries > 0 && !stats->tilesOverflowed, fill == Fill::Tiles);
}

}  // namespace dpl
