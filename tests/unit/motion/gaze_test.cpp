// SPDX-License-Identifier: Apache-2.0
// Looking at a point against its double-precision reference: on the target within limits, smooth everywhere, refused inside the head.
#include "sdk/motion/gaze.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/not_finite.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/motion/mix_reference.h"

namespace dpl {
namespace {

/** A person with eyes, which the rig of the other tests lacks. */
std::vector<JointData> rigWithEyes() {
    std::vector<JointData> joints = test::personRig(0.8f);
    const int32_t head = int32_t(test::jointOf(joints, "head"));
    joints.push_back({"left_eye", head, {0.03f, 1.615f, 0.095f}, "leftEye"});
    joints.push_back({"right_eye", head, {-0.03f, 1.615f, 0.095f}, "rightEye"});
    return joints;
}

const Vec3f kEyesAtRest(0, 1.615f, 0.095f);

class GazeTest : public ::testing::Test {
protected:
    void use(std::vector<JointData> joints) {
        joints_ = std::move(joints);
        auto who = GazeJoints::of(joints_);
        ASSERT_TRUE(who) << who.error().message;
        who_ = *who;
        pose_ = Pose::rest(joints_.size());
    }
    void SetUp() override { use(rigWithEyes()); }
    /** Head and eyes all the way. */
    static Gaze full(const Vec3f& target) {
        Gaze gaze;
        gaze.target = target, gaze.headWeight = gaze.eyeWeight = 1;
        return gaze;
    }
    Pose looking(const Gaze& gaze, const Pose& from) {
        Pose pose = from;
        const Status looked = lookAt(joints_, who_, gaze, pose, transforms_);
        EXPECT_TRUE(looked) << looked.error().message;
        return pose;
    }
    Pose looking(const Gaze& gaze) { return looking(gaze, pose_); }
    /** World direction in which a joint faces. */
    Vec3f faces(const Pose& pose, size_t joint) {
        jointTransforms(joints_, pose, transforms_);
        return Mat3f(transforms_[joint]) * Vec3f(0, 0, 1);
    }
    Vec3f placeOf(const Pose& pose, size_t joint) {
        jointTransforms(joints_, pose, transforms_);
        return transforms_[joint] * Vec4f(joints_[joint].restPosition, 1);
    }
    static double angle(const Vec3f& a, const Vec3f& b) {
        const Vec3d u = glm::normalize(Vec3d(a)), v = glm::normalize(Vec3d(b));
        return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
    }
    double largestStep(const Pose& a, const Pose& b) {
        double most = 0;
        for (size_t j = 0; j < joints_.size(); ++j)
            most = std::max(most, test::angleBetween(Quatd(a.localRotations[j]), Quatd(b.localRotations[j])));
        return most;
    }
    Pose randomPose(uint32_t seed, double mostRad) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        std::uniform_real_distribution<double> uniform(0, mostRad);
        Pose pose = Pose::rest(joints_.size());
        for (Quatf& q : pose.localRotations)
            q = Quatf(glm::angleAxis(uniform(random), glm::normalize(Vec3d(normal(random), normal(random), normal(random)))));
        pose.rootTranslation = Vec3f(float(normal(random)), 0.1f, float(normal(random)));
        return pose;
    }

    std::vector<JointData> joints_;
    GazeJoints who_;
    Pose pose_;
    std::vector<Mat3x4f> transforms_;
};

TEST_F(GazeTest, agreesWithTheReferenceInAnyPoseAtAnyTarget) {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0, 1);
    for (const bool eyes : {true, false})
        for (const bool neck : {true, false}) {
            std::vector<JointData> joints = eyes ? rigWithEyes() : test::personRig(0.8f);
            if (!neck) joints[test::jointOf(joints, "neck")].humanoidBone = "";
            use(joints);
            ASSERT_EQ(who_.neck.has_value(), neck);
            ASSERT_EQ(who_.eyes[0].has_value() && who_.eyes[1].has_value(), eyes);
            for (uint32_t round = 0; round < 60; ++round) {
                const Pose pose = randomPose(round, 0.6);
                Gaze gaze;
                const float far = round % 4 == 0 ? 0.15f : 2;
                gaze.target = placeOf(pose, who_.head) + far * Vec3f(normal(random), normal(random), normal(random));
                gaze.headWeight = round % 5 == 0 ? 1 : uniform(random), gaze.eyeWeight = round % 7 == 0 ? 0 : uniform(random);
                gaze.headLimitRad = {0.1f + 1.4f * uniform(random), 0.1f + 1.4f * uniform(random)};
                Pose got = pose;
                if (!lookAt(joints_, who_, gaze, got, transforms_)) continue;  // inside
                const test::ReferenceGaze want(joints_, who_, gaze, pose);
                for (size_t j = 0; j < joints_.size(); ++j)
                    EXPECT_LT(test::angleBetween(Quatd(got.localRotations[j]), want.local[j]), 2e-5) << round << ' ' << joints_[j].name;
            }
        }
}

