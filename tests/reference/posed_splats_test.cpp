// SPDX-License-Identifier: Apache-2.0
// Splats that dplWriteSplats wrote, drawn by the referee as general splats, are the picture of dplRender.
#include <gtest/gtest.h>

#include <cstdio>

#include "apps/reference/reference_renderer.h"
#include "sdk/format/avatar_file.h"
#include "sdk/include/doppel/doppel.hpp"
#include "tests/reference/compare_renderers.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

using doppel::bufferElement, doppel::SplatOptions;

/** Eight bits of the library's picture alone give 58.9 dB where all of it is covered; here a third is. */
constexpr double kPictureBarDb = 60;

StaticSplatData writtenSplats(const doppel::Avatar& avatar, const SplatOptions& options) {
    struct Splat {
        float position[3], rotation[4], scale[3], opacity, sh[27];
    };
    const std::vector<DplBufferElement> places = {bufferElement(DPL_SPLAT_POSITION, offsetof(Splat, position), sizeof(Splat)),
                                                  bufferElement(DPL_SPLAT_ROTATION, offsetof(Splat, rotation), sizeof(Splat)),
                                                  bufferElement(DPL_SPLAT_SCALE, offsetof(Splat, scale), sizeof(Splat)),
                                                  bufferElement(DPL_SPLAT_OPACITY, offsetof(Splat, opacity), sizeof(Splat)),
                                                  bufferElement(DPL_SPLAT_SH, offsetof(Splat, sh), sizeof(Splat))};
    std::vector<Splat> splats(*avatar.splatCount(options));
    EXPECT_TRUE(avatar.writeSplats(places, std::as_writable_bytes(std::span(splats)), options));
    StaticSplatData out;
    out.shDegree = 2;
    for (const Splat& s : splats) {
        out.position.push_back({s.position[0], s.position[1], s.position[2]});
        out.rotation.push_back(Quatf(s.rotation[3], s.rotation[0], s.rotation[1], s.rotation[2]));
        out.scaleM.push_back({s.scale[0], s.scale[1], s.scale[2]});
        out.opacity.push_back(s.opacity);
        out.sh.insert(out.sh.end(), s.sh, s.sh + 27);
    }
    return out;
}

struct Case {
    const char* name;
    float bend, azimuth, distanceM;
    bool placed;
};

TEST(PosedSplatsDrawn, areThePictureOfTheLibrary) {
    AvatarData data = test::withCorrectives(makeTube({.splatsPerTriangle = 4}), 3);
    sortSplats(data);
    const auto bytes = writeAvatar(data);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const DplContextInfo info{sizeof info, DPL_RENDERER_SOFTWARE, 1};
    DplContext context = nullptr;
    ASSERT_EQ(dplCreateContext(&info, &context), DPL_OK) << dplGetLastError();
    DplAvatar handle = nullptr;
    ASSERT_EQ(dplLoadAvatar(context, bytes->data(), bytes->size(), &handle), DPL_OK) << dplGetLastError();
    {
        doppel::Avatar avatar(context, handle);
        for (const Case& c : {Case{"at rest", 0, 0.4f, 1.8f, false}, Case{"bent", 0.9f, 2.3f, 1.8f, false},
                              Case{"bent, near", -0.7f, 4.0f, 0.9f, false}, Case{"bent, placed", 0.6f, 0.9f, 1.8f, true}}) {
            const Pose pose = tubePose(c.bend, 0.3f);
            const float rotations[8] = {pose.localRotations[0].x, pose.localRotations[0].y, pose.localRotations[0].z,
                                        pose.localRotations[0].w, pose.localRotations[1].x, pose.localRotations[1].y,
                                        pose.localRotations[1].z, pose.localRotations[1].w};
            ASSERT_TRUE(avatar.setPose(rotations));
            ASSERT_TRUE(avatar.stand({0, 0, 0}, c.placed ? 1.2f : 0, c.placed ? 0.8f : 1));
            const Cameraf camera = tubeCamera(160, 160, c.azimuth, c.distanceM);
            const Vec3f eye = camera.eye();
            SplatOptions options;
            options.eye = &eye.x, options.shDegree = 2;
            const ReferenceImage drawn =
                renderReference(writtenSplats(avatar, options), referenceCamera(camera), {.kappaPx2 = data.kappaPx2, .compensated = true});

            DplCamera view{sizeof(DplCamera), camera.widthPx, camera.heightPx, camera.fx, camera.fy, camera.cx, camera.cy, {}};
            for (int row = 0; row < 3; ++row) {
                for (int column = 0; column < 3; ++column) view.viewFromWorld[row * 4 + column] = camera.viewFromWorldRotation[column][row];
                view.viewFromWorld[row * 4 + 3] = camera.viewFromWorldTranslation[row];
            }
            std::vector<uint8_t> pixels(size_t(160) * 160 * 4);
            const DplImage image{sizeof image, 0, pixels.data(), pixels.size()};
            ASSERT_TRUE(avatar.render({&view, 1}, {&image, 1}));
            std::vector<double> ours, theirs;
            for (size_t p = 0; p < pixels.size(); ++p) {
                ours.push_back(pixels[p] / 255.0);
                theirs.push_back(p % 4 == 3 ? drawn.alpha[p / 4] : drawn.rgb[p / 4 * 3 + p % 4]);
            }
            const ImageDifference d = compareImages(ours, theirs);
            std::printf("[  SPLATS  ] %s: %.2f dB, max %.4f, covered %.1f %%\n", c.name, d.psnrDb, d.maxError, 100 * coverage(drawn.alpha));
            EXPECT_GT(coverage(drawn.alpha), 0.1);
            EXPECT_GE(d.psnrDb, kPictureBarDb) << c.name;
        }
    }
    EXPECT_EQ(dplDestroyContext(context), DPL_OK);
}

}  // namespace
}  // namespace dpl
