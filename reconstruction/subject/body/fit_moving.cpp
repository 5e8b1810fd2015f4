// SPDX-License-Identifier: Apache-2.0
// Moving frames of the body fit: track a first guess, choose the depth of arms and legs, solve all train frames together, and pose the
// held-out frames between them.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>

#include "reconstruction/subject/body/body_fitter.h"
#include "reconstruction/subject/body/limb_depths.h"
#include "reconstruction/subject/body/motion_terms.h"
#include "reconstruction/subject/body/priors.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr double kLooseFootScale = 5;
constexpr int kUntangleRounds = 3;
constexpr std::chrono::milliseconds kLookEvery{50};  // whether the whole was cancelled, while the other direction is waited for
constexpr size_t kFewestHeadPoints = 9;              // in three pictures
constexpr double kHeadOutlierSigmas = 4;
constexpr double kShakeNearS = 0.35;                      // of a doubtful picture: half of a slow shake
constexpr double kTrackStepRad = 0.5, kTrackStepM = 0.3;  // σ of the change of pose and root from frame to frame; tracking only

bool isOfHead(const std::string& keypoint) {
    constexpr std::array<std::string_view, 6> kHead = {"nose", "eye_l", "eye_r", "ear_l", "ear_r", "head_top"};
    return std::ranges::find(kHead, keypoint) != kHead.end();
}

}  // namespace

void BodyFitter::addSmoothness(ceres::Problem& problem, const std::vector<size_t>& order, const std::function<bool(size_t)>& involves) {
    const Vec3d up = rotationOf({still_.root[0], still_.root[1], still_.root[2]}) * still_.rootReference * Vec3d(0, 1, 0);
    std::vector<MovingFrame> inTime;
    for (const size_t f : order) {
        FrameState& s = frames_[f];
        inTime.push_back({scan_.frames[f].timeS, &s.rootReference, s.root, s.pose.data(), involves(f), s.headShakes});
    }
    addMotionTerms(problem, {context_, priors_, scan_.keypointNames, up, shape_.data(), {}}, inTime);
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
        addDiagonalPosePrior(problem, s.pose, std::vector<double>(s.pose.size(), kTrackStepRad), s.pose.data());
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

void BodyFitter::untangleMoving(const std::vector<size_t>& order, const std::function<bool(size_t)>& mayChange) {
    std::vector<LimbFrame> inTime;
    for (const size_t f : order) {
        FrameState& s = frames_[f];
        inTime.push_back({scan_.frames[f].timeS, metricCamera(scan_.frames[f].camera, std::exp(logUnit_)), keypoints_[f], &s.rootReference,
                          s.root, &s.pose, mayChange(f)});
    }
    untangleLimbs({body_, chain_, priors_, scan_.keypointNames, shape_.data(), shapeFromMoving_ ? std::span<const double>() : still_.pose},
                  inTime);
}

/** Solves the moving training frames as one problem. loose: outliers of keypoints and of feet count too. */
Status BodyFitter::solveTogether(const char* what, bool loose, int maxSteps, double from, double to) {
    const std::vector<size_t> order = movingInTime(Split::Train);
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

/** Tracks in one direction of time, then chooses the depth of limbs and solves all frames together. Better shoulders and hips give better
 *  depth choices, so both are repeated while the cost falls. Leaves the result of least cost, and returns that cost. */
Result<double> BodyFitter::solveMoving(bool backwards, double from, double to) {
    const std::vector<size_t> order = movingInTime(Split::Train);
    const double part = (to - from) / (2 + 2 * kUntangleRounds);
    double done = from;
    const auto together = [&](const char* what, bool loose, int maxSteps) {
        done += part;
        return solveTogether(what, loose, maxSteps, done - part, done);
    };
    std::vector<size_t> track = order;
    if (backwards) std::reverse(track.begin(), track.end());
    DPL_RETURN_IF_ERROR(trackMoving(track, done, done + part));
    done += part;
    DPL_RETURN_IF_ERROR(together("moving frames: together, loose", true, 12));
    struct Best {
        std::vector<FrameState> frames;
        std::vector<double> shape;
        double logUnit = 0, cost = 0;
    };
    std::optional<Best> best;
    double last = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kUntangleRounds; ++round) {
        untangleMoving(order, [](size_t) { return true; });
        DPL_RETURN_IF_ERROR(together("moving frames: limbs untangled", true, 50));
        DPL_RETURN_IF_ERROR(together("moving frames: together", false, 50));
        const double cost = solves_.back().costAfter;
        if (!best || cost < best->cost) best = Best{frames_, shape_, logUnit_, cost};
        if (cost >= last * (1 - 1e-4)) break;
        last = cost;
    }
    frames_ = best->frames, shape_ = best->shape, logUnit_ = best->logUnit;
    return best->cost;
}

/** Once forwards and once backwards in time, because a limb with wrong depth in one track is often right in the other. */
Status BodyFitter::fitMoving(double from, double to) {
    if (movingInTime(Split::Train).empty()) return {};
    BodyFitter other(*this);
    other.solves_.clear();
    Result<double> forwards = 0.0, backwards = 0.0;
    if (threads_ < 2) {
        const double middle = 0.5 * (from + to);
        DPL_TRY(forwards, solveMoving(false, from, middle));
        DPL_TRY(backwards, other.solveMoving(true, middle, to));
    } else {
        Task beside;  // silent; cancelled with this thread's
        auto helper = std::async(std::launch::async, [&] {
            const TaskScope scope(&beside);
            return other.solveMoving(true, 0, 1);
        });
        forwards = solveMoving(false, from, to);
        Status goesOn = forwards ? Status() : Status(forwards.error());
        while (goesOn && helper.wait_for(kLookEvery) != std::future_status::ready) goesOn = taskAt(to);
        if (!goesOn) beside.cancel();
        backwards = helper.get();
        DPL_RETURN_IF_ERROR(goesOn);
        if (!backwards) return backwards.error();
    }
    solves_.insert(solves_.end(), other.solves_.begin(), other.solves_.end());
    if (*backwards < *forwards) frames_ = other.frames_, shape_ = other.shape_, logUnit_ = other.logUnit_;
    return {};
}

/** How far the head's keypoints lie from the fitted pose. An outlier counts as kHeadOutlierSigmas. */
BodyFitter::HeadDoubt BodyFitter::headDoubt(size_t f) const {
    const FrameState& s = frames_[f];
    KeypointChain::Output out;
    chain_.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, out);
    const Camerad camera = metricCamera(scan_.frames[f].camera, std::exp(logUnit_));
    HeadDoubt doubt;
    for (size_t k = 0; k < keypoints_[f].size(); ++k) {
        const Keypoint& seen = keypoints_[f][k];
        if (!isOfHead(scan_.keypointNames[k]) || !(seen.confidence > 0) || !chain_.hasKeypoint(k)) continue;
        const double apartPx = glm::length(camera.pixelOf(camera.toView(out.points[k])) - seen.px);
        const double sigmas = std::min(seen.confidence * apartPx / sigmaPx(f), kHeadOutlierSigmas);
        doubt.squares += 0.5 * sigmas * sigmas, ++doubt.count;
    }
    return doubt;
}