TEST_F(GazeTest, looksStraightAtWhatLiesWithinItsLimits) {
    for (const Vec3f& direction :
         {Vec3f(0, 0, 1), Vec3f(0.5f, 0, 1), Vec3f(-0.4f, 0.2f, 1), Vec3f(0.1f, -0.3f, 1), Vec3f(0.6f, 0.1f, 0.9f)})
        for (const float far : {0.7f, 3.0f, 1000.0f}) {
            const Vec3f target = kEyesAtRest + far * glm::normalize(direction);
            const Pose pose = looking(full(target));
            for (const auto& eye : who_.eyes)
                EXPECT_LT(angle(faces(pose, *eye), target - placeOf(pose, *eye)), 1e-4) << far << ' ' << direction.x;
            EXPECT_LT(angle(faces(pose, who_.head), direction), 1e-5) << "the head alone, as seen from the eyes before the turn";
            EXPECT_NEAR(angle(faces(pose, *who_.neck), Vec3f(0, 0, 1)), 0.5 * angle(direction, Vec3f(0, 0, 1)), 1e-5);
        }
    const Vec3f hand = kEyesAtRest + Vec3f(0, -0.05f, 0.35f);
    const Pose near = looking(full(hand));
    EXPECT_GT(angle(faces(near, *who_.eyes[0]), faces(near, *who_.eyes[1])), 0.1) << "eyes converge on what is near";
}

TEST_F(GazeTest, weightsShareTheWayAndZeroChangesNoByte) {
    const Vec3f target = kEyesAtRest + 1000.0f * Vec3f(0.5f, 0, 1);  // so far that it does not matter where in the head an eye lies
    Gaze gaze = full(target);
    gaze.headWeight = 0.4f, gaze.eyeWeight = 0.5f;
    const double whole = std::atan2(0.5, 1);
    const Pose pose = looking(gaze);
    EXPECT_NEAR(angle(faces(pose, who_.head), Vec3f(0, 0, 1)), 0.4 * whole, 1e-5);
    EXPECT_NEAR(angle(faces(pose, *who_.eyes[0]), faces(pose, who_.head)), 0.5 * 0.6 * whole, 1e-3);
    gaze.headWeight = 0;
    const Pose eyesOnly = looking(gaze);
    EXPECT_EQ(eyesOnly.localRotations[who_.head], pose_.localRotations[who_.head]);
    EXPECT_EQ(eyesOnly.localRotations[*who_.neck], pose_.localRotations[*who_.neck]);
    gaze.eyeWeight = 0;
    const Pose start = randomPose(3, 1);
    EXPECT_EQ(looking(gaze, start).localRotations, start.localRotations);
}

TEST_F(GazeTest, nothingButNeckHeadAndEyesMovesAndMemoryStays) {
    Pose start = randomPose(4, 0.8);
    start.before.held[3] = 0.7;
    const Pose pose = looking(full({4, 1, 1}), start);
    for (size_t j = 0; j < joints_.size(); ++j)
        if (j != who_.head && j != *who_.neck && j != *who_.eyes[0] && j != *who_.eyes[1]) {
            EXPECT_EQ(pose.localRotations[j], start.localRotations[j]) << joints_[j].name;
        }
    EXPECT_EQ(pose.rootTranslation, start.rootTranslation);
    EXPECT_EQ(pose.before, start.before);
    EXPECT_EQ(looking(full({4, 1, 1}), start).localRotations, pose.localRotations) << "the same bytes again";
}

TEST_F(GazeTest, staysWithinItsLimitsWhereverTheTargetIs) {
    std::mt19937 random(12);
    std::normal_distribution<float> normal;
    double farthestHead = 0, farthestEye = 0;
    for (int round = 0; round < 3000; ++round) {
        const Vec3f direction = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
        const Pose pose = looking(full(kEyesAtRest + 2.0f * direction));
        const auto within = [&](const Vec3f& faced, const Vec2f& limit) {
            const Vec3d turn = test::shortestFromZ(Vec3d(faced));
            return std::hypot(turn.y / double(limit.x), turn.x / double(limit.y));
        };
        const double head = within(faces(pose, who_.head), kUsualHeadLimitRad);
        const double eye = within(pose.localRotations[*who_.eyes[0]] * Vec3f(0, 0, 1), kUsualEyeLimitRad);
        farthestHead = std::max(farthestHead, head), farthestEye = std::max(farthestEye, eye);
    }
    EXPECT_LE(farthestHead, 1 + 1e-5);
    EXPECT_LE(farthestEye, 1 + 1e-5);
    EXPECT_GT(farthestHead, 0.95) << "the limit was never met";
    EXPECT_GT(farthestEye, 0.95);
}

