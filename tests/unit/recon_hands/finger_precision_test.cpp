// SPDX-License-Identifier: Apache-2.0
// The precision of fitted fingers, against finite differences of the posed body.
#include "reconstruction/subject/hands/finger_precision.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/subject/body/priors.h"
#include "tests/unit/recon_hands/known_body.h"

namespace dpl {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

HandTurns someTurns(const HandRig& hand) {
    HandTurns turns{};
    for (size_t t = 0; t < turns.size(); ++t) turns[t] = std::clamp(0.15 + 0.03 * double(t % 7), 0.7 * hand.low[t], 0.7 * hand.high[t]);
    return turns;
}

/** Where the points of the left hand are, metres, world. */
std::vector<Vec3d> placesOf(const HandRig& hand, const HandTurns& turns) {
    Pose pose = Pose::rest(knownBody().joints.size());
    setFingers(hand, turns, pose);
    std::vector<Vec3d> places;
    for (const PosedKeypoint& p : posedKeypoints(knownBody(), pose, handNames())) places.push_back(p.place);
    places.resize(kHandPoints);
    return places;
}

TEST(FingerPrecision, ofTurnsIsThatOfFiniteDifferences) {
    const HandRig hand = *handRig(knownBody(), true);
    const HandTurns turns = someTurns(hand);
    const Vec3d wrist(knownBody().joints[hand.wrist].restPosition);
    HandView view;
    Camerad& c = view.camera;
    c.widthPx = 378, c.heightPx = 504, c.fx = c.fy = 900, c.cx = 189, c.cy = 252;
    const Vec3d z = glm::normalize(Vec3d(0.3, -0.2, -1)), x = glm::normalize(glm::cross(Vec3d(0, -1, 0), z)), y = glm::cross(z, x);
    c.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * (wrist - 1.2 * z));
    view.wrist = wrist, view.sigmaPx = 1.3;
    const std::vector<Vec3d> places = placesOf(hand, turns);
    for (size_t k = 0; k < kHandPoints; ++k) view.points[k] = {c.pixelOf(c.toView(places[k])), k % 3 == 0 ? 0.4f : 0.9f};
    view.points[6].confidence = 0;  // not seen

    constexpr double kStep = 4e-3;  // poses are kept in floats, which leaves 3e-4 of the largest entry
    Matrix perTurn = Matrix::Zero(2 * kHandPoints, kHandTurns), perWrist = Matrix::Zero(2 * kHandPoints, kWristSize);
    const auto column = [&](Matrix& into, Eigen::Index at, const std::vector<Vec3d>& less, const std::vector<Vec3d>& more) {
        for (size_t k = 0; k < kHandPoints; ++k) {
            const Vec2d d = (c.pixelOf(c.toView(more[k])) - c.pixelOf(c.toView(less[k]))) / (2 * kStep);
            for (int a = 0; a < 2; ++a) into(Eigen::Index(2 * k) + a, at) = double(view.points[k].confidence) / view.sigmaPx * d[a];
        }
    };
    for (size_t t = 0; t < kHandTurns; ++t) {
        HandTurns less = turns, more = turns;
        less[t] -= kStep, more[t] += kStep;
        column(perTurn, Eigen::Index(t), placesOf(hand, less), placesOf(hand, more));
    }
    for (int i = 0; i < kWristSize; ++i) {
        std::vector<Vec3d> less = places, more = places;
        for (auto [side, sign] : {std::pair{&less, -kStep}, std::pair{&more, kStep}})
            for (Vec3d& p : *side) {
                Vec3d axis(0);
                axis[i % 3] = 1;
                p = i < 3 ? wrist + glm::angleAxis(sign, axis) * (p - wrist) : p + sign * axis;
            }
        column(perWrist, i, less, more);
    }
    Matrix ofWrist = perWrist.transpose() * perWrist;
    for (int i = 0; i < kWristSize; ++i) ofWrist(i, i) += 1 / std::pow(i < 3 ? priors::kWristTurnRad : priors::kWristShiftM, 2);
    const Matrix both = perWrist.transpose() * perTurn;
    Matrix expected = perTurn.transpose() * perTurn - both.transpose() * ofWrist.inverse() * both;
    HandTurns prior;
    for (size_t t = 0; t < kHandTurns; ++t) {
        prior[t] = 0.2 + 0.01 * double(t);
        const double room = std::min(turns[t] - hand.low[t], hand.high[t] - turns[t]);
        ASSERT_GT(room, 0.03);
        expected(Eigen::Index(t), Eigen::Index(t)) += 1 / (prior[t] * prior[t]) + 1 / (room * room);
    }

