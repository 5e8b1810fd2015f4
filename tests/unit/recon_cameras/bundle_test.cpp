// SPDX-License-Identifier: Apache-2.0
// Disturbed cameras come back, whatever their matches; scenes that say too little are refused or stay as they are.
#include "reconstruction/input/cameras/bundle.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/gradient_checker.h>
#include <ceres/manifold.h>
#include <gtest/gtest.h>

#include "reconstruction/input/cameras/align_cameras.h"
#include "reconstruction/input/cameras/bundle_cost.h"
#include "sdk/core/percentile.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

/** What `cameras` see of the points, with noise and with a share of wrong matches. */
BundleScene seenScene(std::vector<Camerad> cameras, std::vector<Vec3d> points, const LensDistortion& lens, double noisePx,
                      double wrongShare) {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0, noisePx > 0 ? noisePx : 1);
    std::uniform_real_distribution<double> uniform(0, 1);
    BundleScene scene{std::move(cameras), lens, std::move(points), {}};
    for (size_t c = 0; c < scene.cameras.size(); ++c)
        for (size_t p = 0; p < scene.points.size(); ++p) {
            const Camerad& camera = scene.cameras[c];
            if (camera.toView(scene.points[p]).z < 0.3) continue;
            Vec2d px = storedPixel(camera, lens, scene.points[p]);
            if (px.x < 0 || px.y < 0 || px.x > camera.widthPx || px.y > camera.heightPx) continue;
            if (noisePx > 0) px += Vec2d{noise(random), noise(random)};
            if (uniform(random) < wrongShare) px = {uniform(random) * camera.widthPx, uniform(random) * camera.heightPx};
            scene.observations.push_back({uint32_t(c), uint32_t(p), px});
        }
    return scene;
}

/** Turns each camera by `turnDeg` about its eye and moves its eye by `shiftM`, both in directions of its own. */
void disturb(std::vector<Camerad>& cameras, double turnDeg, double shiftM) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;  // its draws stand in braces: arguments in parentheses have no order
    for (Camerad& camera : cameras) {
        const Vec3d eye = camera.eye() + shiftM * glm::normalize(Vec3d{normal(random), normal(random), normal(random)});
        camera.viewFromWorldRotation =
            turnAbout({normal(random), normal(random), normal(random)}, turnDeg * std::numbers::pi / 180) * camera.viewFromWorldRotation;
        camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * eye);
    }
}

/** Median error on the subject, px, after alignment. */
double subjectErrorPx(const std::vector<Camerad>& cameras, const std::vector<Camerad>& truth) {
    const auto align = alignCameras(cameras, truth);
    if (!align) return INFINITY;
    std::vector<double> errors;
    const std::vector<Vec3d> points{{0, 0.1, 0}, {0, 1, 0}, {0, 1.7, 0}, {0.3, 1.2, 0}, {-0.3, 1.2, 0}};
    for (size_t i = 0; i < cameras.size(); ++i) errors.push_back(cameraError(moved(cameras[i], *align), truth[i], points).px);
    return percentile(errors, 0.5);
}

TEST(Bundle, gradientIsThatOfTheResidual) {
    const ReprojectionMiss miss{380, 370, 189, 252, 0.02, 200, 260};
    ceres::AutoDiffCostFunction<ReprojectionMiss, 2, 4, 3, 2, 3> cost(new ReprojectionMiss(miss));
    const double rotation[4] = {0.1, -0.2, 0.3, std::sqrt(1 - 0.14)}, translation[3] = {0.1, -0.2, 2}, lens[2] = {0.1, -0.05},
                 point[3] = {0.4, 0.3, -0.2};
    const double* parameters[] = {rotation, translation, lens, point};
    ceres::EigenQuaternionManifold unit;
    const std::vector<const ceres::Manifold*> manifolds{&unit, nullptr, nullptr, nullptr};
    ceres::NumericDiffOptions numeric;
    ceres::GradientChecker checker(&cost, &manifolds, numeric);
    ceres::GradientChecker::ProbeResults results;
    EXPECT_TRUE(checker.Probe(parameters, 1e-7, &results)) << results.error_log;
    EXPECT_GT(results.jacobians[0].norm(), 1) << "the case must not be flat";
    // The value is storedPixel()'s, which shares no code with the residual.
    Camerad camera;
    camera.fx = 380 * std::exp(0.1), camera.fy = 370 * std::exp(0.1), camera.cx = 189, camera.cy = 252;
    camera.viewFromWorldRotation = glm::mat3_cast(Quatd(rotation[3], rotation[0], rotation[1], rotation[2]));
    camera.viewFromWorldTranslation = {0.1, -0.2, 2};
    const Vec2d px = storedPixel(camera, {-0.05, 0.02}, {0.4, 0.3, -0.2});
    EXPECT_NEAR(results.residuals[0], px.x - 200, 1e-9);
    EXPECT_NEAR(results.residuals[1], px.y - 260, 1e-9);
}

TEST(Bundle, disturbedCamerasComeBackBelowAPixel) {
    const auto truth = orbit(16);
    for (const double wrongShare : {0.0, 0.15}) {
        BundleScene scene = seenScene(truth, roomPoints(400, 3), {}, 0.5, wrongShare);
        disturb(scene.cameras, 0.5, 0.02);  // half a degree is 3.3 px, 2 cm at 2 m is 3.8 px
        const double before = subjectErrorPx(scene.cameras, truth);
        EXPECT_GT(before, 2.5);
        const auto end = adjustBundle(scene, {});
        ASSERT_TRUE(end) << end.error().message;
        // Measured: 0.50 px, and 0.48 px with wrong matches. Each point is in few pictures, so noise of 0.5 px bends the orbit a little.
        EXPECT_LT(subjectErrorPx(scene.cameras, truth), 0.8) << "wrong matches: " << wrongShare;
        EXPECT_LT(end->missAfterPx, 0.7);
        EXPECT_GT(end->missBeforePx, 2);
    }
}

