// SPDX-License-Identifier: Apache-2.0
// The face of the built-in subject: all shapes at full weight, on the mesh and on the control nodes of an avatar.
#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "reconstruction/subject/face/face_shapes.h"
#include "reconstruction/subject/sample/sample_avatar.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expressions.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

const std::vector<ExpressionShape>& face() {
    static const std::vector<ExpressionShape> kFace = subjectFace(subject());
    return kFace;
}

/** The subject's mesh as an avatar without splats. */
AvatarData bare() {
    AvatarData avatar;
    avatar.joints = subject().joints, avatar.mesh = subject().mesh;
    avatar.splats.triangleStart.assign(avatar.mesh.triangles.size() + 1, 0);
    return avatar;
}

/** From the middle between the eyes, before morphs. */
Vec3f fromEyes(size_t vertex) {
    const FaceLandmarks landmarks = builtinFace();
    return subject().canonical[vertex] - 0.5f * (landmarks.leftEye + landmarks.rightEye);
}

/** Where an expression may move the skin: metres from the middle between the eyes. */
struct Region {
    std::string_view prefix;
    Vec3f low, high;  // of the left side or of both
};
constexpr Region kRegions[] = {
    {"eye", {0.010f, -0.018f, -0.040f}, {0.054f, 0.020f, 0.040f}},      {"brow", {-0.010f, 0.004f, -0.080f}, {0.075f, 0.055f, 0.040f}},
    {"cheekP", {-0.075f, -0.100f, -0.080f}, {0.075f, -0.028f, 0.060f}}, {"cheekS", {0.000f, -0.050f, -0.080f}, {0.066f, 0.010f, 0.060f}},
    {"nose", {-0.010f, -0.076f, -0.080f}, {0.032f, -0.010f, 0.060f}},   {"mouth", {-0.060f, -0.120f, -0.080f}, {0.066f, -0.010f, 0.060f}},
    {"jaw", {-0.100f, -0.180f, -0.110f}, {0.100f, -0.030f, 0.060f}},
};

TEST(SampleFace, hasAllButTheTongue) {
    EXPECT_EQ(face().size(), kExpressionCount - 1);
    EXPECT_FALSE(hasFaceShape(*expressionOf("tongueOut")));
    EXPECT_FALSE(hasFaceShape(kExpressionCount));
}

TEST(SampleFace, eachMovesItsOwnRegionAndNothingElse) {
    for (const ExpressionShape& shape : face()) {
        const std::string_view name = kExpressionNames[shape.expression];
        const auto region =
            std::find_if(std::begin(kRegions), std::end(kRegions), [&](const Region& r) { return name.starts_with(r.prefix); });
        ASSERT_NE(region, std::end(kRegions)) << name;
        const bool rightSide = name.ends_with("Right") && name != "jawRight" && name != "mouthRight";
        const bool bothSides = !name.ends_with("Left") && !name.ends_with("Right");
        float most = 0, outside = 0;
        for (size_t v = 0; v < shape.offsetsM.size(); ++v) {
            Vec3f q = fromEyes(v);
            if (rightSide) q.x = -q.x;
            if (bothSides) q.x = std::abs(q.x);
            const bool inside = glm::all(glm::greaterThan(q, region->low)) && glm::all(glm::lessThan(q, region->high));
            float& worst = inside ? most : outside;
            worst = std::max(worst, glm::length(shape.offsetsM[v]));
        }
        EXPECT_GE(most, 0.001f) << name;
        EXPECT_LE(most, 0.030f) << name;
        EXPECT_LE(outside, 0.0003f) << name;
    }
}

TEST(SampleFace, leftAndRightMirrorEachOther) {
    const FaceLandmarks landmarks = builtinFace();
    const auto mirrored = [](const Vec3f& p) { return Vec3f(-p.x, p.y, p.z); };
    for (size_t e = 0; e < kExpressionCount; ++e) {
        if (!hasFaceShape(e)) continue;
        std::string other = kExpressionNames[e];
        if (other.ends_with("Left"))
            other.replace(other.size() - 4, 4, "Right");
        else if (other.ends_with("Right"))
            other.replace(other.size() - 5, 5, "Left");
        const auto twin = expressionOf(other);
        ASSERT_TRUE(twin) << other;
        float worst = 0;
        for (size_t v = 0; v < subject().canonical.size(); v += 3) {
            const Vec3f p = subject().canonical[v];
            worst = std::max(worst, glm::length(faceOffset(landmarks, *twin, mirrored(p)) - mirrored(faceOffset(landmarks, e, p))));
        }
        EXPECT_LT(worst, 1e-6f) << kExpressionNames[e] << ": metres, floats of a place 1.6 m up";
    }
}

