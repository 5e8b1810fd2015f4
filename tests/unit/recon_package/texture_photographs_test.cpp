// SPDX-License-Identifier: Apache-2.0
// Photographs give a texture their detail, and neither their light nor what only one of them shows.
#include "reconstruction/output/package/texture_photographs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

constexpr float kPeriodM = 0.015f, kStripes = 0.1f, kHalfM = 0.15f;

/** A grey square that faces +z, and its atlas. */
struct Square {
    AvatarData avatar;
    MeshAtlas atlas;
    Square() {
        avatar.joints = {{"root", -1, Vec3f(0)}};
        avatar.mesh.restPositions = {{-kHalfM, -kHalfM, 0}, {kHalfM, -kHalfM, 0}, {kHalfM, kHalfM, 0}, {-kHalfM, kHalfM, 0}};
        avatar.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        avatar.mesh.jointIndices.assign(4, {0, 0, 0, 0}), avatar.mesh.jointWeights.assign(4, {255, 0, 0, 0});
        avatar.mesh.colours.assign(4, glm::u8vec4(255));
        avatar.mesh.layers = {{"body", "body", 0, 4, 0, 2}};
        const std::vector<AtlasKind> kinds(2);
        atlas = *layOutAtlas(avatar.mesh.restPositions, avatar.mesh.triangles, kinds, 256);
    }
};

float stripes(float xM) {
    return kStripes * std::sin(2 * float(M_PI) * xM / kPeriodM);
}

/** From 1 m ahead; its pixels have 2.5 mm. level: of the square, 0 to 1, brighter towards the top. */
TrainFrame photograph(float level, float stripeSign = 1, uint8_t mask = 255) {
    TrainFrame frame;
    frame.pose = Pose::rest(1);
    Camerad& camera = frame.camera;
    camera.widthPx = camera.heightPx = 160, camera.fx = camera.fy = 400, camera.cx = camera.cy = 80;
    camera.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    camera.viewFromWorldTranslation = {0, 0, 1};
    auto picture = std::make_shared<FramePicture>();
    picture->image = {160, 160, std::vector<uint8_t>(160 * 160 * 3)}, picture->mask = {160, 160, std::vector<uint8_t>(160 * 160, mask)};
    for (size_t p = 0; p < 160 * 160; ++p) {
        const float x = (float(p % 160) + 0.5f - 80) / 400, up = (80 - float(p / 160)) / 80;
        for (size_t c = 0; c < 3; ++c)
            picture->image.pixels[3 * p + c] = uint8_t(std::lround(255 * (level + 0.1f * up + stripeSign * stripes(x))));
    }
    frame.picture = std::shared_ptr<const FramePicture>(picture);
    return frame;
}

struct Found {
    float stripes = 0;        // how much of the stripes the texels have: 1 is all
    float mean = 0, top = 0;  // colours; top: of the upper quarter
};

Found after(const std::vector<TrainFrame>& photographs) {
    const Square square;
    const AtlasTexels texels(square.atlas);
    std::vector<Vec3f> colours(texels.all.size(), Vec3f(0.5f));
    const std::vector<uint8_t> texture(256 * 256 * 3, 128);
    Jobs jobs(1);
    const Status added = addPhotographs(square.avatar, square.atlas, texels, texture, photographs, colours, jobs);
    EXPECT_TRUE(added) << added.error().message;
    Found out;
    double both = 0, own = 0, sum = 0, count = 0, top = 0, topCount = 0;
    for (size_t t = 0; t < 2; ++t)
        for (uint32_t i = texels.start[t]; i < texels.start[t + 1]; ++i) {
            const auto& c = square.avatar.mesh.triangles[t];
            const Vec2f at = texels.all[i].barycentric;
            const auto& v = square.avatar.mesh.restPositions;
            const Vec3f p = (1 - at.x - at.y) * v[c.x] + at.x * v[c.y] + at.y * v[c.z];
            if (std::max(std::abs(p.x), std::abs(p.y)) > 0.8f * kHalfM) continue;  // the margin of the mask
            both += double(stripes(p.x)) * double(colours[i].x - 0.5f), own += double(stripes(p.x)) * double(stripes(p.x));
            sum += double(colours[i].y), ++count;
            if (p.y > 0.5f * kHalfM) top += double(colours[i].z), ++topCount;
        }
    EXPECT_GT(count, 1000);
    out.stripes = float(both / own), out.mean = float(sum / count), out.top = float(top / topCount);
    return out;
}

TEST(TexturePhotographs, theirDetailIsAddedAndTheirLightIsNot) {
    const Found r = after({photograph(0.3f), photograph(0.45f), photograph(0.6f)});
    EXPECT_GT(r.stripes, 0.7f);  // bilinear samples of 6 pixels a period keep 0.83 of it
    EXPECT_LT(r.stripes, 1.05f);
    EXPECT_NEAR(r.mean, 0.5f, 0.004f);
    EXPECT_NEAR(r.top, 0.5f, 0.01f);
}

TEST(TexturePhotographs, whatOneOfManyShowsCountsLittle) {
    const Found r = after({photograph(0.45f), photograph(0.45f), photograph(0.45f), photograph(0.45f), photograph(0.45f, -1)});
    EXPECT_GT(r.stripes, 0.6f);
    EXPECT_LT(after({photograph(0.45f)}).stripes, 0.55f) << "what no other confirms counts half";
}

TEST(TexturePhotographs, outsideTheMaskOrFromBehindTheyAddNothing) {
    EXPECT_EQ(after({photograph(0.45f, 1, 0)}).stripes, 0);
    TrainFrame behind = photograph(0.45f);
    behind.camera.viewFromWorldRotation = Mat3d(-1, 0, 0, 0, -1, 0, 0, 0, 1);
    EXPECT_EQ(after({behind, behind}).stripes, 0);
}

}  // namespace
}  // namespace dpl
