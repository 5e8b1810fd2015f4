// SPDX-License-Identifier: Apache-2.0
// The solver behind fitBody(). Private to reconstruction/subject/body. fit_body.cpp fits the still frames, fit_moving.cpp the moving ones.
#pragma once

#include <ceres/problem.h>

#include <functional>
#include <optional>

#include "reconstruction/subject/body/fit_body.h"
#include "reconstruction/subject/body/fit_costs.h"
#include "reconstruction/subject/body/keypoint_chain.h"
#include "reconstruction/subject/body/keypoint_noise.h"
#include "reconstruction/subject/body/landmark_offsets.h"

namespace dpl {

constexpr double kLooseOutliers = 40;  // Geman–McClure scale in σ for the first solves, whose poses are still coarse

/** The unknowns of one frame. A moving frame uses `root` and `pose`; a still frame only `sway`, added to the shared still pose. */
struct FrameState {
    Mat3d rootReference{1};
    double root[kRootSize] = {};
    std::vector<double> pose, sway;
    bool fitted = false;
    bool headShakes = false;
};

class BodyFitter {
public:
    BodyFitter(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints, const BodyFitSettings& settings,
               uint32_t threads)
        : body_(body),
          scan_(scan),
          keypoints_(keypoints),
          settings_(settings),
          threads_(threads),
          priors_(posePriors(body)),
          chain_(body, scan.keypointNames, jointsOf(priors_)),
          metric_(scan.metricWorld) {
        context_.chain = &chain_;  // a copy looks at this one's, which no longer changes when it is made
        for (size_t k = 0; scan.keypointsFound && k < chain_.keypointCount(); ++k)
            chain_.setOffset(k, foundLandmarkOffset(scan.keypointNames[k]));
        for (size_t s = 0; s < priors_.size(); ++s)
            if (priors_[s].swayRad > 0) context_.sway.slots.push_back(uint32_t(s));
        shape_.assign(chain_.shapeCount(), 0.0);
        frames_.resize(scan.frames.size());
        for (FrameState& f : frames_) f.pose.assign(3 * chain_.posedCount(), 0.0), f.sway.assign(size_t(context_.sway.size()), 0.0);
        still_.pose.assign(3 * chain_.posedCount(), 0.0);
    }

    Result<BodyFit> run();

private:
    bool isStill(size_t f) const { return scan_.frames[f].kind != FrameKind::Dynamic; }
    bool isTrain(size_t f) const { return scan_.frames[f].split == Split::Train; }
    bool usable(size_t f) const;
    std::vector<size_t> select(FrameKind kind, Split split) const;
    /** Whether frame g may influence the pose of a frame of this split: training frames know only each other, validation frames know
     *  training frames too, and test frames know all. */
    bool isKnownTo(Split split, size_t g) const { return scan_.frames[g].split <= split; }
    std::vector<size_t> movingInTime(Split knownTo) const;
    double sigmaPx(size_t f) const {
        return keypointSigma(scan_) * std::hypot(double(scan_.frames[f].camera.widthPx), double(scan_.frames[f].camera.heightPx));
    }

    struct HeadDoubt {
        double squares = 0;  // of coordinates, in variances of a keypoint
        size_t count = 0;
        void operator+=(const HeadDoubt& other) { squares += other.squares, count += other.count; }
    };
    Status start();
    Status solve(ceres::Problem& problem, const char* what, int maxSteps, double from, double to);
    std::vector<double> swaySigmas() const;
    void addFrame(ceres::Problem& problem, size_t f);
    void addSmoothness(ceres::Problem& problem, const std::vector<size_t>& order, const std::function<bool(size_t)>& involves);
    void addShapePriors(ceres::Problem& problem);
    void addStillPriors(ceres::Problem& problem);
    void freezeGlobals(ceres::Problem& problem);
    Status fitStill(double from, double to);
    double swayFreedom(size_t f);
    void findLandmarks();
    std::optional<KeypointNoise> detectorNoise();
    Status refineShape(double from, double to);
    void untangleMoving(const std::vector<size_t>& order, const std::function<bool(size_t)>& mayChange);
    Status trackMoving(const std::vector<size_t>& order, double from, double to);
    Result<double> solveMoving(bool backwards, double from, double to);
    Status solveTogether(const char* what, bool loose, int maxSteps, double from, double to);
    Status fitMoving(double from, double to);
    HeadDoubt headDoubt(size_t f) const;
    Status freeShakenHeads(double from, double to);
    Status fitUntrained(double from, double to);
    Status fitHeldOutMoving(Split split, double from, double to);
    FrameState effective(size_t f) const;
    Pose poseOf(const FrameState& s) const;
    void interpolate(size_t f, BodyFit& fit) const;
    std::optional<KindResidual> residual(FrameKind kind, Split split) const;
    BodyFit collect() const;

    const BodyModel& body_;
    const Scan& scan_;
    std::span<const std::vector<Keypoint>> keypoints_;
    const BodyFitSettings& settings_;
    uint32_t threads_;
    std::vector<JointPrior> priors_;
    KeypointChain chain_;
    FitContext context_;
    std::vector<double> shape_;
    bool metric_;  // lengths of the scan's world are metres: it says so, or the person's size does
    double logUnit_ = 0;
    std::optional<KeypointNoise> detectorNoise_;
    FrameState still_;
    std::vector<FrameState> frames_;
    std::vector<SolveEnd> solves_;
    bool shapeFromMoving_ = false;
};

}  // namespace dpl