TEST(Bundle, focalLengthThatIsAFifthOffIsFound) {
    const auto truth = orbit(16);
    const LensDistortion lens{0.03, 0};
    BundleSettings settings;
    settings.findFocal = settings.findLens = true;
    settings.outlierPx = 60;  // nothing fits at the start
    settings.rounds = 4;
    BundleScene best = seenScene(truth, roomPoints(400, 3), lens, 0.5, 0.05);  // from the truth: what the noisy matches say
    ASSERT_TRUE(adjustBundle(best, settings));
    // Measured: noise of 0.5 px moves the focal length by 3.6 px and k1 by 0.0104.
    EXPECT_NEAR(best.cameras[0].fx, 380, 5);
    EXPECT_NEAR(best.lens.k1, lens.k1, 0.015);
    for (const double factor : {1.2, 1 / 1.2}) {
        BundleScene scene = seenScene(truth, roomPoints(400, 3), lens, 0.5, 0.05);
        for (Camerad& camera : scene.cameras) camera.fx *= factor, camera.fy *= factor;
        scene.lens = {};
        const auto end = adjustBundle(scene, settings);
        ASSERT_TRUE(end) << end.error().message;
        EXPECT_NEAR(scene.cameras[0].fx, best.cameras[0].fx, 0.1) << factor;
        EXPECT_NEAR(scene.lens.k1, best.lens.k1, 0.001) << factor;
        EXPECT_NEAR(end->focalFactor, scene.cameras[0].fx / (380 * factor), 1e-9);
    }
}

TEST(Bundle, fixedCamerasAndPointsStay) {
    const auto truth = orbit(8);
    BundleScene scene = seenScene(truth, roomPoints(200, 3), {}, 0.3, 0);
    disturb(scene.cameras, 0.5, 0.02);
    const auto given = scene.cameras;
    const auto points = scene.points;
    BundleSettings settings;
    settings.fixed.assign(8, true);
    settings.fixed[5] = false;
    settings.fixedPoints = true;
    ASSERT_TRUE(adjustBundle(scene, settings));
    for (size_t i = 0; i < 8; ++i) {
        const bool same = glm::length(scene.cameras[i].eye() - given[i].eye()) < 1e-9;
        EXPECT_EQ(same, i != 5) << i;
    }
    EXPECT_LT(cameraError(scene.cameras[5], truth[5], {}).eye, 0.005);  // 0.3 px at 4 m is 3 mm
    for (size_t p = 0; p < points.size(); ++p) EXPECT_EQ(scene.points[p], points[p]);
}

TEST(Bundle, pureRotationKeepsTheDirectionsRight) {
    std::vector<Camerad> truth = orbit(6);
    for (size_t i = 0; i < truth.size(); ++i) lookFrom(truth[i], {0, 1.5, 0}, {std::sin(0.2 * double(i)), 1.5, std::cos(0.2 * double(i))});
    BundleScene scene = seenScene(truth, roomPoints(300, 5), {}, 0.3, 0);
    disturb(scene.cameras, 2, 0);
    const auto end = adjustBundle(scene, {});
    ASSERT_TRUE(end) << end.error().message;
    EXPECT_LT(end->missAfterPx, 0.6);
    // Depth is open, and a small turn looks like a small shift. Larger angles between the cameras are told.
    const Mat3d seen = scene.cameras[5].viewFromWorldRotation * glm::transpose(scene.cameras[0].viewFromWorldRotation);
    const Mat3d wanted = truth[5].viewFromWorldRotation * glm::transpose(truth[0].viewFromWorldRotation);
    for (int c = 0; c < 3; ++c) EXPECT_LT(glm::length(seen[c] - wanted[c]), 0.015);  // put in: 2 degrees each, 0.05 together
}

TEST(Bundle, scenesThatSayTooLittleAreRefused) {
    BundleScene one = seenScene(orbit(1), roomPoints(200, 3), {}, 0.3, 0);
    EXPECT_FALSE(adjustBundle(one, {})) << "one picture tells no depth";
    BundleScene none;
    EXPECT_FALSE(adjustBundle(none, {}));
    BundleScene good = seenScene(orbit(4), roomPoints(100, 3), {}, 0.3, 0);
    const auto refused = [&](auto change) {
        BundleScene scene = good;
        BundleSettings settings;
        change(scene, settings);
        const auto cameras = scene.cameras;
        const auto end = adjustBundle(scene, settings);
        EXPECT_EQ(scene.cameras[0].viewFromWorldTranslation == cameras[0].viewFromWorldTranslation, true) << "changed on failure";
        return !end;
    };
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) { s.observations[0].camera = 4; }));
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) { s.observations[0].point = 100; }));
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) { s.observations[3].px.x = NAN; }));
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) { s.points[2].y = INFINITY; }));
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) { s.cameras[1].fx = 0; }));
    EXPECT_TRUE(refused([](BundleScene&, BundleSettings& t) { t.fixed.assign(3, true); }));
    EXPECT_TRUE(refused([](BundleScene& s, BundleSettings&) {
        for (Camerad& c : s.cameras) c.viewFromWorldTranslation.z -= 100;  // everything lies behind
    }));
    test::HeardTask cancelled(0);
    const TaskScope scope(&cancelled);
    EXPECT_TRUE(refused([](BundleScene&, BundleSettings&) {}));
}

}  // namespace
}  // namespace dpl