/** People move their heads evenly, and the fit holds them to it. Where keypoints of three pictures in a row contradict it, and more so than
 * in the best quarter of the film, the head shakes or nods, and all is solved again with a head that may. A film without shakes is left as
 * it is. */
Status BodyFitter::freeShakenHeads(double from, double to) {
    const std::vector<size_t> order = movingInTime(Split::Train);
    std::vector<double> squares(order.size(), 0.0);  // of three pictures in a row
    for (size_t i = 1; i + 1 < order.size(); ++i) {
        HeadDoubt sum;
        for (const size_t k : {i - 1, i, i + 1}) sum += headDoubt(order[k]);
        if (sum.count >= kFewestHeadPoints) squares[i] = sum.squares / double(sum.count);
    }
    const double limit = std::pow(priors::kShakenHeadSigmas, 2) * std::max(1.0, percentile(squares, 0.25));
    bool any = false;
    for (size_t i = 0; i < order.size(); ++i)
        for (const size_t near : order)
            if (squares[i] > limit && std::abs(scan_.frames[near].timeS - scan_.frames[order[i]].timeS) <= kShakeNearS)
                any = frames_[near].headShakes = true;
    if (!any) return {};
    DPL_RETURN_IF_ERROR(solveTogether("moving frames: shaken heads, loose", true, 50, from, 0.5 * (from + to)));
    return solveTogether("moving frames: shaken heads", false, 50, 0.5 * (from + to), to);
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
    for (size_t i = 0; i < order.size(); ++i) {  // between shaken heads heads shake
        if (!isPosed(order[i])) continue;
        size_t before = i, after = i;
        while (before > 0 && isPosed(order[before])) --before;
        while (after + 1 < order.size() && isPosed(order[after])) ++after;
        frames_[order[i]].headShakes = frames_[order[before]].headShakes || frames_[order[after]].headShakes;
    }
    for (int round = 0; round < 2; ++round) {
        context_.outlierSigmas = round == 0 ? kLooseOutliers : settings_.outlierSigmas;
        context_.footSigmaScale = round == 0 ? kLooseFootScale : 1;
        if (round == 1) untangleMoving(order, isPosed);
        ceres::Problem problem;
        for (size_t f : order)
            if (isPosed(f)) addFrame(problem, f);
        addSmoothness(problem, order, isPosed);
        freezeGlobals(problem);
        for (size_t g : order) {
            if (isPosed(g)) continue;
            if (problem.HasParameterBlock(frames_[g].root)) problem.SetParameterBlockConstant(frames_[g].root);
            holdPose(problem, frames_[g].pose);
        }
        const double half = 0.5 * (to - from);
        DPL_RETURN_IF_ERROR(solve(problem, round == 0 ? "untrained moving frames, loose" : "untrained moving frames", 40,
                                  from + half * round, from + half * (round + 1)));
    }
    return {};
}

}  // namespace dpl
