// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_limbs.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "reconstruction/subject/body/priors.h"

namespace dpl::test {
namespace {

/** The cost of a sequence, from its definition: candidates, and accelerations of elbow and wrist over three frames. */
double costOf(const std::vector<LimbChoices>& frames, const std::vector<size_t>& chosen) {
    double cost = 0;
    const auto acceleration = [&](size_t i, const Vec3d& a, const Vec3d& b, const Vec3d& c, double sigma) {
        const double before = frames[i - 1].timeS - frames[i - 2].timeS, after = frames[i].timeS - frames[i - 1].timeS;
        if (before >= kMaxGapS || after >= kMaxGapS) return 0.0;
        const Vec3d v = ((c - b) / after - (b - a) / before) / (0.5 * (before + after));
        const double noise = 2.4 * priors::kDepthNoiseM / (before * after);
        return glm::dot(v, v) / (sigma * sigma + noise * noise);
    };
    for (size_t i = 0; i < frames.size(); ++i) {
        const LimbCandidate& c = frames[i].candidates[chosen[i]];
        cost += c.cost;
        if (i < 2) continue;
        const LimbCandidate &a = frames[i - 2].candidates[chosen[i - 2]], &b = frames[i - 1].candidates[chosen[i - 1]];
        cost += acceleration(i, a.elbow, b.elbow, c.elbow, priors::kElbowAccelerationMS2) +
                acceleration(i, a.wrist, b.wrist, c.wrist, priors::kWristAccelerationMS2);
    }
    return cost;
}

TEST(FitLimbs, findsTheCheapestOfAllSequences) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const auto point = [&] { return 0.3 * Vec3d(normal(random), normal(random), normal(random)); };
    for (int round = 0; round < 40; ++round) {
        std::vector<LimbChoices> frames(size_t(1 + round % 6));
        double time = 0;
        for (LimbChoices& frame : frames) {
            time += round % 5 == 4 && uniform(random) < 0.3 ? 1.5 : 0.1 + 0.2 * uniform(random);  // some gaps are too long to link frames
            frame.timeS = time;
            frame.candidates.resize(uniform(random) < 0.25 ? 1 : 4);  // one: a frame whose limb stays
            for (LimbCandidate& c : frame.candidates) c.elbow = point(), c.wrist = point(), c.cost = 6 * uniform(random);
        }
        double least = std::numeric_limits<double>::infinity();
        std::vector<size_t> all(frames.size(), 0);
        for (size_t digit = 0; digit < frames.size();) {
            least = std::min(least, costOf(frames, all));
            for (digit = 0; digit < frames.size() && ++all[digit] == frames[digit].candidates.size(); ++digit) all[digit] = 0;
        }
        EXPECT_NEAR(costOf(frames, chooseLimbs(frames)), least, 1e-9 * least) << round;
    }
    EXPECT_TRUE(chooseLimbs({}).empty());
}

TEST(FitLimbs, candidatesLieOnTheRaysAtTheirLengths) {
    LimbRig rig;
    rig.upperDirection = {0, -1, 0}, rig.hingeAxis = {1, 0, 0};
    rig.upperM = 0.42, rig.lowerM = 0.43;
    LimbView view;
    view.camera.widthPx = 400, view.camera.heightPx = 500, view.camera.fx = view.camera.fy = 380, view.camera.cx = 200,
    view.camera.cy = 250;
    view.shoulder = {0.1, 0.05, 2.5};
    const auto px = [&](const Vec3d& p) { return view.camera.pixelOf(view.camera.toView(p)); };
    const Vec3d knee = view.shoulder + 0.42 * glm::normalize(Vec3d(0.1, 0.5, -0.8)), ankle = knee + 0.43 * glm::normalize(Vec3d(0, 1, 0.3));
    view.elbowPx = px(knee), view.wristPx = px(ankle);
    double nearest = 1;
    for (const LimbCandidate& c : limbCandidates(rig, view)) {
        EXPECT_NEAR(glm::length(c.elbow - view.shoulder), rig.upperM, 1e-9);
        EXPECT_NEAR(glm::length(c.wrist - c.elbow), rig.lowerM, 1e-9);
        EXPECT_LT(glm::length(px(c.elbow) - view.elbowPx), 1e-6);
        nearest = std::min(nearest, glm::length(c.elbow - knee) + glm::length(c.wrist - ankle));
    }
    EXPECT_LT(nearest, 1e-9) << "the true limb is among them";
    view.wristPx = {-2000, 250};  // no point of this ray is near enough
    for (const LimbCandidate& c : limbCandidates(rig, view)) EXPECT_NEAR(glm::length(c.wrist - c.elbow), rig.lowerM, 1e-9);
}

}  // namespace
}  // namespace dpl::test
