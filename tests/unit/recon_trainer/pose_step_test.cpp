// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/pose_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/priors.h"
#include "reconstruction/training/trainer/rotation_vector.h"
#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

/** A precision of root and one joint: a random positive definite matrix, stiff in x of the root and loose in its z. */
PosePrecision somePrecision() {
    PosePrecision p;
    p.joints = {0, 2};
    const size_t n = p.size();
    p.matrix.assign(n * n, 0.0);
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            for (size_t k = 0; k < n; ++k)
                p.matrix[i * n + j] += 400 * std::sin(3.0 * double(i + 1) * double(k + 1)) * std::sin(3.0 * double(j + 1) * double(k + 1));
    p.matrix[6 * n + 6] += 4e4, p.matrix[8 * n + 8] += 10;
    return p;
}

std::vector<double> deviation(const Pose& pose, const Pose& from, const std::vector<uint32_t>& joints) {
    std::vector<double> d;
    for (const uint32_t j : joints) {
        const Vec3d w = logQuaternion(Quatd(pose.localRotations[j]) * glm::conjugate(Quatd(from.localRotations[j])));
        d.insert(d.end(), {w.x, w.y, w.z});
    }
    for (int a = 0; a < 3; ++a) d.push_back(double(pose.rootTranslation[a]) - double(from.rootTranslation[a]));
    return d;
}

/** Steps on the loss scale·½ Σ curvature·(d − wanted)² until it rests, and returns d. */
std::vector<double> restOf(double scale, double natsScale, const PosePrecision* precision) {
    Pose from = Pose::rest(3);
    from.localRotations[2] = glm::angleAxis(0.7f, glm::normalize(Vec3f(1, 2, 3)));
    from.rootTranslation = {0.1f, 1, -2};
    const std::vector<uint32_t> joints{0, 2};
    const std::vector<double> wanted{0.02, -0.03, 0.01, 0.04, 0, -0.02, 0.03, -0.02, 0.05};
    Pose pose = from;
    AdamVector adam;
    for (int i = 0; i < 6000; ++i) {
        const std::vector<double> d = deviation(pose, from, joints);
        PoseGradient<double> g;
        g.rotation.assign(3, Vec3d(0));
        for (size_t k = 0; k < 2; ++k)
            for (int a = 0; a < 3; ++a) g.rotation[joints[k]][a] = scale * (d[3 * k + size_t(a)] - wanted[3 * k + size_t(a)]);
        for (int a = 0; a < 3; ++a) g.rootTranslation[a] = scale * (d[6 + size_t(a)] - wanted[6 + size_t(a)]);
        const double rate = 2e-3 * std::pow(1e-4, i / 6000.0);
        stepPose(pose, adam, g, {rate, rate}, {from, precision, natsScale});
    }
    return deviation(pose, from, joints);
}

TEST(PoseStep, restsWherePictureAndRegistrationBalance) {
    const PosePrecision precision = somePrecision();
    const size_t n = precision.size();
    const double s = 5e-4;
    const std::vector<double> wanted{0.02, -0.03, 0.01, 0.04, 0, -0.02, 0.03, -0.02, 0.05}, d = restOf(1, s, &precision);
    double pull = 0, largest = 0;
    for (size_t i = 0; i < n; ++i) {
        double hd = 0;
        for (size_t j = 0; j < n; ++j) hd += precision.matrix[i * n + j] * d[j];
        EXPECT_NEAR(d[i] - wanted[i] + s * hd, 0, 2e-3) << i;  // turns do not quite add up
        pull = std::max(pull, std::abs(s * hd)), largest = std::max(largest, std::abs(d[i]));
    }
    EXPECT_GT(pull, 0.01) << "registration pulls";
    EXPECT_GT(largest, 0.01) << "the picture is heard";
    EXPECT_LT(std::abs(d[6]), 0.004) << "what registration knows well stays";
}

TEST(PoseStep, doesNotDependOnTheUnitOfTheLoss) {
    const PosePrecision precision = somePrecision();
    const auto a = restOf(1, 2e-3, &precision), b = restOf(1e-4, 2e-7, &precision);
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-4) << i;
}

TEST(PoseStep, withoutPrecisionThePictureDecides) {
    const auto d = restOf(1, 2e-3, nullptr);
    EXPECT_NEAR(d[6], 0.03, 1e-3);
    EXPECT_NEAR(d[3], 0.04, 1e-3);
}

TEST(PoseStep, whatIsHeldAlongADirectionCostsMoreThereAlone) {
    const PosePrecision precision = somePrecision();
    const Vec3d along = glm::normalize(Vec3d(1, -2, 3)), across = glm::normalize(glm::cross(along, Vec3d(0, 1, 0)));
    const PosePrecision held = heldAlong(precision, along, 30);
    const Pose from = Pose::rest(3);
    const auto cost = [&](const PosePrecision& p, const Vec3d& moved, float turn) {
        Pose pose = from;
        pose.rootTranslation += Vec3f(moved);
        pose.localRotations[2] = glm::angleAxis(turn, Vec3f(1, 0, 0));
        return costOfDeviation(pose, {from, &p, 0});
    };
    EXPECT_NEAR(cost(held, 0.02 * along, 0) / cost(precision, 0.02 * along, 0), 30, 1e-3);
    EXPECT_NEAR(cost(held, 0.02 * across, 0.1f) / cost(precision, 0.02 * across, 0.1f), 1, 1e-5);
    const size_t n = held.size();
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < i; ++j) EXPECT_NEAR(held.matrix[i * n + j], held.matrix[j * n + i], 1e-9);
}

