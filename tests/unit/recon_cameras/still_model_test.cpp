// SPDX-License-Identifier: Apache-2.0
// Matches become points, and pictures are placed on them. Features are made up: each point has a descriptor of its own, and some lie.
#include "reconstruction/input/cameras/still_model.h"

#include <gtest/gtest.h>

#include "reconstruction/input/cameras/align_cameras.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

const LensDistortion kLens{-0.04, 0};

std::vector<uint8_t> descriptorOf(size_t point) {
    std::mt19937 random(uint32_t(point) + 1);
    std::vector<uint8_t> bytes(kFeatureBytes);
    for (uint8_t& byte : bytes) byte = uint8_t(random() & 127);
    return bytes;
}

/** What a camera shows of the points; a share of the features has the descriptor of another point. */
Features featuresOf(const Camerad& camera, const std::vector<Vec3d>& points, double noisePx, double wrongShare, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, noisePx);
    std::uniform_real_distribution<double> uniform(0, 1);
    Features out;
    for (size_t p = 0; p < points.size(); ++p) {
        if (camera.toView(points[p]).z < 0.3) continue;
        const Vec2d px = storedPixel(camera, kLens, points[p]) + Vec2d{noise(random), noise(random)};
        if (px.x < 0 || px.y < 0 || px.x > camera.widthPx || px.y > camera.heightPx) continue;
        out.px.push_back(px);
        const auto bytes = descriptorOf(uniform(random) < wrongShare ? size_t(uniform(random) * double(points.size())) : p);
        out.descriptors.insert(out.descriptors.end(), bytes.begin(), bytes.end());
    }
    return out;
}

struct Room {
    std::vector<Vec3d> points = roomPoints(500, 9);
    std::vector<StillPicture> stills;
    explicit Room(double wrongShare) {
        for (const Camerad& camera : orbit(14))
            stills.push_back({camera, featuresOf(camera, points, 0.4, wrongShare, uint32_t(stills.size()))});
    }
};

TEST(StillModel, pointsLieWhereTheyAre) {
    const Room room(0.2);
    const auto tracks = findTracks(room.stills, kLens, {});
    ASSERT_TRUE(tracks) << tracks.error().message;
    EXPECT_GT(tracks->scene.points.size(), 250u);
    std::vector<double> distances;
    for (const Vec3d& p : tracks->scene.points) {
        double nearest = INFINITY;
        for (const Vec3d& q : room.points) nearest = std::min(nearest, glm::length(p - q));
        distances.push_back(nearest);
    }
    std::sort(distances.begin(), distances.end());
    EXPECT_LT(distances[distances.size() / 2], 0.02);  // 0.4 px at 4 m is 4 mm, and neighbours of an orbit triple it
    EXPECT_LT(tracks->epipolarMissPx, 1);
    for (const uint32_t matches : tracks->matchesOfPicture) EXPECT_GT(matches, 100u);
}

TEST(StillModel, farPicturesAreMatchedWhenAsked) {
    const Room room(0);
    TrackSettings settings;
    settings.nearest = 1;
    const auto few = findTracks(room.stills, kLens, settings);
    settings.morePairs = {{0, 2}, {0, 12}, {0, 1}};  // the last is matched anyway, and only once
    const auto more = findTracks(room.stills, kLens, settings);
    ASSERT_TRUE(few && more);
    EXPECT_GT(more->matchesOfPicture[0], few->matchesOfPicture[0] + 60);
    EXPECT_GT(more->matchesOfPicture[2], few->matchesOfPicture[2] + 30);
    EXPECT_GT(more->matchesOfPicture[12], few->matchesOfPicture[12] + 30);
    EXPECT_EQ(more->matchesOfPicture[4], few->matchesOfPicture[4]);
    EXPECT_EQ(more->matchesOfPicture[1], few->matchesOfPicture[1]);
}