    const auto found = turnPrecision(hand, view, turns, {}, prior);
    const double largest = expected.cwiseAbs().maxCoeff();
    EXPECT_GT(largest, 1000);  // a hand of 130 px tells its turns to some hundredths
    for (size_t i = 0; i < kHandTurns; ++i)
        for (size_t j = 0; j < kHandTurns; ++j)
            ASSERT_NEAR(found[i * kHandTurns + j], expected(Eigen::Index(i), Eigen::Index(j)), 1e-3 * largest) << i << ", " << j;
}

TEST(FingerPrecision, ofJointsCostsWhatTheTurnsCost) {
    const HandRig hand = *handRig(knownBody(), false);
    const HandTurns turns = someTurns(hand);
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    Matrix roots(kHandTurns, kHandTurns);
    for (Eigen::Index i = 0; i < roots.size(); ++i) roots.data()[i] = normal(random);
    const Matrix ofTurns = roots.transpose() * roots;
    std::array<double, kHandTurns * kHandTurns> precision{};
    Eigen::Map<Matrix>(precision.data(), kHandTurns, kHandTurns) = ofTurns;
    const PosePrecision joints = jointPrecision(hand, turns, precision);
    ASSERT_EQ(joints.joints.size(), 1 + 3 * kHandFingers);
    ASSERT_EQ(joints.joints.front(), 0u);
    const Eigen::Map<const Matrix> matrix(joints.matrix.data(), Eigen::Index(joints.size()), Eigen::Index(joints.size()));
    EXPECT_LT((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), 1e-9 * matrix.cwiseAbs().maxCoeff());

    Pose fitted = Pose::rest(knownBody().joints.size());
    setFingers(hand, turns, fitted);
    for (int trial = 0; trial < 20; ++trial) {
        Eigen::VectorXd change(kHandTurns);
        HandTurns moved = turns;
        for (size_t t = 0; t < kHandTurns; ++t) change[Eigen::Index(t)] = 1e-3 * normal(random), moved[t] += change[Eigen::Index(t)];
        Pose pose = fitted;
        setFingers(hand, moved, pose);
        Eigen::VectorXd d = Eigen::VectorXd::Zero(Eigen::Index(joints.size()));
        for (size_t k = 0; k < joints.joints.size(); ++k) {
            const uint32_t j = joints.joints[k];
            const Quatd turn = Quatd(pose.localRotations[j]) * glm::conjugate(Quatd(fitted.localRotations[j]));
            for (int a = 0; a < 3; ++a) d[Eigen::Index(3 * k) + a] = 2 * (a == 0 ? turn.x : a == 1 ? turn.y : turn.z);
        }
        const double expected = change.dot(ofTurns * change), cost = d.dot(matrix * d);
        EXPECT_NEAR(cost, expected, 0.01 * expected);
    }

    // A turn about an axis that a middle joint lacks costs much more than one about its hinge.
    const FingerRig& index = hand.fingers[1];
    const auto costOf = [&](const Vec3d& turn) {
        Eigen::VectorXd d = Eigen::VectorXd::Zero(Eigen::Index(joints.size()));
        const auto at = std::find(joints.joints.begin(), joints.joints.end(), index.joints[1]) - joints.joints.begin();
        for (int a = 0; a < 3; ++a) d[3 * at + a] = turn[a];
        return d.dot(matrix * d);
    };
    const Vec3d across = glm::normalize(glm::cross(index.bendAxes[1], Vec3d(0.3, 0.5, 0.7)));
    EXPECT_NEAR(costOf(0.1 * across), 100, 1);  // 0.1 rad in standard deviations of 0.01, squared
    EXPECT_LT(costOf(0.1 * index.bendAxes[1]), 5);
}

}  // namespace
}  // namespace dpl
