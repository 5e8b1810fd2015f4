// SPDX-License-Identifier: Apache-2.0
// A captured object in a file of another tool: the CPU renderer's picture against an independent rasteriser's and the referee's.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "sdk/core/files.h"
#include "sdk/format/splat_file.h"
#include "tests/reference/compare_renderers.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

/** Measured over grey: 68.7 to 70.6 dB, mean error 0.02 levels. The 8-bit rounding of the reference PNGs explains it: ±½ level on the 7 to
 * 10 % of pixels that are covered gives 69 to 70 dB. Splats 1 % larger give 63 to 65 dB, a shift by half a pixel 35 to 38 dB. */
constexpr double kPictureBarDb = 67, kMeanErrorBar = 0.05 / 255;
constexpr double kReferenceBarDb = 88;  // as in software_vs_reference_test.cpp

struct Guitar {
    StaticSplatData splats;
    nlohmann::json cameras;
    std::filesystem::path folder;
};

/** The guitar in the metres of its reference cameras, or nothing. */
std::optional<Guitar> readGuitar() {
    const auto file = sharedData("splats/guitar.compressed.ply"), folder = sharedData("splats/guitar-reference");
    if (!file || !folder) return std::nullopt;
    Guitar g;
    g.folder = *folder;
    g.cameras = nlohmann::json::parse(std::ifstream(*folder / "cameras.json"));
    auto read = readSplats(*readFile(*file));
    EXPECT_TRUE(read) << (read ? "" : read.error().message);
    if (!read) return std::nullopt;
    g.splats = std::move(read->splats);
    const auto& place = g.cameras["source_to_world"];
    const float s = place["s"].get<float>();
    const Vec3f c(place["c"][0].get<float>(), place["c"][1].get<float>(), place["c"][2].get<float>());
    for (Vec3f& p : g.splats.position) p = s * Vec3f(1, -1, -1) * (p - c);
    for (Vec3f& scale : g.splats.scaleM) scale *= s;
    for (Quatf& q : g.splats.rotation) q = Quatf(0, 1, 0, 0) * q;  // diag(1, −1, −1) is half a turn about x
    return g;
}

Cameraf cameraOf(const nlohmann::json& all, const nlohmann::json& frame) {
    Cameraf c;
    c.widthPx = all["width"].get<uint32_t>(), c.heightPx = all["height"].get<uint32_t>();
    c.fx = all["fx"].get<float>(), c.fy = all["fy"].get<float>(), c.cx = all["cx"].get<float>(), c.cy = all["cy"].get<float>();
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            c.viewFromWorldRotation[column][row] = frame["world_to_camera"][size_t(row)][size_t(column)].get<float>();
        c.viewFromWorldTranslation[row] = frame["world_to_camera"][size_t(row)][3].get<float>();
    }
    return c;
}

TEST(Guitar, looksAsAnIndependentRasteriserDrawsIt) {
    const auto guitar = readGuitar();
    if (!guitar) GTEST_SKIP() << "no shared data with splats/guitar.compressed.ply and splats/guitar-reference";
    for (const auto& frame : guitar->cameras["frames"]) {
        const std::string name = frame["file"].get<std::string>();
        const cv::Mat picture = cv::imread((guitar->folder / name).string(), cv::IMREAD_UNCHANGED);  // BGRA, straight
        const Cameraf camera = cameraOf(guitar->cameras, frame);
        ASSERT_EQ(picture.channels(), 4);
        const SplatImage image = drawSoftware(guitar->splats, camera);
        ASSERT_EQ(size_t(picture.rows) * size_t(picture.cols), image.alpha.size());
        constexpr double kGrey = 0.45;
        std::vector<double> ours, theirs;
        double sum = 0;
        for (size_t i = 0; i < image.alpha.size(); ++i) {
            const cv::Vec4b& p = picture.at<cv::Vec4b>(int(i / camera.widthPx), int(i % camera.widthPx));
            for (size_t c = 0; c < 3; ++c) {
                ours.push_back(image.rgb[i * 3 + c] + (1 - image.alpha[i]) * kGrey);
                theirs.push_back(p[int(2 - c)] / 255.0 * p[3] / 255.0 + (1 - p[3] / 255.0) * kGrey);
                sum += std::abs(ours.back() - theirs.back());
            }
        }
        const ImageDifference d = compareImages(ours, theirs);
        std::printf("[  GUITAR  ] %s: %.2f dB, mean error %.2f levels, max %.3f, covered %.1f %%\n", name.c_str(), d.psnrDb,
                    255 * sum / double(ours.size()), d.maxError, 100 * coverage(image.alpha));
        EXPECT_GT(coverage(image.alpha), 0.03);
        EXPECT_GE(d.psnrDb, kPictureBarDb) << name;
        EXPECT_LT(sum / double(ours.size()), kMeanErrorBar) << name;
    }
}

TEST(Guitar, equalsTheReferee) {
    const auto guitar = readGuitar();
    if (!guitar) GTEST_SKIP() << "no shared data with splats/guitar.compressed.ply and splats/guitar-reference";
    const Cameraf camera = cameraOf(guitar->cameras, guitar->cameras["frames"][0]).scaled(0.25f);
    const ReferenceImage reference = renderReference(guitar->splats, referenceCamera(camera));
    expectSameImage("guitar", drawSoftware(guitar->splats, camera), reference, kReferenceBarDb);
}

}  // namespace
}  // namespace dpl
