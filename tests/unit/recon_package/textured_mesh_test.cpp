// SPDX-License-Identifier: Apache-2.0
// The exported mesh of the procedural subject looks, in a viewer that knows nothing of splats, as dplRender draws the avatar.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <doppel/doppel.hpp>
#include <filesystem>

#include "reconstruction/base/sdk_camera.h"
#include "reconstruction/output/package/export_mesh.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/core/files.h"
#include "tests/unit/recon_package/stock_viewer.h"

namespace dpl {
namespace {

constexpr int kOutlinePx = 2;  // splats fade there, and a mesh does not

/** Squared differences in [0, 1]. */
struct Difference {
    double squares = 0, values = 0;
    void add(const uint8_t* rgba, const Vec3f& shown) {
        for (int k = 0; k < 3; ++k)
            squares += std::pow(rgba[k] / 255.0 + 0.5 * (1 - rgba[3] / 255.0) - double(shown[k]), 2), ++values;  // over mid grey
    }
    double psnrDb() const { return 10 * std::log10(values / squares); }
};

class TexturedMesh : public testing::Test {
protected:
    static void SetUpTestSuite() {
        Jobs jobs;
        auto file = makeSampleAvatarFile(makeSubject(1, jobs), jobs);
        ASSERT_TRUE(file) << file.error().message;
        const auto folder = std::filesystem::temp_directory_path() / ("doppel_textured_mesh_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder);
        ASSERT_TRUE(bool(writeFileAtomically(folder / "avatar.glb", *file)));
        const auto line = exportMesh({.avatar = folder / "avatar.glb", .out = folder / "mesh.glb"});
        ASSERT_TRUE(line) << line.error().message;
        avatar_ = std::move(*file), mesh_ = *readFile(folder / "mesh.glb", 1u << 26);
        std::filesystem::remove_all(folder);
    }
    static std::vector<uint8_t> avatar_, mesh_;
};
std::vector<uint8_t> TexturedMesh::avatar_, TexturedMesh::mesh_;

TEST_F(TexturedMesh, looksLikeTheSplatsFromEightSides) {
    const test::StockViewer viewer(mesh_);
    Vec3f low(1e9f), high(-1e9f);
    for (const Vec3f& p : viewer.positions()) low = glm::min(low, p), high = glm::max(high, p);
    const float height = high.y - low.y, neckY = high.y - 0.13f * height;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(avatar_);
    ASSERT_TRUE(avatar) << avatar.error().message;

    Difference whole, face, print;
    for (int side = 0; side < 8; ++side) {
        const Camerad camera = orbitCamera(0.5 * Vec3d(low + high), 3, side * M_PI / 4, 0.05, 1728, 720, 1280);
        std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
        const DplCamera view = sdkCamera(camera.cast<float>());
        DplImage image = doppel::Image();
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        const auto drawn = avatar->render(std::span(&view, 1), std::span(&image, 1));
        ASSERT_TRUE(drawn) << drawn.error().message;
        const auto shown = viewer.draw(camera);
        for (int y = kOutlinePx; y < int(camera.heightPx) - kOutlinePx; ++y)
            for (int x = kOutlinePx; x < int(camera.widthPx) - kOutlinePx; ++x) {
                const size_t p = size_t(y) * camera.widthPx + x;
                bool inside = rgba[4 * p + 3] > 127;
                for (int dy = -kOutlinePx; inside && dy <= kOutlinePx; ++dy)
                    for (int dx = -kOutlinePx; inside && dx <= kOutlinePx; ++dx) inside = shown.whole[p + dy * int(camera.widthPx) + dx];
                if (!inside) continue;
                whole.add(&rgba[4 * p], shown.rgb[p]);
                const std::string& layer = viewer.model().meshes[shown.mesh[p]].name;
                const Vec3f at = shown.place[p];
                if (layer == "body" && at.y > neckY && at.z > 0) face.add(&rgba[4 * p], shown.rgb[p]);
                const float up = (at.y - low.y) / height;
                if (layer == "top" && side == 0 && std::abs(at.x) < 0.13f && up > 0.68f && up < 0.8f) print.add(&rgba[4 * p], shown.rgb[p]);
            }
    }
    std::printf("whole %.2f dB, face %.2f dB, print %.2f dB\n", whole.psnrDb(), face.psnrDb(), print.psnrDb());
    EXPECT_GT(whole.values, 3e6) << "the pictures are not empty";
    EXPECT_GT(face.values, 3e4);
    EXPECT_GT(print.values, 3e4);
    // 33.0, 32.6 and 30.8 dB were measured. Vertex colours have 14.7 dB.
    EXPECT_GT(whole.psnrDb(), 31);
    EXPECT_GT(face.psnrDb(), 31);
    EXPECT_GT(print.psnrDb(), 29);
}

}  // namespace
}  // namespace dpl
