// SPDX-License-Identifier: Apache-2.0
// dplProject: what it gives, blended in the plainest way, is the picture that dplRender draws.
#include "sdk/include/doppel/doppel_splats.h"

#include <algorithm>
#include <cmath>

#include "sdk/format/ply.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl::test {
namespace {

constexpr float kTrainedPixelM = 0.011f;

DplProjection emptyProjection() {
    DplProjection projection{};
    projection.structSize = sizeof projection;
    return projection;
}

/** Blends as doppel_splats.h says, in double precision. */
std::vector<uint8_t> blended(std::span<const DplScreenSplat> splats, const DplCamera& view, uint32_t samples) {
    constexpr double kAt[4][2] = {{0.375, 0.125}, {0.875, 0.375}, {0.125, 0.625}, {0.625, 0.875}}, kCentre[1][2] = {{0.5, 0.5}};
    std::vector<uint8_t> rgba;
    for (uint32_t y = 0; y < view.heightPx; ++y)
        for (uint32_t x = 0; x < view.widthPx; ++x) {
            double mean[4] = {};
            for (uint32_t k = 0; k < samples; ++k) {
                const double* at = samples == 1 ? kCentre[0] : kAt[k];
                double pixel[4] = {};
                for (const DplScreenSplat& s : splats) {
                    const double dy = y + at[1] - double(s.y), dx = x + at[0] - double(s.x) + double(s.slope) * dy;
                    const double sigma = 0.5 * (double(s.conicA) * dx * dx + double(s.inverseVarianceY) * dy * dy);
                    const double alpha = std::min(0.99, s.opacity / 65535.0 * std::exp(-sigma));
                    if (alpha < 1.0 / 255) continue;
                    const double colour[4] = {s.red / 65535.0, s.green / 65535.0, s.blue / 65535.0, 1};
                    for (int c = 0; c < 4; ++c) pixel[c] += alpha * (colour[c] - pixel[c]);
                }
                for (int c = 0; c < 4; ++c) mean[c] += pixel[c] / samples;
            }
            for (const double c : mean) rgba.push_back(uint8_t(std::lround(255 * std::min(c, 1.0))));
        }
    return rgba;
}

/** 1 level: the renderer stops at T ≤ 1e-4 and rounds floats, so a value near the middle of two levels may fall to either. */
void expectSamePicture(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
    ASSERT_EQ(a.size(), b.size());
    size_t differing = 0, covered = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        ASSERT_LE(std::abs(int(a[i]) - int(b[i])), 1) << "value " << i;
        differing += a[i] != b[i], covered += a[i] > 0;
    }
    EXPECT_GT(covered, 1000u);
    EXPECT_LT(differing, a.size() / 50) << "more than rounding";
}

std::vector<uint8_t> tubeFile() {
    AvatarData avatar = makeTube({.splatsPerTriangle = 4, .rings = 10});
    avatar.trainedPixelM = kTrainedPixelM;
    sortSplats(avatar);
    return *writeAvatar(avatar);
}

DplCamera tubeView(float azimuth, float distanceM, float shiftM = 0) {
    const Cameraf c = tubeCamera(120, 96, azimuth, distanceM, shiftM);
    DplCamera out{sizeof(DplCamera), c.widthPx, c.heightPx, c.fx, c.fy, c.cx, c.cy, {}};
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) out.viewFromWorld[row * 4 + column] = c.viewFromWorldRotation[column][row];
        out.viewFromWorld[row * 4 + 3] = c.viewFromWorldTranslation[row];
    }
    return out;
}

class ProjectTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        const auto bytes = tubeFile();
        ASSERT_EQ(dplLoadAvatar(context_, bytes.data(), bytes.size(), &tube_), DPL_OK) << dplGetLastError();
        splats_.resize(1 << 16);
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(tube_), DPL_OK);
        ApiTest::TearDown();
    }
    DplProjection project(std::span<const DplCamera> views, std::span<const DplAvatar> avatars) {
        DplProjection made = emptyProjection();
        EXPECT_EQ(dplProject(context_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), splats_.data(),
                             uint32_t(splats_.size()), &made),
                  DPL_OK)
            << dplGetLastError();
        return made;
    }
    void expectRendered(std::span<const DplCamera> views, std::span<const DplAvatar> avatars, uint32_t samples) {
        const DplProjection made = project(views, avatars);
        ASSERT_EQ(made.samples, samples);
        std::vector<uint8_t> pixels[DPL_MAX_VIEWS];
        DplImage images[DPL_MAX_VIEWS] = {};
        for (size_t v = 0; v < views.size(); ++v) images[v] = imageFor(views[v], pixels[v]);
        ASSERT_EQ(dplRenderTogether(context_, avatars.data(), uint32_t(avatars.size()), views.data(), uint32_t(views.size()), images),
                  DPL_OK)
            << dplGetLastError();
        size_t first = 0;
        for (size_t v = 0; v < views.size(); first += made.counts[v++]) {
            const std::span<const DplScreenSplat> splats(splats_.data() + first, made.counts[v]);
            ASSERT_GT(splats.size(), 50u);
            EXPECT_TRUE(std::is_sorted(splats.begin(), splats.end(), [](const auto& a, const auto& b) { return a.depthM > b.depthM; }));
            expectSamePicture(blended(splats, views[v], samples), pixels[v]);
        }
    }

    DplAvatar tube_ = nullptr;
    std::vector<DplScreenSplat> splats_;
};

