// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/carried_points.h"

#include <gtest/gtest.h>

#include "tests/reference/random_avatar.h"

namespace dpl::test {
namespace {

/** Nearest of many samples of every allowed triangle: slow, and from the definition alone. */
double sampledDistance(const Vec3f& p, const MeshData& mesh, std::span<const uint8_t> allowed) {
    double best = 1e9;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!allowed[t]) continue;
        const Vec3d a(mesh.restPositions[mesh.triangles[t].x]), b(mesh.restPositions[mesh.triangles[t].y]),
            c(mesh.restPositions[mesh.triangles[t].z]);
        for (int i = 0; i <= 40; ++i)
            for (int j = 0; i + j <= 40; ++j)
                best = std::min(best, glm::length(Vec3d(p) - (a + (i / 40.0) * (b - a) + (j / 40.0) * (c - a))));
    }
    return best;
}

class CarriedPointsTest : public testing::Test {
protected:
    CarriedPointsTest() {
        std::mt19937 random(5);
        std::normal_distribution<float> normal;
        for (int i = 0; i < 60; ++i) {
            points_.push_back(Vec3f(0, 1, 0) + 0.3f * Vec3f(normal(random), normal(random), normal(random)));
            normals_.push_back(glm::normalize(points_.back() - Vec3f(0, 1, 0)));
        }
    }
    AvatarData ball_ = randomAvatar(2, 10);
    std::vector<uint8_t> allowed_ = std::vector<uint8_t>(ball_.mesh.triangles.size(), 1);
    std::vector<Vec3f> points_, normals_;
    Jobs jobs_{2};
};

TEST_F(CarriedPointsTest, bindsToTheNearestTriangleThatIsAllowed) {
    // The ball's triangles face inwards, so no triangle faces as the points do and all of them count.
    for (size_t t = 0; t < allowed_.size(); ++t) allowed_[t] = t % 3 != 0;
    const CarriedPoints carried(points_, normals_, ball_.mesh.restPositions, ball_.mesh.triangles, allowed_, jobs_);
    const std::vector<float> distances = carried.distancesM();
    for (size_t i = 0; i < points_.size(); ++i) {
        const double sampled = sampledDistance(points_[i], ball_.mesh, allowed_);
        EXPECT_LE(distances[i], sampled + 1e-6) << i;
        EXPECT_GT(distances[i], sampled - 0.004) << i << ": the samples are 4 mm apart";
    }
}

TEST_F(CarriedPointsTest, aTriangleThatFacesTheOtherWayIsPassedOver) {
    MeshData two;  // a front at z = 0 and a back at z = −0.01 that is nearer to the point behind
    two.restPositions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -0.01f}, {1, 0, -0.01f}, {0, 1, -0.01f}};
    two.triangles = {{0, 1, 2}, {3, 5, 4}};
    const std::vector<Vec3f> points{{0.2f, 0.2f, -0.02f}}, normals{{0, 0, 1}};
    const std::vector<uint8_t> allowed{1, 1};
    EXPECT_NEAR(CarriedPoints(points, normals, two.restPositions, two.triangles, allowed, jobs_).distancesM()[0], 0.02f, 1e-6);
    const std::vector<Vec3f> backwards{{0, 0, -1}};
    EXPECT_NEAR(CarriedPoints(points, backwards, two.restPositions, two.triangles, allowed, jobs_).distancesM()[0], 0.01f, 1e-6);
}

TEST_F(CarriedPointsTest, movesRigidlyWithARigidSurface) {
    const CarriedPoints carried(points_, normals_, ball_.mesh.restPositions, ball_.mesh.triangles, allowed_, jobs_);
    const Mat3f turn = glm::mat3_cast(glm::angleAxis(1.1f, glm::normalize(Vec3f(1, 2, 3))));
    const Vec3f shift(0.3f, -0.2f, 0.7f);
    std::vector<Vec3f> moved;
    for (const Vec3f& p : ball_.mesh.restPositions) moved.push_back(turn * p + shift);
    const std::vector<Vec3f> rest = carried.at(ball_.mesh.restPositions), after = carried.at(moved);
    for (size_t i = 0; i < points_.size(); ++i) {
        EXPECT_LT(glm::length(rest[i] - points_[i]), 1e-6f) << i;
        EXPECT_LT(glm::length(after[i] - (turn * points_[i] + shift)), 2e-6f) << i;
    }
}

TEST_F(CarriedPointsTest, placesLieOnTheSurfaceAndMoveWithIt) {
    MeshData one;
    one.restPositions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    one.triangles = {{0, 1, 2}};
    const std::vector<Vec3f> points{{0.2f, 0.3f, 0.05f}}, normals{{0, 0, 1}};
    const std::vector<uint8_t> allowed{1};
    const CarriedPoints carried(points, normals, one.restPositions, one.triangles, allowed, jobs_);
    EXPECT_LT(glm::length(carried.places(one.restPositions)[0] - Vec3f(0.2f, 0.3f, 0)), 1e-6f);
    const std::vector<Vec3f> wider{{0, 0, 1}, {2, 0, 1}, {0, 1, 1}};
    EXPECT_LT(glm::length(carried.places(wider)[0] - Vec3f(0.4f, 0.3f, 1)), 1e-6f);
}

TEST_F(CarriedPointsTest, averagesThePlacesOfSeveralPoses) {
    CarriedPoints carried(points_, normals_, ball_.mesh.restPositions, ball_.mesh.triangles, allowed_, jobs_);
    for (const float aside : {0.01f, 0.03f, 0.02f}) {
        std::vector<Vec3f> swayed = points_;
        for (Vec3f& p : swayed) p.x += aside;
        carried.average(swayed, ball_.mesh.restPositions);
    }
    const std::vector<Vec3f> mean = carried.at(ball_.mesh.restPositions);
    for (size_t i = 0; i < points_.size(); ++i) EXPECT_NEAR(mean[i].x - points_[i].x, 0.02f, 1e-6f) << i;
}

}  // namespace
}  // namespace dpl::test
