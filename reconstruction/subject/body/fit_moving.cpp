// SPDX-License-Identifier: Apache-2.0
// Moving frames of the body fit: track a first guess, choose the depth of arms and legs, solve all train frames together, let them move
// quickly, and pose the held-out frames between them.
#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/body_fitter.h"
#include "reconstruction/subject/body/limb_depths.h"
#include "reconstruction/subject/body/motion_terms.h"

namespace dpl {
namespace {

constexpr double kLooseFootScale = 5;
constexpr int kUntangleRounds = 3;
constexpr double kSameCost = 1e-4;  // relative
constexpr int kLooseQuickSteps = 25;
// Joints may move quickly only after an even motion has been found. A Gaussian flattens steps: a thigh lifted by 66° in a quarter of a
// second was fitted with 8°. A heavy tail from the start lets single frames of a slow limb take its other depth.
constexpr AccelerationSpread kEven, kQuick{.tail = true, .share = 1};
constexpr double kTrackStepRad = 0.5, kTrackStepM = 0.3;  // σ of the change of pose and root from frame to frame; tracking only

}  // namespace

void BodyFitter::addSmoothness(ceres::Problem& problem, const std::vector<size_t>& order, const std::function<bool(size_t)>& involves) {
    const Vec3d up = rotationOf({still_.root[0], still_.root[1], still_.root[2]}) * still_.rootReference * Vec3d(0, 1, 0);
    std::vector<MovingFrame> inTime;
    for (const size_t f : order) {
        FrameState& s = frames_[f];
        inTime.push_back({scan_.frames[f].timeS, &s.rootReference, s.root, s.pose.data(), involves(f)});
    }
    addMotionTerms(problem, {context_, priors_, scan_.keypointNames, up, shape_.data(), jointSpread_, {}}, inTime);
}

Status BodyFitter::trackMoving(const std::vector<size_t>& order, double from, double to) {
    context_.outlierSigmas = kLooseOutliers;
    const FrameState* previous = &still_;
    for (size_t i = 0; i < order.size(); ++i) {
        FrameState& s = frames_[order[i]];
        s.rootReference = rotationOf({previous->root[0], previous->root[1], previous->root[2]}) * previous->rootReference;
        std::copy(previous->root, previous->root + kRootSize, s.root);
        std::fill(s.root, s.root + 3, 0.0);
        s.pose = previous->pose;
        ceres::Problem problem;
        addFrame(problem, order[i]);
        freezeGlobals(problem);
        problem.AddResidualBlock(new DiagonalPrior(s.pose, std::vector<double>(s.pose.size(), kTrackStepRad)), nullptr, s.pose.data());
        problem.AddResidualBlock(new DiagonalPrior(std::vector<double>(s.root, s.root + kRootSize),
                                                   {kTrackStepRad, kTrackStepRad, kTrackStepRad, kTrackStepM, kTrackStepM, kTrackStepM}),
                                 nullptr, s.root);
        DPL_RETURN_IF_ERROR(solve(problem, "moving frames: first guess", 25, from + (to - from) * double(i) / double(order.size()),
                                  from + (to - from) * double(i + 1) / double(order.size())));
        if (solves_.size() > 1 && solves_[solves_.size() - 2].what == solves_.back().what) {  // merge the frames of a track into one entry
            SolveEnd& total = solves_[solves_.size() - 2];
            total.steps += solves_.back().steps, total.costBefore += solves_.back().costBefore, total.costAfter += solves_.back().costAfter,
                total.how = solves_.back().how;
            solves_.pop_back();
        }
        previous = &s;
    }
    return {};
}

void BodyFitter::untangleMoving(const std::vector<size_t>& order, const std::function<bool(size_t)>& mayChange, double settledSigmas) {
    std::vector<LimbFrame> inTime;
    for (const size_t f : order) {
        FrameState& s = frames_[f];
        inTime.push_back({scan_.frames[f].timeS, metricCamera(scan_.frames[f].camera, std::exp(logUnit_)), keypoints_[f], &s.rootReference,
                          s.root, &s.pose, mayChange(f), settledSigmas * sigmaPx(f)});
    }
    untangleLimbs({body_, chain_, priors_, scan_.keypointNames, shape_.data(), shapeFromMoving_ ? std::span<const double>() : still_.pose},
                  inTime);
}

Status BodyFitter::solveMoving(const std::vector<size_t>& order, const char* what, bool loose, int maxSteps, double from, double to) {
    context_.outlierSigmas = loose ? kLooseOutliers : settings_.outlierSigmas;
    context_.footSigmaScale = loose ? kLooseFootScale : 1;
    ceres::Problem problem;
    for (size_t f : order) addFrame(problem, f);
    addSmoothness(problem, order, [](size_t) { return true; });
    if (shapeFromMoving_) addShapePriors(problem);
    if (!shapeFromMoving_)
        freezeGlobals(problem);
    else if (metric_)
        problem.SetParameterBlockConstant(&logUnit_);
    return solve(problem, what, maxSteps, from, to);
}

Status BodyFitter::fitMoving(double from, double to) {
    const std::vector<size_t> order = movingInTime(Split::Train);
    if (order.empty()) return {};
    const double part = (to - from) / (8 + 2 * (kUntangleRounds - 1) + 2);
    double done = from;
    const auto together = [&](const char* what, bool loose, int maxSteps) {
        done += part;
        return solveMoving(order, what, loose, maxSteps, done - part, done);
    };
    struct Fit {
        std::vector<FrameState> frames;
        std::vector<double> shape;
        double logUnit = 0, cost = 0;
    };
    const Fit start{frames_, shape_, logUnit_, 0};
    const auto restore = [&](const Fit& fit) {
        frames_ = fit.frames;
        std::copy(fit.shape.begin(), fit.shape.end(), shape_.begin());
        logUnit_ = fit.logUnit;
    };
    std::optional<Fit> best;
    const auto untangle = [&]() -> Status {
        untangleMoving(order, [](size_t) { return true; });
        DPL_RETURN_IF_ERROR(together("moving frames: limbs untangled", true, 50));
        DPL_RETURN_IF_ERROR(together("moving frames: together", false, 50));
        const double cost = solves_.back().costAfter;
        if (!best || cost < best->cost) best = Fit{frames_, shape_, logUnit_, cost};
        return {};
    };
    // Track once forwards and once backwards in time, because a limb with wrong depth in one track is often right in the other. Better
    // shoulders and hips give better depth choices, so choose and solve the better one again while its cost falls. Tracks that end alike
    // need no more.
    jointSpread_ = kEven;
    double cost[2] = {};
    for (const bool backwards : {false, true}) {
        restore(start);
        std::vector<size_t> track = order;
        if (backwards) std::reverse(track.begin(), track.end());
        DPL_RETURN_IF_ERROR(trackMoving(track, done, done + part));
        done += part;
        DPL_RETURN_IF_ERROR(together("moving frames: together, loose", true, 12));
        DPL_RETURN_IF_ERROR(untangle());
        cost[backwards] = solves_.back().costAfter;
    }
    restore(*best);
    const bool alike = std::abs(cost[0] - cost[1]) <= kSameCost * best->cost;
    for (int round = 1; round < kUntangleRounds && !alike; ++round) {
        const double last = best->cost;
        DPL_RETURN_IF_ERROR(untangle());
        if (best->cost >= last * (1 - kSameCost)) break;
    }
    restore(*best);
    return followQuickMoves(order, to - 2 * part, to);
}

/** Lets joints accelerate. Only limbs that the even motion left beside their keypoints choose their depth anew. */
Status BodyFitter::followQuickMoves(const std::vector<size_t>& order, double from, double to) {
    jointSpread_ = kQuick;
    untangleMoving(
        order, [](size_t) { return true; }, settings_.outlierSigmas);
    const double half = 0.5 * (from + to);
    DPL_RETURN_IF_ERROR(solveMoving(order, "moving frames: quick moves, loose", true, kLooseQuickSteps, from, half));
    return solveMoving(order, "moving frames: quick moves", false, 50, half, to);
}

/** Poses the moving frames of a split other than training from their own keypoints, with the frames that they know fixed. */
Status BodyFitter::fitHeldOutMoving(Split split, double from, double to) {
    const std::vector<size_t> order = movingInTime(split);
    const auto isPosed = [&](size_t f) { return scan_.frames[f].split == split; };
    if (std::none_of(order.begin(), order.end(), isPosed)) return {};
    for (size_t f : order) {  // start from the train frame nearest in time
        if (!isPosed(f)) continue;
        const FrameState* nearest = nullptr;
        double distance = 0;
        for (size_t g : order)
            if (const double d = std::abs(scan_.frames[g].timeS - scan_.frames[f].timeS); isTrain(g) && (!nearest || d < distance))
                nearest = &frames_[g], distance = d;
        if (!nearest) continue;
        FrameState& s = frames_[f];
        s.rootReference = nearest->rootReference;
        std::copy(nearest->root, nearest->root + kRootSize, s.root);
        s.pose = nearest->pose;
    }
    constexpr const char* kRounds[] = {"untrained moving frames, loose", "untrained moving frames", "untrained moving frames: quick moves"};
    for (int round = 0; round < 3; ++round) {  // as the training frames
        context_.outlierSigmas = round == 0 ? kLooseOutliers : settings_.outlierSigmas;
        context_.footSigmaScale = round == 0 ? kLooseFootScale : 1;
        jointSpread_ = round < 2 ? kEven : kQuick;
        if (round > 0) untangleMoving(order, isPosed, round < 2 ? 0 : settings_.outlierSigmas);
        ceres::Problem problem;
        for (size_t f : order)
            if (isPosed(f)) addFrame(problem, f);
        addSmoothness(problem, order, isPosed);
        freezeGlobals(problem);
        for (size_t g : order)
            if (!isPosed(g))
                for (double* block : {frames_[g].root, frames_[g].pose.data()})
                    if (problem.HasParameterBlock(block)) problem.SetParameterBlockConstant(block);
        const double third = (to - from) / 3;
        DPL_RETURN_IF_ERROR(solve(problem, kRounds[round], 40, from + third * round, from + third * (round + 1)));
    }
    return {};
}

}  // namespace dpl