TEST(StillModel, pictureIsPlacedDespiteWrongMatches) {
    const Room room(0.1);
    const auto tracks = findTracks(room.stills, kLens, {});
    ASSERT_TRUE(tracks);
    Camerad truth = room.stills[0].camera;
    lookFrom(truth, {1.1, 1.6, -1.9}, {0.2, 1.0, 0.1});
    Camerad intrinsics = truth;
    intrinsics.viewFromWorldRotation = Mat3d(1), intrinsics.viewFromWorldTranslation = Vec3d(0);
    const auto placed = placePicture(featuresOf(truth, room.points, 0.4, 0.3, 99), intrinsics, *tracks);
    ASSERT_TRUE(placed);
    const CameraError error = cameraError(placed->camera, truth, std::vector<Vec3d>{{0, 1, 0}});
    EXPECT_LT(error.eye, 0.01);
    EXPECT_LT(error.px, 0.8);  // measured 0.56 px
    EXPECT_GE(placed->inliers, kFewestInliers);
    EXPECT_LT(placed->missPx, 1);
    // With a camera that is near, and with one that is not, it is found as well.
    for (const size_t near : {size_t(7), size_t(0)}) {
        const auto hinted = placePicture(featuresOf(truth, room.points, 0.4, 0.3, 99), intrinsics, *tracks, &room.stills[near].camera);
        ASSERT_TRUE(hinted) << near;
        EXPECT_LT(cameraError(hinted->camera, truth, {}).eye, 0.02) << near;
    }
}

TEST(StillModel, pictureIsNotPlacedByAFewThatAgreeNearAWrongCamera) {
    const Room room(0);
    const auto tracks = findTracks(room.stills, kLens, {});
    ASSERT_TRUE(tracks);
    Camerad truth = room.stills[0].camera, wrong = room.stills[7].camera;
    lookFrom(truth, {1.1, 1.6, -1.9}, {0.2, 1.0, 0.1});
    // 40 features are those of another view, as of a poster that hangs in two places.
    Features features = featuresOf(truth, room.points, 0.4, 0, 99);
    Features others = featuresOf(wrong, room.points, 0.4, 0, 98);
    ASSERT_GT(others.px.size(), 40u);
    features.px.insert(features.px.end(), others.px.begin(), others.px.begin() + 40);
    features.descriptors.insert(features.descriptors.end(), others.descriptors.begin(), others.descriptors.begin() + 40 * kFeatureBytes);
    const auto placed = placePicture(features, truth, *tracks, &wrong);
    ASSERT_TRUE(placed);
    EXPECT_LT(cameraError(placed->camera, truth, {}).eye, 0.02);
    EXPECT_GT(placed->inliers, 60u);  // measured: 86; the others are 40
}

TEST(StillModel, pictureOfAnotherPlaceIsNotPlaced) {
    const Room room(0);
    const auto tracks = findTracks(room.stills, kLens, {});
    ASSERT_TRUE(tracks);
    // Right descriptors at wrong places: nothing agrees.
    Features shuffled = room.stills[3].features;
    std::mt19937 random(1);
    std::shuffle(shuffled.px.begin(), shuffled.px.end(), random);
    EXPECT_FALSE(placePicture(shuffled, room.stills[3].camera, *tracks));
    EXPECT_FALSE(placePicture({}, room.stills[3].camera, *tracks));
}

TEST(StillModel, picturesWithoutParallaxGiveNoPoints) {
    std::vector<StillPicture> turning;
    const auto points = roomPoints(300, 2);
    for (size_t i = 0; i < 5; ++i) {
        Camerad camera = orbit(1)[0];
        lookFrom(camera, {0, 1.5, 0}, {std::sin(0.15 * double(i)), 1.5, std::cos(0.15 * double(i))});
        turning.push_back({camera, featuresOf(camera, points, 0.1, 0, uint32_t(i))});
    }
    const auto tracks = findTracks(turning, kLens, {});
    ASSERT_TRUE(tracks);
    EXPECT_TRUE(tracks->scene.points.empty());
    const auto single = findTracks(std::span(turning).first(1), kLens, {});
    ASSERT_TRUE(single);
    EXPECT_TRUE(single->scene.points.empty());
    EXPECT_TRUE(findTracks({}, kLens, {}));
}

TEST(StillModel, stopsWhenAsked) {
    const Room room(0);
    test::HeardTask cancelled(1);
    const TaskScope scope(&cancelled);
    const auto tracks = findTracks(room.stills, kLens, {});
    ASSERT_FALSE(tracks);
    EXPECT_EQ(tracks.error().code, Code::Cancelled);
    EXPECT_EQ(cancelled.heard.size(), 1u);
}

}  // namespace
}  // namespace dpl
