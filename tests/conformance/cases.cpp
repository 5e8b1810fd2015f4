// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/cases.h"

#include <cmath>
#include <random>

#include "sdk/format/avatar_file.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/avatar/clothed_legs.h"

namespace dpl {
namespace {

constexpr float kPi = 3.14159265f;

struct Splat {
    uint32_t triangle = 0;
    Vec2f uv{0.3f, 0.3f};
    float phi = 0.4f;
    Vec2f scaleM{0.02f, 0.01f};
    float opacity = 0.9f;
    uint8_t flags = 0;
    Vec3f colour{1.6f, -1.2f, 0.5f};  // SH of degree 0
};

/** Separate triangles (three corners each) with splats of SH degree 0. Each corner follows joint 0 or 1; joint 1 is a child of joint 0 at
 *  `joint`. */
AvatarData triangles(const std::vector<Vec3f>& corners, std::vector<Splat> splats, const std::vector<int>& jointOfCorner = {},
                     const Vec3f& joint = Vec3f(0, 0.5f, 0)) {
    AvatarData a;
    a.name = "conformance";
    a.joints = {{"root", -1, Vec3f(0), "hips"}, {"upper", 0, joint, "spine"}};
    for (size_t v = 0; v < corners.size(); ++v) {
        a.mesh.restPositions.push_back(corners[v]);
        a.mesh.jointIndices.emplace_back(jointOfCorner.empty() ? 0 : jointOfCorner[v], 0, 0, 0);
        a.mesh.jointWeights.emplace_back(255, 0, 0, 0);
        a.mesh.colours.emplace_back(128, 128, 128, 255);
        if (v % 3 == 2) a.mesh.triangles.push_back({uint32_t(v - 2), uint32_t(v - 1), uint32_t(v)});
    }
    a.mesh.layers = {{"body", "body", 0, uint32_t(corners.size()), 0, uint32_t(a.mesh.triangles.size())}};
    std::stable_sort(splats.begin(), splats.end(), [](const Splat& l, const Splat& r) { return l.triangle < r.triangle; });
    SplatData& s = a.splats;
    s.triangleStart.assign(a.mesh.triangles.size() + 1, 0);
    for (const Splat& splat : splats) {
        s.uv.push_back(splat.uv), s.phi.push_back(splat.phi), s.scaleM.push_back(splat.scaleM), s.opacity.push_back(splat.opacity),
            s.flags.push_back(splat.flags);
        for (int c = 0; c < 3; ++c) s.sh.push_back(splat.colour[c]);
        for (size_t t = splat.triangle + 1; t < s.triangleStart.size(); ++t) ++s.triangleStart[t];
    }
    sortSplats(a);
    return a;
}

const std::vector<Vec3f> kFlat = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}};

Cameraf facing(float distanceM, uint32_t widthPx, uint32_t heightPx, float focalPx) {
    return lookAt({0.03f, 0.03f, distanceM}, {0.03f, 0.03f, 0}, widthPx, heightPx, focalPx);
}

Pose turned(float radians, const Vec3f& axis) {
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(radians, axis);
    return pose;
}

/** The camera moved to its right and turned about its own vertical axis. */
Cameraf eye(Cameraf c, float rightM, float yawRad) {
    const Mat3f turn = glm::mat3_cast(glm::angleAxis(yawRad, Vec3f(0, 1, 0)));
    c.viewFromWorldTranslation.x -= rightM;
    c.viewFromWorldRotation = turn * c.viewFromWorldRotation;
    c.viewFromWorldTranslation = turn * c.viewFromWorldTranslation;
    return c;
}

std::vector<Splat> needles() {
    std::vector<Splat> splats;
    for (int i = 0; i < 12; ++i)
        splats.push_back(
            {.phi = 0.26f * float(i), .scaleM = {0.05f, 1e-4f}, .opacity = 0.95f, .colour = {0.1f * float(i), 0.8f, -0.05f * float(i)}});
    return splats;
}

