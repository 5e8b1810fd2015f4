// SPDX-License-Identifier: Apache-2.0
// The sample avatar looks as the subject that it was painted on: dplRender against pictures by ray casting.
#include <gtest/gtest.h>

#include <cmath>
#include <doppel/doppel.hpp>

#include "reconstruction/base/sdk_camera.h"
#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

constexpr int kOutlinePx = 2;  // splats fade there

struct Look {
    double squares = 0, values = 0, transmitted = 0, inside = 0;
    double psnrDb() const { return 10 * std::log10(values / squares); }
};

/** Over black, at least kOutlinePx inside the subject's outline. */
void compare(const RaycastFrame& truth, const std::vector<uint8_t>& rgba, const Camerad& camera, Look& look) {
    const int width = int(camera.widthPx), height = int(camera.heightPx);
    for (int y = kOutlinePx; y < height - kOutlinePx; ++y)
        for (int x = kOutlinePx; x < width - kOutlinePx; ++x) {
            bool inside = true;
            for (int dy = -kOutlinePx; inside && dy <= kOutlinePx; ++dy)
                for (int dx = -kOutlinePx; inside && dx <= kOutlinePx; ++dx) inside = truth.mask[size_t(y + dy) * width + x + dx] > 0;
            if (!inside) continue;
            const size_t p = size_t(y) * width + x;
            for (int k = 0; k < 3; ++k) look.squares += std::pow((rgba[4 * p + k] - truth.rgb[3 * p + k]) / 255.0, 2), ++look.values;
            look.transmitted += 1 - rgba[4 * p + 3] / 255.0, ++look.inside;
        }
}

TEST(SampleAvatar, looksAsItsSubjectAndLetsNoLightThrough) {
    Jobs jobs;
    const auto file = makeSampleAvatarFile(subject(), jobs);
    ASSERT_TRUE(file) << file.error().message;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(*file);
    ASSERT_TRUE(avatar) << avatar.error().message;
    PersonTracer tracer(subject());
    const auto& rest = subject().mesh.restPositions;
    tracer.setVertices({rest.begin(), rest.end()});
    Vec3d low(1e9), high(-1e9);
    for (const Vec3f& p : rest) low = glm::min(low, Vec3d(p)), high = glm::max(high, Vec3d(p));
    Look look;
    for (int side = 0; side < 4; ++side) {
        const Camerad camera = orbitCamera(0.5 * (low + high), 3, side * M_PI / 2 + 0.2, 0.05, 1400, 720, 1280);
        std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
        const DplCamera view = sdkCamera(camera.cast<float>());
        DplImage image = doppel::Image();
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        const auto drawn = avatar->render(std::span(&view, 1), std::span(&image, 1));
        ASSERT_TRUE(drawn) << drawn.error().message;
        compare(tracer.render(camera, {.samplesPerPixel = 9, .sensorNoise = 0}), rgba, camera, look);
    }
    RecordProperty("psnr_db", std::to_string(look.psnrDb()));
    const double transmitted = look.transmitted / look.inside;
    RecordProperty("transmitted", std::to_string(transmitted));
    std::printf("    %.2f dB, %.2f %% of the light comes through\n", look.psnrDb(), 100 * transmitted);
    EXPECT_GT(look.inside, 200'000);
    EXPECT_GT(look.psnrDb(), 26);
    EXPECT_LT(transmitted, 0.03);
}

}  // namespace
}  // namespace dpl
