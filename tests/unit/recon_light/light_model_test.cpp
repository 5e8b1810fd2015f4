// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/light/light_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/avatar/scene_light.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {
namespace {

const LightData kSide{{-0.6f, 0.3f, -0.2f, 0.1f, -0.15f, -0.2f, 0.1f, 0.05f}};
constexpr uint32_t kVertices = 600;

struct Film {
    double noise = 0.03;      // of a logarithm
    double outliers = 0;      // share of sightings that show something else
    uint32_t moving = 30;     // frames; as many are still
    float largestTurn = 2.5;  // radians
    float blackAlbedo = 0.2f;
};

/** Vertices in all directions, each with an albedo. They look one way in still frames and turn together in moving ones. */
std::vector<LightSighting> sightingsOf(const LightData& light, const Film& film) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<Vec3f> normals(kVertices);
    std::vector<float> albedo(kVertices);
    for (uint32_t v = 0; v < kVertices; ++v) {
        normals[v] = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
        albedo[v] = 255 * (film.blackAlbedo + (1 - film.blackAlbedo) * uniform(random));
    }
    std::vector<LightSighting> out;
    for (uint32_t f = 0; f < 2 * film.moving; ++f) {
        const bool moves = f >= film.moving;
        const Vec3f axis = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
        const Quatf turn = moves ? glm::angleAxis(film.largestTurn * uniform(random), axis) : Quatf(1, 0, 0, 0);
        for (uint32_t v = 0; v < kVertices; ++v) {
            if (uniform(random) < 0.5f) continue;  // hidden
            const Vec3f n = turn * normals[v];
            float value = std::log(albedo[v] * irradianceOn(light, n)) + float(film.noise) * normal(random);
            if (moves && uniform(random) < float(film.outliers)) value -= 1.0f;
            out.push_back({v, moves, value, 1, n});
        }
    }
    return out;
}

double farthest(const LightData& a, const LightData& b) {
    double most = 0;
    for (size_t i = 0; i < kIrradianceCoefficients; ++i) most = std::max(most, std::abs(double(a.irradiance[i]) - double(b.irradiance[i])));
    return most;
}

TEST(LightModel, findsTheLightBehindUnknownAlbedo) {
    const LightFit fit = fitLight(sightingsOf(kSide, {}), kVertices);
    EXPECT_LT(farthest(fit.light, kSide), 0.02);
    EXPECT_GT(fit.strayBefore, 5 * fit.strayAfter);
    EXPECT_NEAR(fit.strayAfter, 0.03, 0.005) << "what is left is noise";
}

TEST(LightModel, shrugsOffWhatIsNoLight) {
    const LightFit fit = fitLight(sightingsOf(kSide, {.outliers = 0.15}), kVertices);
    EXPECT_LT(farthest(fit.light, kSide), 0.08);
}

TEST(LightModel, findsNothingInEvenLight) {
    const LightFit fit = fitLight(sightingsOf({}, {}), kVertices);
    EXPECT_LT(farthest(fit.light, {}), 0.01);
}

TEST(LightModel, smallTurnsTellTheSlopeAndInventNothing) {
    const LightFit fit = fitLight(sightingsOf(kSide, {.largestTurn = 0.3f}), kVertices);
    EXPECT_LT(farthest(fit.light, kSide), 0.15);
    for (const float c : fit.light.irradiance) EXPECT_LT(std::abs(c), 1);
}

TEST(LightModel, staysFiniteInLightThatIsDarkOnOneSide) {
    LightData dark{{-1.9f, 0, 0, 0, 0, 0, 0, 0}};
    const LightFit fit = fitLight(sightingsOf(dark, {}), kVertices);
    for (const float c : fit.light.irradiance) EXPECT_TRUE(std::isfinite(c));
    EXPECT_LT(fit.strayAfter, 0.5 * fit.strayBefore);
}

TEST(LightModel, hasNoLightWithoutStillOrMovingFrames) {
    std::vector<LightSighting> all = sightingsOf(kSide, {}), still, moving;
    for (const LightSighting& s : all) (s.moving ? moving : still).push_back(s);
    EXPECT_TRUE(fitLight(still, kVertices).light.empty());
    EXPECT_TRUE(fitLight(moving, kVertices).light.empty());
    EXPECT_TRUE(fitLight({}, kVertices).light.empty());
}

