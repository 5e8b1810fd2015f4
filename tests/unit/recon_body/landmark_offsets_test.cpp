// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/landmark_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "small_body.h"

namespace dpl {
namespace {

TEST(LandmarkOffsets, findsWhereTheDetectorSeesAKeypoint) {
    BodyModel body = smallBody();
    body.morphs.clear();
    const std::vector<std::string> names{scanKeypointNames().begin(), scanKeypointNames().end()};
    KeypointChain chain(body, names, {1, 4, 7});
    const size_t pelvis = size_t(std::find(names.begin(), names.end(), "pelvis") - names.begin()),
                 wrist = size_t(std::find(names.begin(), names.end(), "wrist_l") - names.begin());
    const Vec3d pelvisTruth(0.004, -0.025, 0.01), wristTruth(0.01, 0, -0.012);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::vector<std::vector<Keypoint>> keypoints(24);
    std::vector<LandmarkView> views;
    for (size_t i = 0; i < keypoints.size(); ++i) {
        LandmarkView view;
        view.camera.widthPx = 378, view.camera.heightPx = 504, view.camera.fx = view.camera.fy = 380;
        view.camera.cx = 189, view.camera.cy = 252;
        const double a = 0.26 * double(i);
        const Vec3d eye(2.3 * std::sin(a), 1.2, 2.3 * std::cos(a)), z = glm::normalize(Vec3d(0, 0.9, 0) - eye),
                                                                    x = glm::normalize(glm::cross(Vec3d(0, -1, 0), z));
        view.camera.viewFromWorldRotation = glm::transpose(Mat3d(x, glm::cross(z, x), z));
        view.camera.viewFromWorldTranslation = -(view.camera.viewFromWorldRotation * eye);
        const std::vector<double> root{0.1, 0.2, -0.1, 0.02, 0, 0.01}, pose{0.1, 0, 0.1, 0, 0.1, 0, 0.2, 0, 0.3};
        chain.evaluate(Mat3d(1.0), root.data(), pose.data(), nullptr, false, view.posed);
        for (size_t k = 0; k < names.size(); ++k) {
            const Vec3d offset = k == pelvis ? pelvisTruth : k == wrist ? wristTruth : Vec3d(0);
            Keypoint seen{view.camera.pixelOf(view.camera.toView(
                              view.posed.points[k] + (chain.hasKeypoint(k) ? view.posed.rotations[chain.carrier(k)] * offset : offset))) +
                              Vec2d(normal(random), normal(random)),
                          1.0};
            if (i % 8 == 3) seen.px += Vec2d(70, 50);  // wrong detections
            keypoints[i].push_back(seen);
        }
        views.push_back(std::move(view));
    }
    for (size_t i = 0; i < views.size(); ++i) views[i].keypoints = keypoints[i];
    const auto offsets = estimateLandmarkOffsets(chain, views, 4);
    EXPECT_LT(glm::length(offsets[pelvis] - pelvisTruth), 0.005);  // 1 px is 6 mm, over 21 views and three axes: σ about 2 mm
    EXPECT_LT(glm::length(offsets[wrist] - wristTruth), 0.005);
    chain.setOffset(wrist, offsets[wrist]);
    KeypointChain::Output moved;
    const std::vector<double> zero(9, 0.0);
    chain.evaluate(Mat3d(1.0), zero.data(), zero.data(), nullptr, true, moved);
    KeypointChain plain(body, names, {1, 4, 7});
    KeypointChain::Output before;
    plain.evaluate(Mat3d(1.0), zero.data(), zero.data(), nullptr, true, before);
    EXPECT_LT(glm::length(moved.points[wrist] - before.points[wrist] - offsets[wrist]), 1e-12);
    EXPECT_NE(moved.jacobian, before.jacobian) << "the lever of the keypoint is longer";

    const auto few = estimateLandmarkOffsets(chain, std::span(views).first(2), 4);
    EXPECT_EQ(few[wrist], Vec3d(0)) << "two views are too few";
}

TEST(LandmarkOffsets, ofOurNetworksAreMirrored) {
    const Vec3d left = foundLandmarkOffset("ear_l"), right = foundLandmarkOffset("ear_r");
    EXPECT_GT(glm::length(left), 0.01);
    EXPECT_LT(left.x, 0) << "towards the middle of the body";
    EXPECT_EQ(right, Vec3d(-left.x, left.y, left.z));
    EXPECT_GT(foundLandmarkOffset("pelvis").z, 0);
    for (const char* unknown : {"", "_l", "tail"}) EXPECT_EQ(foundLandmarkOffset(unknown), Vec3d(0)) << unknown;
}

}  // namespace
}  // namespace dpl