/** Overlapping opaque splats, side × side on each of `layers` parallel sheets. */
AvatarData sheets(int layers, int side, float apartM) {
    std::vector<Vec3f> corners;
    std::vector<Splat> splats;
    for (int l = 0; l < layers; ++l) {
        const float z = -apartM * float(l);
        corners.insert(corners.end(), {{-0.2f, -0.2f, z}, {0.6f, -0.2f, z}, {-0.2f, 0.6f, z}});
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j)
                splats.push_back({.triangle = uint32_t(l),
                                  .uv = {(float(i) + 0.5f) / float(2 * side), (float(j) + 0.5f) / float(2 * side)},
                                  .phi = 0.3f * float(i + j),
                                  .scaleM = {0.05f, 0.04f},
                                  .opacity = 1,
                                  .colour = {std::sin(float(7 * l + i)), std::cos(float(3 * l + j)), std::sin(float(l + i * j))}});
    }
    return triangles(corners, splats);
}

/** Legs in a skirt with motion modes; a random splat or two on each triangle. */
AvatarData skirt() {
    AvatarData a = test::clothedLegs();
    for (Vec4f& value : a.correctives.nodes) value *= 3.0f;  // so that a renderer that forgets is noticed
    std::mt19937 random(17);
    std::uniform_real_distribution<float> uniform(0, 1);
    a.mesh.colours.assign(a.mesh.restPositions.size(), {128, 128, 128, 255});
    a.splats.triangleStart.push_back(0);
    for (size_t t = 0; t < a.mesh.triangles.size(); ++t) {
        const float u = uniform(random), v = uniform(random);
        a.splats.uv.push_back(u + v > 1 ? Vec2f(1 - u, 1 - v) : Vec2f(u, v));
        a.splats.phi.push_back(6 * uniform(random));
        a.splats.scaleM.push_back(Vec2f(0.01f + 0.01f * uniform(random), 0.01f));
        a.splats.opacity.push_back(0.3f + 0.7f * uniform(random));
        a.splats.flags.push_back(0);
        for (int c = 0; c < 3; ++c) a.splats.sh.push_back(2 * uniform(random) - 1);
        a.splats.triangleStart.push_back(a.splats.count());
    }
    return a;
}

}  // namespace