TEST(PoseStep, jointsThatRegistrationDoesNotTurnStay) {
    const PosePrecision precision = somePrecision();
    const Pose from = Pose::rest(3);
    Pose pose = from;
    AdamVector adam;
    PoseGradient<double> g;
    g.rotation.assign(3, Vec3d(1));
    stepPose(pose, adam, g, {1e-2, 1e-2}, {from, &precision, 1e-9});
    EXPECT_EQ(pose.localRotations[1], from.localRotations[1]);
    EXPECT_NE(pose.localRotations[2], from.localRotations[2]);
}

TEST(PoseStep, aGradientThatIsNotFiniteChangesNothing) {
    const PosePrecision precision = somePrecision();
    const Pose from = Pose::rest(3);
    for (const double bad : {double(NAN), double(INFINITY), 1e200}) {
        for (const size_t place : {size_t(0), size_t(1)}) {
            Pose pose = from;
            AdamVector adam;
            PoseGradient<double> g;
            g.rotation.assign(3, Vec3d(1e-3));
            const PosePull pull{from, &precision, 1e-6};
            stepPose(pose, adam, g, {1e-2, 1e-2}, pull);
            const Pose before = pose;
            const AdamVector moments = adam;
            (place == 0 ? g.rotation[2].y : g.rootTranslation.z) = bad;
            stepPose(pose, adam, g, {1e-2, 1e-2}, pull);
            EXPECT_EQ(pose.localRotations, before.localRotations);
            EXPECT_EQ(pose.rootTranslation, before.rootTranslation);
            EXPECT_EQ(adam.first, moments.first);
            EXPECT_EQ(adam.second, moments.second);
            EXPECT_EQ(adam.steps, moments.steps);
        }
    }
}

TEST(PoseStep, aPullWithoutAFiniteSolutionLeavesThePose) {
    PosePrecision precision = somePrecision();
    precision.matrix[0] = NAN;
    const Pose from = Pose::rest(3);
    Pose pose = from;
    AdamVector adam;
    PoseGradient<double> g;
    g.rotation.assign(3, Vec3d(1e-3));
    g.rootTranslation = Vec3d(1e-3);
    stepPose(pose, adam, g, {1e-2, 1e-2}, {from, &precision, 1e-6});
    EXPECT_EQ(pose.localRotations, from.localRotations);
    EXPECT_EQ(pose.rootTranslation, from.rootTranslation);
}

TEST(PoseStep, aStepOnlyRefinesWhatRegistrationFound) {
    // Registered poses are true; the splats start elsewhere, so that free poses follow them.
    Jobs jobs(2);
    PosePrecision known;
    known.joints = {0, 1};
    known.matrix.assign(known.size() * known.size(), 0.0);
    // 10 mrad and 1 mm against pictures that are trusted 0.01, so that the test does not depend on the constant.
    const double scale = priors::kTrainedPictureTrust / 0.01;
    for (size_t i = 0; i < known.size(); ++i) known.matrix[i * known.size() + i] = scale * (i < 6 ? 1e4 : 1e6);
    CoOptimiseSettings settings = toySettings(200);
    settings.learnGeometry = false;
    double movedM[2] = {};
    for (const bool pulled : {false, true}) {
        CoOptimiseInput input = toyScene(jobs, 8);
        if (pulled)
            for (TrainFrame& f : input.frames) f.precision = std::make_shared<const PosePrecision>(known);
        const std::vector<TrainFrame> frames = input.frames;
        auto t = CoOptimiser::create(std::move(input), settings, jobs);
        ASSERT_TRUE(t) << t.error().message;
        ASSERT_TRUE((*t)->run());
        const CoOptimiseResult r = (*t)->result();
        for (size_t f = 0; f < frames.size(); ++f)
            movedM[pulled] += double(glm::length(r.poses[f].rootTranslation - frames[f].pose.rootTranslation)) / double(frames.size());
    }
    std::printf("mean translation away from the truth: free %.2f mm, pulled %.2f mm\n", 1000 * movedM[0], 1000 * movedM[1]);
    EXPECT_GT(movedM[0], 0.002) << "free poses drift";
    EXPECT_LT(movedM[1], 0.001);
    EXPECT_GT(movedM[1], 0.0) << "the picture is heard";
}

TEST(PoseStep, aPrecisionOfAnotherRigIsRefused) {
    Jobs jobs(1);
    CoOptimiseInput input = toyScene(jobs, 4);
    PosePrecision wrong = somePrecision();  // joint 2 of 2
    input.frames[1].precision = std::make_shared<const PosePrecision>(wrong);
    const auto t = CoOptimiser::create(input, toySettings(8), jobs);
    ASSERT_FALSE(t);
    EXPECT_NE(t.error().message.find("toy_1"), std::string::npos) << t.error().message;
}

}  // namespace
}  // namespace dpl::test