class LitBall : public testing::Test {
protected:
    LitBall() : mesh_(ballMesh(40, 56)) {
        joints_.resize(2);
        joints_[1].parent = 0;
        const std::vector<Vec3f> normals = restVertexNormals(mesh_);
        for (uint32_t f = 0; f < 24; ++f) {
            TrainFrame frame;
            frame.kind = f < 12 ? FrameKind::StaticFull : FrameKind::Dynamic;
            frame.pose = Pose::rest(2);
            if (f >= 12)
                frame.pose.localRotations[0] = glm::angleAxis(0.5f * float(f), glm::normalize(Vec3f(0.2f, 1, 0.1f * float(f % 5))));
            frame.camera = cameraAt(0.52f * float(f));
            frame.picture = LazyPicture(std::make_shared<FramePicture>(painted(frame, normals)));
            frames_.push_back(std::move(frame));
        }
    }

    static Camerad cameraAt(double heading) {
        Camerad camera;
        camera.widthPx = camera.heightPx = 160, camera.fx = camera.fy = 260, camera.cx = camera.cy = 80;
        const Vec3d forward(-std::sin(heading), 0, -std::cos(heading)), down(0, -1, 0), right = glm::cross(down, forward);
        camera.viewFromWorldRotation = glm::transpose(Mat3d(right, down, forward));
        camera.viewFromWorldTranslation = {0, 0, 0.9};
        return camera;
    }

    /** The ball in kSide, striped, before a bright background. */
    FramePicture painted(const TrainFrame& frame, const std::vector<Vec3f>& normals) {
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(joints_, frame.pose, worldFromRest);
        std::vector<Vec3f> positions;
        skin(mesh_, worldFromRest, jobs_, positions);
        const MeshRaster raster = rasteriseMesh(positions, mesh_.triangles, frame.camera);
        FramePicture picture;
        const size_t pixels = raster.triangle.size();
        picture.image = {frame.camera.widthPx, frame.camera.heightPx, std::vector<uint8_t>(pixels * 3, 250)};
        picture.mask = {frame.camera.widthPx, frame.camera.heightPx, std::vector<uint8_t>(pixels, 0)};
        for (size_t i = 0; i < pixels; ++i) {
            if (raster.triangle[i] == kNoTriangle) continue;
            const uint32_t v = mesh_.triangles[raster.triangle[i]].x;
            const Vec3f turned = turnedNormal(normals[v], mesh_.jointIndices[v], mesh_.jointWeights[v], worldFromRest);
            const float albedo = mesh_.restPositions[v].y > 0 ? 110.0f : 70.0f;
            const float value = albedo * irradianceOn(kSide, glm::normalize(turned));
            for (int c = 0; c < 3; ++c) picture.image.pixels[3 * i + size_t(c)] = uint8_t(std::min(value, 255.0f));
            picture.mask.pixels[i] = 255;
        }
        return picture;
    }

    Jobs jobs_{2};
    MeshData mesh_;
    std::vector<JointData> joints_;
    std::vector<TrainFrame> frames_;
};

TEST_F(LitBall, isFoundInPictures) {
    const auto fit = findLight(joints_, mesh_, frames_, jobs_);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT(farthest(fit->light, kSide), 0.1) << "pictures have steps of a level, and a triangle has one colour";
    EXPECT_LT(fit->strayAfter, 0.3 * fit->strayBefore);
}

TEST_F(LitBall, isNotLookedForInAFewMovingFrames) {
    frames_.pop_back();
    const auto fit = findLight(joints_, mesh_, frames_, jobs_);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->light.empty()) << "eleven poses that are a little wrong tell of their errors";
}

TEST_F(LitBall, sightingsStayInsideTheOutlineAndOutOfCloseups) {
    frames_.resize(1);
    const auto seen = lightSightings(joints_, mesh_, frames_, jobs_);
    ASSERT_TRUE(seen) << seen.error().message;
    ASSERT_GT(seen->size(), 200u);
    const Vec3d eye = frames_[0].camera.eye();
    for (const LightSighting& s : *seen) {
        EXPECT_FALSE(s.moving);
        EXPECT_LT(s.logBrightness, std::log(240.0f)) << "the background is not on the ball";
        EXPECT_GT(glm::dot(Vec3d(s.normal), glm::normalize(eye)), 0.2) << "seen from the front";
    }
    frames_[0].kind = FrameKind::StaticCloseup;
    EXPECT_TRUE(lightSightings(joints_, mesh_, frames_, jobs_)->empty());
}

TEST_F(LitBall, isTheSameOnAnyNumberOfThreads) {
    Jobs one(1), three(3);
    EXPECT_EQ(findLight(joints_, mesh_, frames_, one)->light.irradiance, findLight(joints_, mesh_, frames_, three)->light.irradiance);
}

}  // namespace
}  // namespace dpl::test
