// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/keypoint_chain.h"

#include <gtest/gtest.h>

#include <random>

#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/subject/body/pose_prior.h"
#include "sdk/avatar/rig.h"
#include "small_body.h"

namespace dpl {
namespace {

std::vector<uint32_t> posedJoints(const BodyModel& body) {
    std::vector<uint32_t> joints;
    for (const JointPrior& p : posePriors(body)) joints.push_back(p.joint);
    return joints;
}

std::vector<std::string> names() {
    return {scanKeypointNames().begin(), scanKeypointNames().end()};
}

struct Case {
    Mat3d reference{1};
    std::vector<double> root, pose, shape;
};

Case randomCase(const KeypointChain& chain, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Case c;
    c.reference = rotationOf({0.3 * normal(random), 2.0, 0.2});
    for (int i = 0; i < kRootSize; ++i) c.root.push_back(0.4 * normal(random));
    for (size_t i = 0; i < 3 * chain.posedCount(); ++i) c.pose.push_back(0.5 * normal(random));
    for (size_t i = 0; i < chain.shapeCount(); ++i) c.shape.push_back(normal(random));
    return c;
}

TEST(KeypointChain, jointsThatAreNotPosedKeepWhatTheyAreHeldAt) {
    const BodyModel body = smallBody();
    const uint32_t elbow = uint32_t(findHumanoid(body, "leftLowerArm"));
    std::vector<uint32_t> others = posedJoints(body);
    std::erase(others, elbow);
    const KeypointChain all(body, names(), posedJoints(body)), chain(body, names(), others);
    const Case c = randomCase(all, 3);
    std::vector<Mat3d> held(body.joints.size(), Mat3d(1));
    std::vector<double> pose;
    for (size_t s = 0; s < all.posedCount(); ++s) {
        const double* w = &c.pose[3 * s];
        if (all.posedJoints()[s] == elbow)
            held[elbow] = rotationOf({w[0], w[1], w[2]});
        else
            pose.insert(pose.end(), w, w + 3);
    }
    KeypointChain::Output should, is, atRest;
    all.evaluate(c.reference, c.root.data(), c.pose.data(), c.shape.data(), true, should);
    chain.evaluate(c.reference, c.root.data(), pose.data(), c.shape.data(), true, is, held);
    chain.evaluate(c.reference, c.root.data(), pose.data(), c.shape.data(), true, atRest);
    double moved = 0;
    for (size_t k = 0; k < should.points.size(); ++k) {
        EXPECT_LT(glm::length(should.points[k] - is.points[k]), 1e-12);
        moved = std::max(moved, glm::length(atRest.points[k] - is.points[k]));
        for (size_t r = 0; r < 3; ++r)  // the root's columns come first in both
            for (size_t i = 0; i < kRootSize; ++i)
                EXPECT_NEAR(should.jacobian[(3 * k + r) * all.columns() + i], is.jacobian[(3 * k + r) * chain.columns() + i], 1e-12);
    }
    EXPECT_GT(moved, 0.01);
}

TEST(KeypointChain, agreesWithSkinningTheShapedBody) {
    const BodyModel body = smallBody();
    const KeypointChain chain(body, names(), posedJoints(body));
    const Case c = randomCase(chain, 7);
    KeypointChain::Output out;
    chain.evaluate(c.reference, c.root.data(), c.pose.data(), c.shape.data(), false, out);

    const BodyModel shaped = shapedBody(body, c.shape);
    Pose pose = Pose::rest(body.joints.size());
    pose.localRotations[0] = Quatf(glm::quat_cast(rotationOf({c.root[0], c.root[1], c.root[2]}) * c.reference));
    pose.rootTranslation = Vec3f(c.root[3], c.root[4], c.root[5]);
    for (size_t s = 0; s < chain.posedCount(); ++s)
        pose.localRotations[chain.posedJoints()[s]] =
            Quatf(glm::quat_cast(rotationOf({c.pose[3 * s], c.pose[3 * s + 1], c.pose[3 * s + 2]})));
    const auto skinned = posedKeypoints(shaped, pose, names());
    for (size_t k = 0; k < skinned.size(); ++k) {
        ASSERT_EQ(skinned[k].present, chain.hasKeypoint(k));
        if (skinned[k].present) {
            EXPECT_LT(glm::length(skinned[k].place - out.points[k]), 2e-5)
                << names()[k];  // the rig skins in float: error about 1e-6 of 2 m
        }
    }
}

TEST(KeypointChain, jacobianIsTheDerivative) {
    const BodyModel body = smallBody();
    const KeypointChain chain(body, names(), posedJoints(body));
    Case c = randomCase(chain, 11);
    c.pose[4] = 1e-6, c.pose[3] = c.pose[5] = 0;  // covers the small-angle branch
    KeypointChain::Output out, plus, minus;
    chain.evaluate(c.reference, c.root.data(), c.pose.data(), c.shape.data(), true, out);
    const double h = 1e-6;
    double largest = 0;
    for (size_t column = 0; column < chain.columns(); ++column) {
        const size_t poseEnd = kRootSize + c.pose.size();
        double& x = column < kRootSize ? c.root[column] : column < poseEnd ? c.pose[column - kRootSize] : c.shape[column - poseEnd];
        const double kept = x;
        x = kept + h;
        chain.evaluate(c.reference, c.root.data(), c.pose.data(), c.shape.data(), false, plus);
        x = kept - h;
        chain.evaluate(c.reference, c.root.data(), c.pose.data(), c.shape.data(), false, minus);
        x = kept;
        for (size_t k = 0; k < chain.keypointCount(); ++k)
            for (int r = 0; r < 3; ++r) {
                const double analytic = out.jacobian[(k * 3 + size_t(r)) * chain.columns() + column];
                EXPECT_NEAR(analytic, (plus.points[k][r] - minus.points[k][r]) / (2 * h), 1e-7)
                    << "keypoint " << k << " column " << column;  // error: second order in h, and rounding of 1e-16/h
                largest = std::max(largest, std::abs(analytic));
            }
    }
    EXPECT_GT(largest, 0.5);  // the derivatives are not all zero
}

TEST(KeypointChain, rotationVectorUndoesRotationOf) {
    for (const Vec3d& w : {Vec3d(0), Vec3d(1e-7, 0, 0), Vec3d(0.3, -0.4, 0.5), Vec3d(0, 3.1, 0), Vec3d(2, 2, -1)})
        EXPECT_LT(glm::length(rotationVector(rotationOf(w)) - w), 1e-9);
}

TEST(PosePriors, elbowsBendForwardAndKneesBackward) {
    const BodyModel body = smallBody();
    const auto priors = posePriors(body);
    const auto axis = [&](const char* bone) {
        for (const JointPrior& p : priors)
            if (int32_t(p.joint) == findHumanoid(body, bone)) return p.axes[0];
        ADD_FAILURE() << bone;
        return Vec3d(0);
    };
    // A positive rotation about the hinge takes the forearm's end forward (+Z) and the foot backward.
    const auto lowerEnd = [&](const char* from, const char* to, double angle) {
        const Vec3d bone(body.joints[size_t(findHumanoid(body, to))].restPosition -
                         body.joints[size_t(findHumanoid(body, from))].restPosition);
        return (rotationOf(axis(from) * angle) * bone - bone).z;
    };
    EXPECT_GT(lowerEnd("leftLowerArm", "leftHand", 0.5), 0.02);
    EXPECT_GT(lowerEnd("rightLowerArm", "rightHand", 0.5), 0.02);
    EXPECT_LT(lowerEnd("leftLowerLeg", "leftFoot", 0.5), -0.02);
    EXPECT_LT(lowerEnd("rightLowerLeg", "rightFoot", 0.5), -0.02);
}

}  // namespace
}  // namespace dpl
