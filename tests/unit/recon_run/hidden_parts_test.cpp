// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/hidden_parts.h"

#include <gtest/gtest.h>

#include <array>

#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

constexpr glm::u8vec4 kSkin(200, 150, 120, 255), kTooth(240, 230, 210, 255);
constexpr uint32_t kBoxTriangles = 12;

/** Appends a cube of one colour; sizeM is half of its side. */
void addCube(float sizeM, const glm::u8vec4& colour, MeshData& mesh) {
    const auto first = uint32_t(mesh.restPositions.size());
    for (int i = 0; i < 8; ++i) {
        mesh.restPositions.push_back(sizeM * Vec3f(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1) + Vec3f(0, 1.6f, 0));
        mesh.colours.push_back(colour);
    }
    constexpr std::array<std::array<uint32_t, 4>, 6> kSides = {
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& s : kSides)
        mesh.triangles.push_back(Triangle(s[0], s[1], s[2]) + first), mesh.triangles.push_back(Triangle(s[0], s[2], s[3]) + first);
}

/** A head of skin with a tooth inside. */
struct Head {
    BodyModel body;
    AvatarData avatar;

    Head() {
        addCube(0.05f, kSkin, body.mesh);
        addCube(0.01f, kTooth, body.mesh);
        for (int extra = 0; extra < 2; ++extra) {  // skin is the most frequent colour
            body.mesh.restPositions.push_back({0, 1.6f, 0}), body.mesh.colours.push_back(kSkin);
        }
        body.expressions = {{17, std::vector<Vec3f>(body.mesh.restPositions.size(), Vec3f(0, -0.01f, 0))}};
        avatar.mesh = body.mesh;
        for (uint32_t t = 0; t <= body.mesh.triangles.size(); ++t) avatar.splats.triangleStart.push_back(t);
        for (uint32_t t = 0; t < body.mesh.triangles.size(); ++t) {
            avatar.splats.uv.emplace_back(0.3f, 0.3f), avatar.splats.phi.push_back(0), avatar.splats.scaleM.emplace_back(0.004f, 0.004f);
            avatar.splats.opacity.push_back(0.8f), avatar.splats.flags.push_back(0);
            avatar.splats.sh.insert(avatar.splats.sh.end(), {-1.0f, -1.0f, -1.0f});
        }
    }
    Vec3f colourOf(uint32_t splat) const {
        const float* sh = &avatar.splats.sh[3 * splat];
        return Vec3f(sh[0], sh[1], sh[2]) * float(kShC0) + 0.5f;
    }
};

TEST(HiddenParts, aToothInsideTakesTheBodysColourAndSkinStays) {
    Head head;
    const SplatData before = head.avatar.splats;
    EXPECT_EQ(must(paintHiddenParts(head.avatar, head.body)), size_t(12));
    const SplatData& after = head.avatar.splats;
    for (uint32_t t = 0; t < kBoxTriangles; ++t) {
        ASSERT_EQ(after.triangleStart[t], t);
        EXPECT_EQ(after.opacity[t], before.opacity[t]);
    }
    EXPECT_GT(after.count(), before.count()) << "a tooth of 2 cm has more than a splat a triangle";
    for (uint32_t i = after.triangleStart[kBoxTriangles]; i < after.count(); ++i)
        EXPECT_LT(glm::length(head.colourOf(i) - Vec3f(kTooth) / 255.0f), 1e-5f);
}

TEST(HiddenParts, whatCamerasSeeKeepsWhatItLearned) {
    Head head;
    for (size_t v = 0; v < 8; ++v) head.avatar.mesh.restPositions[v].x += 0.2f;  // the skin no longer covers it
    const std::vector<float> before = head.avatar.splats.sh;
    EXPECT_EQ(must(paintHiddenParts(head.avatar, head.body)), size_t(0));
    EXPECT_EQ(head.avatar.splats.sh, before);
}

TEST(HiddenParts, aBodyOfOneColourOrWithoutExpressionsHidesNothing) {
    Head head;
    head.body.mesh.colours.assign(head.body.mesh.colours.size(), kSkin);
    EXPECT_EQ(must(paintHiddenParts(head.avatar, head.body)), size_t(0));
    Head still;
    still.body.expressions.clear();
    EXPECT_EQ(must(paintHiddenParts(still.avatar, still.body)), size_t(0));
}

}  // namespace
}  // namespace dpl