TEST(SampleFace, lipsNeverCross) {
    const FaceLandmarks landmarks = builtinFace();
    for (size_t e = 0; e < kExpressionCount; ++e)
        for (int tenth = 1; tenth <= 10; ++tenth)
            for (float x = -0.022f; x <= 0.0221f; x += 0.002f) {
                float below = -1;
                for (float y = -0.012f; y <= 0.0121f; y += 0.001f) {  // up across the line between the lips
                    const Vec3f p = landmarks.mouth + Vec3f(x, y, 0);
                    const float to = p.y + (hasFaceShape(e) ? 0.1f * float(tenth) * faceOffset(landmarks, e, p).y : 0);
                    ASSERT_GT(to, below) << kExpressionNames[e] << " at " << 0.1 * tenth << ", x " << x << ", y " << y;
                    below = to;
                }
            }
}

TEST(SampleFace, aClosedEyeShowsNothingOfTheEye) {
    const FaceLandmarks landmarks = builtinFace();
    const size_t blink = *expressionOf("eyeBlinkLeft");
    for (float u = -0.9f; u <= 0.91f; u += 0.1f) {
        const float open = 1 - u * u, top = 0.0060f * open + 0.0008f * u, low = -0.0046f * open + 0.0008f * u;  // as it is painted
        const Vec3f at = landmarks.leftEye + Vec3f(0.015f * u, 0, 0);
        const Vec3f above = at + Vec3f(0, top, 0), below = at + Vec3f(0, low, 0);
        const float left = above.y + faceOffset(landmarks, blink, above).y - below.y - faceOffset(landmarks, blink, below).y;
        EXPECT_LT(left, 0.0005f) << "metres of eye that stay visible, at u " << u;
        EXPECT_GT(left, 0.0f) << u;
    }
}

TEST(SampleFace, fitsOnControlNodesOfFewBytes) {
    AvatarData avatar = bare();
    const auto report = addExpressions(avatar, face());
    ASSERT_TRUE(report) << report.error().message;
    const auto bytes = writeAvatar(avatar);
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto info = inspectAvatar(*bytes);
    ASSERT_TRUE(info) << info.error().message;
    std::printf("[ FACE ] %u nodes, %u entries, %.1f KB, %.2f mm from the shapes at most\n", report->nodes, report->entries,
                double(info->expressionBytes) / 1e3, 1e3 * double(report->shapesOffM));
    EXPECT_EQ(info->expressions, face().size());
    EXPECT_LE(info->expressionBytes, 150'000u);
    EXPECT_EQ(info->version, 1u);
}

TEST(SampleFace, doesNotDisturbPoseCorrectives) {
    AvatarData avatar = test::withCorrectives(bare(), 3, {.modes = 4, .nodes = 200});
    const AvatarData before = avatar;
    const auto report = addExpressions(avatar, face());
    ASSERT_TRUE(report) << report.error().message;
    std::printf("[ FACE ] correctives of the head are %.4f mm off\n", 1e3 * double(report->correctivesOffM));
    Jobs jobs(2);
    Pose pose = Pose::rest(avatar.joints.size());
    for (size_t j = 1; j < pose.localRotations.size(); ++j) pose.localRotations[j] = glm::angleAxis(0.2f, Vec3f(0, 0, 1));
    PosedMesh now, then;
    now.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, nullptr, &avatar.expressions}, pose, jobs);
    then.pose({before.joints, before.mesh, before.correctives, {}}, pose, jobs);
    std::vector<uint8_t> moved(avatar.mesh.restPositions.size(), 0);
    for (const ExpressionShape& shape : face())
        for (size_t v = 0; v < moved.size(); ++v) moved[v] |= uint8_t(glm::length(shape.offsetsM[v]) >= kLeastExpressionM);
    size_t kept = 0;
    for (size_t v = 0; v < moved.size(); ++v) {
        if (moved[v]) continue;
        ASSERT_EQ(avatar.correctives.nodeIndices[v], before.correctives.nodeIndices[v]) << v;
        ASSERT_EQ(now.rest()[v], then.rest()[v]) << "vertex " << v << " keeps its bytes";
        ++kept;
    }
    EXPECT_GT(kept, moved.size() / 2);
}

TEST(SampleFace, isRefusedTwiceAndOnAnotherMesh) {
    AvatarData avatar = bare();
    std::vector<ExpressionShape> shapes = {face()[0]};
    shapes[0].offsetsM.pop_back();
    EXPECT_FALSE(addExpressions(avatar, shapes));
    ASSERT_TRUE(addExpressions(avatar, face()));
    EXPECT_FALSE(addExpressions(avatar, face()));
}

}  // namespace
}  // namespace dpl
