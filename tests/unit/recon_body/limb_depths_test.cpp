// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/limb_depths.h"

#include <gtest/gtest.h>

#include "reconstruction/input/capture/scan.h"
#include "small_body.h"

namespace dpl {
namespace {

constexpr size_t kRightLeg = 3, kMiddle = 2;
constexpr double kSettledPx =
    20;  // the ankle of the other depth lies 6.6 px from its keypoint, because candidates bend about the hinge alone

/** Five pictures of a lifted leg from the front; the middle one is free. There the shin has its other depth, where its keypoints
 *  fit as well. */
struct LiftedLeg {
    BodyModel body = smallBody();
    std::vector<std::string> names{scanKeypointNames().begin(), scanKeypointNames().end()};
    std::vector<JointPrior> priors = posePriors(body);
    KeypointChain chain{body, names, jointsOf(priors)};
    std::vector<double> shape = std::vector<double>(chain.shapeCount(), 0.0), usual;
    LimbModel model{body, chain, priors, names, shape.data(), usual};
    KnownLimb limb = *knownLimb(model, kRightLeg);
    Mat3d reference{1};
    double root[kRootSize] = {};
    std::vector<double> poses[5];
    std::vector<Keypoint> keypoints;
    std::vector<LimbFrame> inTime;
    double otherDepth = 0;  // of the ankle from its true place, metres

    Vec3d ankle(const std::vector<double>& pose) const {
        KeypointChain::Output out;
        chain.evaluate(reference, root, pose.data(), shape.data(), false, out);
        return out.places[limb.end];
    }
    LiftedLeg() {
        Camerad camera;
        camera.widthPx = 378, camera.heightPx = 504, camera.fx = camera.fy = 380, camera.cx = 189, camera.cy = 252;
        camera.viewFromWorldRotation = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
        camera.viewFromWorldTranslation = {0, 0.9, 2.5};
        std::vector<double> lifted(3 * chain.posedCount(), 0.0);
        lifted[3 * limb.upperSlot] = -1.1, lifted[3 * limb.lowerSlot] = 1.3;
        KeypointChain::Output out;
        chain.evaluate(reference, root, lifted.data(), shape.data(), false, out);
        for (const Vec3d& p : out.points) keypoints.push_back({camera.pixelOf(camera.toView(p)), 1});
        for (size_t i = 0; i < 5; ++i) {
            poses[i] = lifted;
            inTime.push_back({0.2 * double(i), camera, keypoints, &reference, root, &poses[i], i == kMiddle});
        }
        for (const LimbCandidate& c : limbCandidates(model, limb, inTime[kMiddle])) {
            std::vector<double> pose = lifted;
            setLimb(limb, c, pose);
            const Vec3d off = ankle(pose) - ankle(lifted);
            if (glm::length(c.elbow - out.places[limb.lower]) < 0.01 && glm::length(off) > otherDepth)
                poses[kMiddle] = pose, otherDepth = glm::length(off);
        }
    }
    double ankleOff() const { return glm::length(ankle(poses[kMiddle]) - ankle(poses[0])); }
};

TEST(LimbDepths, aLimbTakesTheDepthOfItsNeighbours) {
    LiftedLeg leg;
    ASSERT_GT(leg.otherDepth, 0.2);
    untangleLimbs(leg.model, leg.inTime);
    EXPECT_LT(leg.ankleOff(), 0.03);  // 17 mm, by the hinge too
}

/** Settles limbs by kSettledPx and shows the ankle of the middle frame 24 px lower, with this confidence. */
double ankleOffBeside(double confidence) {
    LiftedLeg leg;
    std::vector<Keypoint> moved = leg.keypoints;
    moved[leg.limb.endKeypoint].px.y += 24;
    moved[leg.limb.endKeypoint].confidence = confidence;
    leg.inTime[kMiddle].settledPx = kSettledPx;
    leg.inTime[kMiddle].keypoints = moved;
    untangleLimbs(leg.model, leg.inTime);
    return leg.ankleOff();
}

TEST(LimbDepths, aSettledLimbStaysWhereItIs) {
    EXPECT_EQ(ankleOffBeside(0.5), LiftedLeg().otherDepth);  // at half confidence 24 px count as 12
}

TEST(LimbDepths, aLimbBesideItsKeypointsChoosesAnew) {
    EXPECT_LT(ankleOffBeside(1), 0.3);  // of 0.42 m; the moved keypoint alone puts it 0.24 m away
}

TEST(LimbDepths, aLimbStaysBesideAKeypointWhereNoLegCanBe) {
    LiftedLeg leg;
    std::vector<Keypoint> moved = leg.keypoints;
    moved[leg.limb.middleKeypoint].px.x += 80;
    leg.inTime[kMiddle].settledPx = kSettledPx;
    leg.inTime[kMiddle].keypoints = moved;
    untangleLimbs(leg.model, leg.inTime);
    EXPECT_EQ(leg.ankleOff(), leg.otherDepth);
}

}  // namespace
}  // namespace dpl