std::vector<ConformanceCase> conformanceCases() {
    std::vector<ConformanceCase> cases;
    const Pose rest = Pose::rest(2);
    const auto add = [&](const char* name, const char* about, AvatarData avatar, Pose pose,
                         std::vector<Cameraf> views) -> ConformanceCase& {
        return cases.emplace_back(ConformanceCase{name, about, std::move(avatar), std::move(pose), std::move(views), false, {}});
    };
    add("one-splat", "a single flat Gaussian: footprint, low-pass, pixel centres at +0.5", triangles(kFlat, {{.scaleM = {0.02f, 0.03f}}}),
        rest, {facing(1, 64, 48, 300)});
    add("one-pixel", "an image of one pixel", triangles(kFlat, {{.scaleM = {0.02f, 0.03f}}}), rest, {facing(1, 1, 1, 30)});
    add("nothing", "a splat seen only from its wrong side: every pixel stays transparent", triangles(kFlat, {{.flags = kSplatSingleFace}}),
        rest, {facing(-1, 64, 48, 300)})
        .mayBeBlank = true;
    add("needles", "needles of aspect 500 at many angles: ill-conditioned conics", triangles(kFlat, needles()), rest,
        {facing(1, 160, 160, 1600)});
    add("edge-on", "discs seen within half a degree of their plane", triangles(kFlat, {{}, {.phi = 1.2f, .scaleM = {0.01f, 0.02f}}}), rest,
        {lookAt({0.03f, 1, 0.008f}, {0.03f, 0.03f, 0}, 100, 80, 900)});
    add("grazing-gate", "a single-faced splat inside the ramp of its gate", triangles(kFlat, {{.flags = kSplatSingleFace}}), rest,
        {lookAt({0.03f, 1, 0.09f}, {0.03f, 0.03f, 0}, 80, 60, 1200)});
    add("larger-than-the-screen", "a splat of 5 m behind one of 2 cm: nothing may be culled by size",
        triangles(kFlat, {{.scaleM = {5, 3}, .opacity = 0.6f}, {}}), rest, {facing(1, 120, 90, 100)});
    add("specks", "splats far below a pixel keep their energy",
        triangles(kFlat, {{.scaleM = {1e-4f, 1e-4f}},
                          {.uv = {0.1f, 0.6f}, .scaleM = {1e-3f, 1e-3f}, .opacity = 1},
                          {.uv = {0.6f, 0.1f}, .scaleM = {3e-4f, 1e-3f}, .opacity = 1}}),
        rest, {facing(1, 80, 80, 600)});
    add("off-screen-tail", "a splat centred far outside the image whose tail reaches in: the clamped Jacobian",
        triangles({{1.2f, 0, 0}, {1.2f, 0.1f, 0}, {1.2f, 0, 0.1f}}, {{.scaleM = {0.4f, 0.3f}, .opacity = 0.99f}}), rest,
        {lookAt({0, 0, 1}, {0, 0, 0}, 100, 100, 70)});
    add("near-fade", "splats from the near limit through the end of the fade",
        [] {
            std::vector<Vec3f> corners;
            std::vector<Splat> splats;
            for (int i = 0; i < 24; ++i) {
                const float z = 0.96f - 0.008f * float(i), x = 0.006f * float(i) - 0.07f;
                corners.insert(corners.end(), {{x, 0, z}, {x + 0.02f, 0, z}, {x, 0.02f, z}});
                splats.push_back(
                    {.triangle = uint32_t(i), .scaleM = {0.004f, 0.003f}, .colour = {std::sin(float(i)), 0.4f, std::cos(float(i))}});
            }
            return triangles(corners, splats);
        }(),
        rest, {lookAt({0, 0.01f, 1}, {0, 0.01f, 0}, 160, 100, 100)});
    add("folded", "a pose that folds a triangle flat (it is not drawn) beside one that it inverts",
        triangles({{0, 0, 0}, {0.1f, 0, 0}, {0.05f, 0.1f, 0}, {0.2f, 0, 0}, {0.3f, 0, 0}, {0.25f, 0.15f, 0}},
                  {{}, {.triangle = 1}, {.triangle = 1, .uv = {0.2f, 0.5f}, .flags = kSplatSingleFace}}, {0, 0, 1, 0, 0, 1},
                  Vec3f(0.05f, 0.05f, 0)),
        turned(kPi, Vec3f(1, 0, 0)), {lookAt({0.15f, 0.03f, 1}, {0.15f, 0.03f, 0}, 120, 80, 300)});
    add("equal-depths",
        "1,024 splats at one depth, hundreds on a pixel: equal depths are ordered by index; blending in half floats adds up rounding",
        sheets(1, 32, 0), rest, {lookAt({0.05f, 0.05f, 1}, {0.05f, 0.05f, 0}, 96, 96, 150)})
        .band = {45, 45, 8};
    add("opaque-layers", "thirty opaque sheets: transmittance runs out", sheets(30, 4, 0.01f), rest,
        {lookAt({0.05f, 0.05f, 1}, {0.05f, 0.05f, 0}, 96, 96, 150)});
    add("joint-at-180-degrees", "half-and-half weights between 0 and 180 degrees", randomAvatar(31, 8, 4), turned(kPi, Vec3f(0, 1, 0)),
        {lookAt({0.3f, 1, 1.8f}, {0, 1, 0}, 120, 120, 130)});
    add("view-dependent-colour", "SH of degree 3 that turns with the surface", randomAvatar(5, 8, 4, 3),
        randomPose(randomAvatar(5, 8, 4, 3), 7), {lookAt({0.9f, 1.6f, 1.3f}, {0, 1, 0}, 140, 120, 130)});
    add("pose-correctives", "offsets and light that follow the pose", test::withCorrectives(randomAvatar(11, 8, 4, 1), 11),
        randomPose(randomAvatar(11, 8, 4, 1), 3), {lookAt({-0.6f, 1.2f, 1.6f}, {0, 1, 0}, 140, 120, 130)});
    AvatarData lit = randomAvatar(13, 8, 4, 1);
    lit.light.irradiance = {-0.6f, 0.3f, -0.5f, 0.1f, -0.15f, -0.2f, 0.1f, 0.05f};
    add("scene-light", "light that stays in the world while the surface turns", std::move(lit), randomPose(randomAvatar(13, 8, 4, 1), 5),
        {lookAt({0.7f, 1.3f, -1.5f}, {0, 1, 0}, 140, 120, 130)});
    add("off-axis", "a principal point outside the middle and two focal lengths", randomAvatar(61, 8, 4),
        randomPose(randomAvatar(61, 8, 4), 2), [] {
            Cameraf camera = lookAt({0.5f, 1.2f, 1.6f}, {0, 1, 0}, 150, 130, 140);
            camera.cx = 20.3f, camera.cy = 100.7f, camera.fy = 170;
            return std::vector<Cameraf>{camera};
        }());
    add("ten-centimetres", "the camera 10 cm from the surface", randomAvatar(21, 10, 6), rest,
        {lookAt({0, 1, 0.6f}, {0, 1, 0}, 160, 140, 150)});
    add("far-away", "a whole avatar within twenty pixels", randomAvatar(71, 8, 8), rest, {lookAt({0, 1, 12}, {0, 1, 0}, 48, 48, 240)});
    const Cameraf centre = lookAt({0.2f, 1.1f, 1.7f}, {0, 1, 0}, 140, 120, 130);
    add("stereo-parallel", "two eyes of one frame, 63 mm apart", randomAvatar(81, 8, 6, 1), randomPose(randomAvatar(81, 8, 6, 1), 5),
        {eye(centre, -0.0315f, 0), eye(centre, 0.0315f, 0)});
    add("stereo-canted", "two eyes turned 5 degrees outwards: each needs its own depth order", randomAvatar(81, 8, 6, 1),
        randomPose(randomAvatar(81, 8, 6, 1), 5), {eye(centre, -0.0315f, 0.0873f), eye(centre, 0.0315f, -0.0873f)});
    AvatarData fine = randomAvatar(91, 12, 10, 1);
    fine.trainedPixelM = 0.004f;
    const Cameraf away = lookAt({0.2f, 1.1f, 4}, {0, 1, 0}, 90, 70, 130);
    add("coarser-than-trained", "pixels eight times coarser than in training, in a canted pair: four samples per pixel", std::move(fine),
        randomPose(randomAvatar(91, 12, 10, 1), 4), {eye(away, -0.0315f, 0.0873f), eye(away, 0.0315f, -0.0873f)});
    const Cameraf beside = lookAt({1.2f, 0.8f, 1.4f}, {0, 0.65f, 0}, 150, 190, 330);
    add("clothes-in-a-pose", "motion modes of a pose that knows no time: clothes as if it had been kept for ever", skirt(),
        test::stride(0.7f, -0.4f), {beside});
    ConformanceCase& remembered =
        add("clothes-that-remember", "the same pose after three others: what was held has leaked, and the clothes lag behind the legs",
            skirt(), test::stride(0.7f, -0.4f), {beside});
    remembered.earlier = {{test::stride(0, 0), 0}, {test::stride(-0.9f, 1.2f), 350'000'000}, {test::stride(0.2f, 0.1f), 600'000'000}};
    remembered.timeNs = 700'000'000;
    return cases;
}

}  // namespace dpl
