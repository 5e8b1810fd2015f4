// SPDX-License-Identifier: Apache-2.0
// Hair that hangs turns with the head, as far as it reaches; hair that ends above the chin keeps the weights of the body.
#include "reconstruction/subject/garments/hanging_hair.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

constexpr float kHeadHeightM = 1.6f;

std::vector<JointData> spineNeckHead() {
    std::vector<JointData> joints(3);
    joints[0].humanoidBone = "spine", joints[1].humanoidBone = "neck", joints[2].humanoidBone = "head";
    joints[1].parent = 0, joints[2].parent = 1, joints[2].restPosition = {0, kHeadHeightM, 0};
    return joints;
}

/** A lock from above the ears down, a vertex every 5 cm, on the spine. */
struct Lock {
    SurfaceMesh piece;
    ClothWeights weights;

    explicit Lock(float lengthM) {
        for (float drop = -0.05f; drop <= lengthM; drop += 0.05f) {
            piece.positions.emplace_back(0.1f, kHeadHeightM + 0.04f - drop, -0.1f);
            weights.joints.push_back({0, 0, 0, 0}), weights.weights.push_back({255, 0, 0, 0});
        }
    }
    /** Of the head, 0 to 255. */
    int headShare(size_t vertex) const {
        int share = 0;
        for (int i = 0; i < 4; ++i)
            if (weights.joints[vertex][i] == 2) share += weights.weights[vertex][i];
        return share;
    }
};

TEST(HangingHair, turnsWithTheHeadAndFadesToTheBody) {
    Lock lock(0.7f);
    const std::vector<Mat3x4f> still(3, Mat3x4f(1));
    hangFromHead(lock.piece, spineNeckHead(), still, lock.weights);
    EXPECT_EQ(lock.headShare(0), 255) << "on the scalp";
    EXPECT_EQ(lock.headShare(5), 255) << "20 cm below the ears";
    EXPECT_GT(lock.headShare(8), 60);
    EXPECT_LT(lock.headShare(8), 200) << "35 cm below them";
    EXPECT_EQ(lock.headShare(13), 0) << "60 cm";
    for (size_t v = 0; v < lock.piece.positions.size(); ++v) {
        EXPECT_EQ(int(lock.weights.weights[v].x) + lock.weights.weights[v].y + lock.weights.weights[v].z + lock.weights.weights[v].w, 255);
        if (v > 0) EXPECT_LE(lock.headShare(v), lock.headShare(v - 1)) << v;
    }
}

TEST(HangingHair, shortHairKeepsItsWeights) {
    Lock lock(0.12f);
    const std::vector<Mat3x4f> still(3, Mat3x4f(1));
    hangFromHead(lock.piece, spineNeckHead(), still, lock.weights);
    for (size_t v = 0; v < lock.piece.positions.size(); ++v) EXPECT_EQ(lock.headShare(v), 0) << v;
}

TEST(HangingHair, isMeasuredFromTheHeadAsItIsPosed) {
    Lock upright(0.7f), bowed(0.7f);
    const std::vector<Mat3x4f> still(3, Mat3x4f(1));
    Mat3x4f turn(1);  // everything turned by a quarter about x, and away
    turn[0] = {1, 0, 0}, turn[1] = {0, 0, 1}, turn[2] = {0, -1, 0}, turn[3] = {0, 2, 1};
    for (Vec3f& p : bowed.piece.positions) p = Vec3f(p.x, -p.z + 2, p.y + 1);
    hangFromHead(upright.piece, spineNeckHead(), still, upright.weights);
    hangFromHead(bowed.piece, spineNeckHead(), std::vector<Mat3x4f>(3, turn), bowed.weights);
    for (size_t v = 0; v < upright.piece.positions.size(); ++v) EXPECT_NEAR(bowed.headShare(v), upright.headShare(v), 1) << v;
}

TEST(HangingHair, leavesARigWithoutAHeadAlone) {
    Lock lock(0.7f);
    std::vector<JointData> joints = spineNeckHead();
    joints[2].humanoidBone.clear();
    hangFromHead(lock.piece, joints, std::vector<Mat3x4f>(3, Mat3x4f(1)), lock.weights);
    EXPECT_EQ(lock.headShare(0), 0);
}

}  // namespace
}  // namespace dpl