TEST_F(ProjectTest, blendedSplatsAreTheRenderedPicture) {
    const DplCamera view = tubeView(0.4f, 1.6f);
    expectRendered({&view, 1}, {&tube_, 1}, 1);
}

TEST_F(ProjectTest, farAwayTheyAreBlendedAtFourSamples) {
    const DplCamera view = tubeView(0.4f, 3.2f);
    expectRendered({&view, 1}, {&tube_, 1}, 4);
}

TEST_F(ProjectTest, secondViewFollowsTheFirst) {
    const DplCamera eyes[2] = {tubeView(0.4f, 1.6f, 0.03f), tubeView(0.4f, 1.6f, -0.03f)};
    expectRendered(eyes, {&tube_, 1}, 1);
}

TEST_F(ProjectTest, severalSubjectsAreSortedTogether) {
    const float aside[12] = {1, 0, 0, 0.1f, 0, 1, 0, -0.6f, 0, 0, 1, 0.1f};
    ASSERT_EQ(dplSetTransform(avatar_, aside), DPL_OK);
    const DplCamera view = tubeView(0.4f, 1.6f);
    const DplAvatar both[2] = {tube_, avatar_};
    const uint32_t alone = project({&view, 1}, {both, 1}).counts[0];
    EXPECT_GT(project({&view, 1}, both).counts[0], alone);
    expectRendered({&view, 1}, both, 1);
}

TEST_F(ProjectTest, theBudgetHoldsForProjectedSplats) {
    const DplCamera view = tubeView(0.4f, 1.6f);
    const uint32_t all = project({&view, 1}, {&tube_, 1}).counts[0];
    const DplDetail detail{sizeof(DplDetail), 0, all / 3};
    ASSERT_EQ(dplSetDetail(context_, &detail), DPL_OK);
    EXPECT_LE(project({&view, 1}, {&tube_, 1}).counts[0], all / 3);
    expectRendered({&view, 1}, {&tube_, 1}, 1);
}

TEST_F(ProjectTest, wrongCallsAreErrorsAndThePictureOfTheFrameIsNone) {
    const DplCamera view = tubeView(0.4f, 1.6f);
    DplProjection made = project({&view, 1}, {&tube_, 1});
    std::vector<uint8_t> pixels;
    const DplImage image = imageFor(view, pixels);
    EXPECT_EQ(dplReadImages(context_, tube_, &image, 1), DPL_ERROR_INVALID_ARGUMENT);
    const auto call = [&](const DplAvatar* avatars, uint32_t count, const DplCamera* views, uint32_t viewCount, DplScreenSplat* splats,
                          uint32_t capacity,
                          DplProjection* out) { return dplProject(context_, avatars, count, views, viewCount, splats, capacity, out); };
    const uint32_t capacity = uint32_t(splats_.size());
    EXPECT_EQ(call(&tube_, 1, &view, 1, splats_.data(), made.counts[0] - 1, &made), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(errorSays("room for")) << dplGetLastError();
    EXPECT_EQ(call(&tube_, 1, &view, 1, splats_.data(), made.counts[0], &made), DPL_OK);
    EXPECT_EQ(call(&tube_, 1, &view, 1, nullptr, capacity, &made), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(call(&tube_, 1, &view, 1, splats_.data(), capacity, nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(call(&tube_, 1, nullptr, 1, splats_.data(), capacity, &made), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(call(&tube_, 1, &view, 3, splats_.data(), capacity, &made), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(call(nullptr, 1, &view, 1, splats_.data(), capacity, &made), DPL_ERROR_INVALID_ARGUMENT);
    DplCamera wrong = view;
    wrong.fx = NAN;
    EXPECT_EQ(call(&tube_, 1, &wrong, 1, splats_.data(), capacity, &made), DPL_ERROR_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace dpl::test