TEST_F(GazeTest, turnsSmoothlyWhenTheTargetGoesRoundBehindAndOverTheHead) {
    const double step = glm::radians(0.25);
    std::mt19937 random(13);
    std::normal_distribution<double> normal;
    for (int round = 0; round < 12; ++round) {  // circles through straight behind, in planes that stand at all angles
        const Vec3d side = glm::normalize(Vec3d(std::cos(round * 0.26), std::sin(round * 0.26), 0));
        const Pose start = round < 6 ? pose_ : randomPose(uint32_t(round), 0.3);
        const Vec3f middle = 0.5f * (placeOf(start, *who_.eyes[0]) + placeOf(start, *who_.eyes[1]));
        Pose before;
        double longest = 0;
        for (double a = 0; a < 2 * glm::pi<double>(); a += step) {
            const Vec3d direction = std::cos(a) * Vec3d(0, 0, 1) + std::sin(a) * side;
            const Pose now = looking(full(middle + 2.0f * Vec3f(direction)), start);
            if (a > 0) longest = std::max(longest, largestStep(before, now));
            before = now;
        }
        EXPECT_LT(longest, 5 * step) << round;
    }
    const Pose behind = looking(full(kEyesAtRest + Vec3f(0, 0, -2)));
    EXPECT_LT(largestStep(behind, pose_), 1e-4) << "straight behind is out of reach";
}

TEST_F(GazeTest, fadesOutOnTheWayIntoTheHead) {
    Pose before;
    double longest = 0, last = 0;
    for (double far = 1; far > 0; far -= 0.0005) {
        Pose now = pose_;
        if (!lookAt(joints_, who_, full(kEyesAtRest + float(far) * Vec3f(0.6f, 0, 0.8f)), now, transforms_)) break;
        if (far < 1) longest = std::max(longest, largestStep(before, now));
        last = largestStep(now, pose_);
        before = now;
    }
    EXPECT_LT(longest, 0.02);
    EXPECT_LT(last, 1e-3) << "where the target is refused nothing was left of the gaze";
}

TEST_F(GazeTest, theGazeTurnsWithTheAvatar) {
    const Gaze gaze = full({0.7f, 1.4f, 1.2f});
    const Pose straight = looking(gaze);
    Pose turned = pose_;
    const Quatf half = glm::angleAxis(2.6f, Vec3f(0, 1, 0));
    turned.localRotations[0] = half;
    turned.rootTranslation = {5, 0, -3};
    Gaze moved = gaze;
    const Vec3f pivot = joints_[0].restPosition;
    moved.target = half * (gaze.target - pivot) + pivot + turned.rootTranslation;
    const Pose pose = looking(moved, turned);
    for (size_t j = 1; j < joints_.size(); ++j)
        EXPECT_LT(test::angleBetween(Quatd(pose.localRotations[j]), Quatd(straight.localRotations[j])), 1e-5) << joints_[j].name;
}

TEST_F(GazeTest, refusesInASentenceAndKeepsThePose) {
    const Pose start = randomPose(5, 0.4);
    const auto refusal = [&](const Gaze& gaze) {
        Pose pose = start;
        const Status status = lookAt(joints_, who_, gaze, pose, transforms_);
        EXPECT_FALSE(status);
        EXPECT_EQ(pose.localRotations, start.localRotations);
        if (status) return std::string();
        EXPECT_EQ(status.error().code, Code::InvalidArgument);
        return status.error().message;
    };
    const auto says = [](const std::string& text, const char* what) { return text.find(what) != std::string::npos; };
    EXPECT_TRUE(says(refusal(full(placeOf(start, *who_.neck))), "inside the avatar itself")) << "its own neck";
    EXPECT_TRUE(says(refusal(full(placeOf(start, who_.head))), "inside the avatar itself"));
    EXPECT_TRUE(says(refusal(full(placeOf(start, *who_.eyes[0]))), "inside the avatar itself"));
    EXPECT_TRUE(says(refusal(full({kNan, 0, 0})), "target is not finite"));
    EXPECT_TRUE(says(refusal(full({0, kInfinity, 0})), "target is not finite"));
    for (const float wrong : {kNan, -0.1f, 1.1f, kInfinity}) {
        Gaze gaze = full({0, 1, 3});
        gaze.headWeight = wrong;
        EXPECT_TRUE(says(refusal(gaze), "headWeight")) << wrong;
        gaze = full({0, 1, 3});
        gaze.eyeWeight = wrong;
        EXPECT_TRUE(says(refusal(gaze), "eyeWeight")) << wrong;
    }
    for (const float wrong : {kNan, 0.0f, -1.0f, 1.6f, kInfinity})
        for (int which = 0; which < 4; ++which) {
            Gaze gaze = full({0, 1, 3});
            (which < 2 ? gaze.headLimitRad : gaze.eyeLimitRad)[which % 2] = wrong;
            EXPECT_TRUE(says(refusal(gaze), "a limit is")) << wrong;
        }
    const std::vector<JointData> headless = {{"box", -1, {0, 0, 0}, ""}, {"lid", 0, {0, 1, 0}, ""}};
    const auto none = GazeJoints::of(headless);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Code::Unsupported);
    EXPECT_TRUE(says(none.error().message, "box, lid")) << none.error().message;
}

}  // namespace
}  // namespace dpl
