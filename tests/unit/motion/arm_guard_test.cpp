// SPDX-License-Identifier: Apache-2.0
// Arms and hands of retargeted and tracked people stay outside the body. Prints millimetres. The truth is a mesh made of elliptic cylinders
// whose depth is known without the shape that is tested.
#include "sdk/motion/arm_guard.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sdk/motion/retarget.h"
#include "sdk/motion/tracker.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/motion/mocap.h"
#include "tests/unit/motion/track_streams.h"

namespace dpl {
namespace {

using test::jointOf;
using test::personRig;

/** An elliptic cylinder around a line at rest; its vertices belong to one joint. */
struct Cylinder {
    std::string bone;
    Vec3f from, to;
    float halfWidthM, halfDepthM;  // along x and z for lines that are nearly vertical
};

/** Wide hips: 46 cm, with thighs that fill them. */
std::vector<Cylinder> trunk(const std::vector<JointData>& rig) {
    const auto at = [&](const std::string& bone) { return rig[jointOf(rig, bone)].restPosition; };
    std::vector<Cylinder> parts = {{"hips", {0, 0.82f, 0}, {0, 1.04f, 0}, 0.23f, 0.15f},
                                   {"spine", {0, 1.04f, 0}, {0, 1.16f, 0}, 0.18f, 0.13f},
                                   {"chest", {0, 1.16f, 0}, {0, 1.26f, 0}, 0.17f, 0.12f},
                                   {"upperChest", {0, 1.26f, 0}, {0, 1.42f, 0}, 0.16f, 0.11f}};
    for (const char* side : {"left", "right"}) {
        const Vec3f hip = at(side + std::string("UpperLeg")), knee = at(side + std::string("LowerLeg"));
        parts.push_back({side + std::string("UpperLeg"), hip + 0.05f * (knee - hip), knee, 0.11f, 0.11f});
    }
    return parts;
}

void addRings(const std::vector<JointData>& rig, const Cylinder& part, MeshData& mesh) {
    const Vec3f along = part.to - part.from, x = glm::normalize(Vec3f(1, 0, 0) - along * (along.x / glm::dot(along, along))),
                z = glm::normalize(glm::cross(x, along));
    for (int ring = 0; ring <= 12; ++ring)
        for (int i = 0; i < 48; ++i) {
            const float angle = 6.2831853f * float(i) / 48;
            mesh.restPositions.push_back(part.from + along * (float(ring) / 12) + x * (part.halfWidthM * std::cos(angle)) +
                                         z * (part.halfDepthM * std::sin(angle)));
            mesh.jointIndices.push_back(glm::u16vec4(uint16_t(jointOf(rig, part.bone)), 0, 0, 0));
            mesh.jointWeights.push_back(glm::u8vec4(255, 0, 0, 0));
        }
}

constexpr float kUpperArmM = 0.045f, kLowerArmM = 0.035f;

MeshData personMesh(const std::vector<JointData>& rig) {
    MeshData mesh;
    for (const Cylinder& part : trunk(rig)) addRings(rig, part, mesh);
    for (const std::string side : {"left", "right"}) {
        const auto at = [&](const char* bone) { return rig[jointOf(rig, side + bone)].restPosition; };
        addRings(rig, {side + "UpperArm", at("UpperArm"), at("LowerArm"), kUpperArmM, kUpperArmM}, mesh);
        addRings(rig, {side + "LowerArm", at("LowerArm"), at("Hand"), kLowerArmM, kLowerArmM}, mesh);
        addRings(rig, {side + "Hand", at("Hand"), at("MiddleProximal"), 0.012f, 0.035f}, mesh);
    }
    return mesh;
}

/** By how much a ball lies in the cylinders of the posed body, mm. */
float depthMm(const std::vector<JointData>& rig, const std::vector<Mat3x4f>& g, const Vec3f& centre, float radiusM) {
    float deepest = 0;
    for (const Cylinder& part : trunk(rig)) {
        const Mat3x4f& m = g[jointOf(rig, part.bone)];
        const Vec3f p = glm::transpose(Mat3f(m)) * (centre - m[3]) - part.from, along = part.to - part.from;
        const float t = glm::dot(p, along) / glm::dot(along, along);
        if (t < 0 || t > 1) continue;
        const Vec3f off = p - along * t;
        const float ratio = std::hypot(off.x / (part.halfWidthM + radiusM), std::hypot(off.z, off.y) / (part.halfDepthM + radiusM));
        if (ratio < 1 && ratio > 1e-3f) deepest = std::max(deepest, glm::length(off) * (1 / ratio - 1));
    }
    return 1000 * deepest;
}

/** By how much points of hands and fingers lie in the body, mm: the deepest. A hand is 10 mm thick around its joints. */
constexpr float kThickM = 0.01f;
float depthMm(const std::vector<JointData>& rig, const Pose& pose) {
    std::vector<Mat3x4f> g;
    jointTransforms(rig, pose, g);
    float deepest = 0;
    for (const std::string side : {"left", "right"})
        for (const char* bone : {"Hand", "IndexProximal", "MiddleProximal", "LittleProximal", "MiddleIntermediate", "MiddleDistal"}) {
            const size_t joint = jointOf(rig, side + bone);
            deepest = std::max(deepest, depthMm(rig, g, g[joint] * Vec4f(rig[joint].restPosition, 1), kThickM));
        }
    return deepest;
}

/** By how much the firm part of the left elbow and of the middle of the left upper arm lies in the body, mm. */
std::array<float, 2> armDepthsMm(const std::vector<JointData>& rig, const Pose& pose) {
    std::vector<Mat3x4f> g;
    jointTransforms(rig, pose, g);
    const size_t upper = jointOf(rig, "leftUpperArm"), lower = jointOf(rig, "leftLowerArm");
    const Vec3f shoulder = rig[upper].restPosition, elbow = rig[lower].restPosition;
    return {depthMm(rig, g, g[lower] * Vec4f(elbow, 1), kFirmShare * kLowerArmM),
            depthMm(rig, g, g[upper] * Vec4f(0.5f * (shoulder + elbow), 1), kFirmShare * kUpperArmM)};
}

/** Rest pose with the left arm turned in at shoulder and elbow, radians. The defaults let it hang down, with the hand in the hip. */
Pose handInHip(const std::vector<JointData>& rig, float upperArm = 0.78f, float lowerArm = 0.25f) {
    Pose pose = Pose::rest(rig.size());
    pose.localRotations[jointOf(rig, "leftUpperArm")] = glm::angleAxis(-upperArm, Vec3f(0, 0, 1));
    pose.localRotations[jointOf(rig, "leftLowerArm")] = glm::angleAxis(-lowerArm, Vec3f(0, 0, 1));
    return pose;
}

TEST(BodyShape, measuresTheMesh) {
    const auto rig = personRig(0.8f);
    const BodyShape body = BodyShape::of(rig, personMesh(rig));
    ASSERT_FALSE(body.empty());
    EXPECT_NEAR(body.handM(0), 0.0115f, 0.002f);
    EXPECT_NEAR(body.lowerArmM(1), kLowerArmM, 0.002f);
    EXPECT_NEAR(body.upperArmM(0), kUpperArmM, 0.002f);
    std::vector<Mat3x4f> g;
    jointTransforms(rig, Pose::rest(rig.size()), g);
    for (const float angle : {0.0f, 0.4f, 1.2f, 3.0f, -2.0f}) {
        const Vec3f direction(std::cos(angle), 0, std::sin(angle));
        const float radius = 1 / std::hypot(direction.x / 0.23f, direction.z / 0.15f);
        const auto in = body.inside(Vec3f(0, 0.93f, 0) + direction * (radius - 0.02f), 0, g);
        ASSERT_TRUE(in) << angle;
        EXPECT_NEAR(in->depthM, 0.02f, 0.006f) << angle << ": cells of 15 degrees";
        EXPECT_GT(glm::dot(in->outward, direction), 0.95f);
        EXPECT_FALSE(body.inside(Vec3f(0, 0.93f, 0) + direction * (radius + 0.012f), 0.002f, g)) << angle;
    }
    EXPECT_TRUE(BodyShape::of(rig, MeshData()).empty());
    auto nameless = rig;
    for (JointData& joint : nameless) joint.humanoidBone.clear(), joint.name = "bone", joint.parent = std::min(joint.parent, 0);
    EXPECT_TRUE(BodyShape::of(nameless, personMesh(rig)).empty());
}

TEST(BodyShape, aHandInTheHipIsPushedOut) {
    const auto rig = personRig(0.8f);
    ArmGuard guard(BodyShape::of(rig, personMesh(rig)), rig);
    const Pose rest = Pose::rest(rig.size());
    for (const auto& push : guard.pushes(rest)) EXPECT_TRUE(push.none()) << "arms of the rest pose are free";
    for (const bool bent : {false, true}) {
        const Pose before = bent ? handInHip(rig, 0.4f, 0.8f) : handInHip(rig);
        Pose after = before;
        ASSERT_GT(depthMm(rig, before), 20);
        const auto pushes = guard.pushes(before);
        guard.push(pushes, after);
        std::printf("hand in the hip: %.1f mm deep, then %.1f\n", double(depthMm(rig, before)), double(depthMm(rig, after)));
        EXPECT_LT(depthMm(rig, after), 4);
        const size_t right = jointOf(rig, "rightUpperArm");
        EXPECT_EQ(before.localRotations[right], after.localRotations[right]) << "the other arm stays";
        if (!bent) continue;
        ASSERT_EQ(pushes[0].elbow, Vec3f(0)) << "the upper arm is free, so the arm does not swing";
        std::vector<Mat3x4f> a, b;
        jointTransforms(rig, before, a), jointTransforms(rig, after, b);
        for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(a[jointOf(rig, "leftHand")][c] - b[jointOf(rig, "leftHand")][c]), 1e-4f);
    }
}

TEST(BodyShape, anArmThatGrazesTheTrunkIsPushedOut) {
    const auto rig = personRig(0.8f);
    ArmGuard guard(BodyShape::of(rig, personMesh(rig)), rig);
    for (const float turn : {0.9f, 1.0f, 1.15f}) {  // the upper arm leans in, the forearm hangs beside the hip
        Pose pose = handInHip(rig, turn, -turn);
        ASSERT_EQ(depthMm(rig, pose), 0) << "the hand is free: it is the arm that must move";
        const auto before = armDepthsMm(rig, pose);
        ASSERT_GT(before[0], 20);
        ASSERT_GT(before[1], 20);
        const Quatf right = pose.localRotations[jointOf(rig, "rightUpperArm")];
        guard.push(guard.pushes(pose), pose);
        const auto after = armDepthsMm(rig, pose);
        std::printf("leaning in by %.2f rad: elbow %.1f mm deep, then %.1f; upper arm %.1f, then %.1f\n", double(turn), double(before[0]),
                    double(after[0]), double(before[1]), double(after[1]));
        EXPECT_LT(after[0], 4);
        EXPECT_LT(after[1], 4);
        EXPECT_EQ(depthMm(rig, pose), 0);
        EXPECT_EQ(pose.localRotations[jointOf(rig, "rightUpperArm")], right) << "the other arm stays";
    }
}

TEST(BodyShape, trackedHandsGiveWay) {
    const auto rig = personRig(0.8f);
    test::Stream stream(TrackFormat::Vrm, rig, 1);
    auto free = Tracker::create(rig, TrackFormat::Vrm, {}, stream.rest()),
         guarded = Tracker::create(rig, TrackFormat::Vrm, {}, stream.rest());
    ASSERT_TRUE(free && guarded);
    (*guarded)->guardArms(BodyShape::of(rig, personMesh(rig)));
    float onTheWay = 0, settled = 0, unguarded = 0;
    for (int k = 0; k < 60; ++k) {
        const int64_t timeNs = int64_t(k) * 1'000'000'000 / 60;
        const float share = std::clamp(float(k - 20) / 20, 0.0f, 1.0f);  // a third of a second for the way
        Pose pose = handInHip(rig);
        for (Quatf& q : pose.localRotations) q = glm::slerp(Quatf(1, 0, 0, 0), q, share);
        stream.show(pose);
        for (auto* tracker : {&free, &guarded}) {
            ASSERT_TRUE((**tracker)->add(stream.frame(timeNs)));
            Pose shown = Pose::rest(rig.size());
            (**tracker)->pose(timeNs, true, shown);
            const float depth = depthMm(rig, shown);
            if (tracker == &free)
                unguarded = std::max(unguarded, depth);
            else
                (k < 50 ? onTheWay : settled) = std::max(k < 50 ? onTheWay : settled, depth);
        }
    }
    std::printf("a tracked hand that moves into the hip: %.1f mm deep; kept out: %.1f on the way, then %.1f\n", double(unguarded),
                double(onTheWay), double(settled));
    EXPECT_GT(unguarded, 100);
    EXPECT_LT(onTheWay, 50) << "it gives way with a time constant of 0.05 s";
    EXPECT_LT(settled, 4);
}

TEST(BodyShape, recordedHandsStayOutOfWideHips) {
    const auto rig = personRig(0.8f);
    const BodyShape body = BodyShape::of(rig, personMesh(rig));
    for (const char* name : {"02_01", "02_05", "05_01", "07_01", "09_01"}) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        RetargetOptions options;
        const auto before = retarget(*motion, rig, options);
        options.body = &body;
        const auto after = retarget(*motion, rig, options);
        ASSERT_TRUE(before && after);
        float deepest = 0, left = 0;
        size_t touching = 0, inside = 0;
        for (const float t : before->timesS) {
            const float was = depthMm(rig, samplePose(*before, rig, double(t))), is = depthMm(rig, samplePose(*after, rig, double(t)));
            deepest = std::max(deepest, was), left = std::max(left, is);
            touching += was > 2, inside += is > 4;
        }
        float fastest = 0, fastestBefore = 0;
        for (size_t c = 0; c < after->channels.size(); ++c)
            for (size_t k = 1; k < after->timesS.size(); ++k) {
                const auto speed = [&](const ClipData& clip) {
                    const auto& r = clip.channels[c].rotations;
                    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(r[k], r[k - 1])))) / (clip.timesS[k] - clip.timesS[k - 1]);
                };
                fastest = std::max(fastest, speed(*after)), fastestBefore = std::max(fastestBefore, speed(*before));
            }
        std::printf(
            "%s: hands up to %.1f mm deep in %zu of %zu frames; then up to %.1f mm, above 4 mm in %zu; fastest joint %.1f, then %.1f "
            "rad/s\n",
            name, double(deepest), touching, before->timesS.size(), double(left), inside, double(fastestBefore), double(fastest));
        EXPECT_LT(left, std::max(12.0f, 0.25f * deepest));
        EXPECT_LT(fastest, 1.5f * fastestBefore) << "rad/s";
    }
}

}  // namespace
}  // namespace dpl
