// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/hands/fit_fingers.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/fit_costs.h"
#include "reconstruction/subject/body/fit_limbs.h"
#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "reconstruction/subject/hands/finger_cost.h"
#include "reconstruction/subject/hands/finger_precision.h"
#include "reconstruction/subject/hands/hand_rig.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kMinPoints = 8;       // of a hand that a frame shows
constexpr size_t kMinStillFrames = 3;  // that show a hand, for a still pose of its fingers
constexpr double kLooseOutliers = 40;  // Geman–McClure scale, σ, while the fingers are still far off
constexpr double kCurledShare = 0.6;   // of the range of each bend: a start between a flat hand and a fist
constexpr int kSteps = 60;

Mat3x4f worldFromWrist(const BodyModel& shaped, const HandRig& rig, const Pose& pose) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(shaped.joints, pose, worldFromRest);
    return worldFromRest[rig.wrist];
}

/** How far the bases of a frame's fingers lie from those of a hand of the fitted body, px; huge where a point is missing or behind the
 *  camera. */
double missPx(std::span<const Keypoint> points, const HandRig& rig, const Mat3x4f& wrist, const Vec3d& rest, const Camerad& camera) {
    double sum = 0;
    for (size_t f = 0; f < kHandFingers; ++f) {
        const Vec3d view = camera.toView(Vec3d(wrist * Vec4f(Vec3f(rest + rig.fingers[f].places[0]), 1)));
        if (!(view.z > 0) || !(points[f * kFingerPoints].confidence > 0)) return 1e9;
        sum += glm::length(camera.pixelOf(view) - points[f * kFingerPoints].px);
    }
    return sum / double(kHandFingers);
}

/** Whether what a frame calls the left hand is the right one. The body fit says so of whole pictures. A close-up may show a hand without
 *  its arm, so there a hand is that of the wrist at which it lies, if it is twice as near. */
bool isExchanged(const BodyModel& shaped, const std::array<std::optional<HandRig>, 2>& rigs, const ScanFrame& frame,
                 std::span<const Keypoint> points, const BodyFit& fit, size_t f) {
    constexpr double kClearly = 2;
    const bool swapped = f < fit.swapped.size() && (fit.swapped[f] & kUpperSwapped);
    if (frame.kind != FrameKind::StaticCloseup || !rigs[0] || !rigs[1]) return swapped;
    const Camerad camera = metricCamera(frame.camera, fit.metresPerUnit);
    double named = 0, exchanged = 0;  // sums over the hands that the frame shows
    for (size_t side = 0; side < 2; ++side) {
        const auto hand = points.subspan(side * kHandPoints, kHandPoints);
        if (!(hand[0].confidence > 0)) continue;
        for (size_t arm = 0; arm < 2; ++arm) {
            const HandRig& rig = *rigs[arm];
            (arm == side ? named : exchanged) +=
                missPx(hand, rig, worldFromWrist(shaped, rig, fit.poses[f]), Vec3d(shaped.joints[rig.wrist].restPosition), camera);
        }
    }
    if (kClearly * exchanged < named) return true;
    return kClearly * named < exchanged ? false : swapped;
}

/** One hand in all frames. */
class HandFitter {
public:
    /** `points`: of this hand, one list a frame. */
    HandFitter(const HandRig& rig, bool left, const BodyModel& shaped, const Scan& scan, std::span<const std::vector<Keypoint>> points,
               BodyFit& fit)
        : rig_(rig), scan_(scan), fit_(fit), frames_(scan.frames.size()) {
        found_.left = left;
        for (size_t f = 0; f < frames_.size(); ++f) look(f, shaped, points[f]);
        for (size_t f = 0; f < frames_.size(); ++f)
            if (frames_[f].seen) (isStill(f) ? found_.stillFrames : found_.movingFrames) += 1;
    }

    Result<HandFit> run() {
        DPL_RETURN_IF_ERROR(fitStill());
        for (const Split split : {Split::Train, Split::Validation, Split::Test}) DPL_RETURN_IF_ERROR(fitMoving(split));
        std::vector<double> px;
        for (size_t f = 0; f < frames_.size(); ++f)
            if (frames_[f].seen && (isStill(f) ? scan_.frames[f].split == Split::Train : frames_[f].posed)) measure(f, px);
        if (!px.empty()) {
            std::nth_element(px.begin(), px.begin() + std::ptrdiff_t(px.size() / 2), px.end());
            found_.medianPx = px[px.size() / 2];
        }
        write();
        rate();
        return found_;
    }

private:
    struct Frame {
        HandView view;
        bool seen = false, posed = false;  // posed: has turns of its own
        HandTurns turns{};
        std::array<double, kWristSize> wrist{};
    };

    bool isStill(size_t f) const { return scan_.frames[f].kind != FrameKind::Dynamic; }

    /** Decides whether a frame shows the hand well enough. A close-up may show a hand and too little of the body to fit it: then the still
     *  pose says where the hand is. */
    void look(size_t f, const BodyModel& shaped, const std::vector<Keypoint>& points) {
        if (points.empty() || (!fit_.fitted[f] && !isStill(f))) return;
        Frame& frame = frames_[f];
        std::copy(points.begin(), points.end(), frame.view.points.begin());
        size_t seen = 0;
        double confidence = 0;
        for (const Keypoint& k : frame.view.points)
            if (k.confidence > 0) ++seen, confidence += k.confidence;
        if (seen < kMinPoints || confidence < priors::kSureHand * double(seen)) return;
        const Mat3x4f wrist = worldFromWrist(shaped, rig_, fit_.poses[f]);
        frame.view.camera = metricCamera(scan_.frames[f].camera, fit_.metresPerUnit);
        frame.view.wristRotation = Mat3d(Vec3d(wrist[0]), Vec3d(wrist[1]), Vec3d(wrist[2]));
        frame.view.wrist = Vec3d(wrist * Vec4f(shaped.joints[rig_.wrist].restPosition, 1));
        const double depthM = frame.view.camera.toView(frame.view.wrist).z, lengthPx = frame.view.camera.fx * rig_.lengthM / depthM;
        frame.seen = depthM > 0 && lengthPx >= priors::kSmallestHandPx;
        frame.view.sigmaPx = scan_.keypointsFound
                                 ? priors::kFoundHandSigma * lengthPx
                                 : keypointSigma(scan_) * std::hypot(double(frame.view.camera.widthPx), double(frame.view.camera.heightPx));
    }

    Status solve(ceres::Problem& problem, const char* what, double outlierSigmas, double* cost = nullptr) {
        outlierSigmas_ = outlierSigmas;
        ceres::Solver::Summary summary;
        ceres::Solve(solverOptions(kSteps), &problem, &summary);
        if (!summary.IsSolutionUsable()) return fail(Code::Internal, "the finger fit failed in '{}': {}", what, summary.message);
        if (cost) *cost = summary.final_cost;
        return {};
    }

    /** Fits loosely, then as tightly as the body. */
    Status solveBoth(ceres::Problem& problem, const char* what, double* cost) {
        DPL_RETURN_IF_ERROR(solve(problem, what, kLooseOutliers));
        return solve(problem, what, priors::kKeypointOutlierSigmas, cost);
    }

    void addView(ceres::Problem& problem, size_t f, double* turns) {
        Frame& frame = frames_[f];
        auto* cost = new HandCost(rig_, frame.view, outlierSigmas_);
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<HandCost, ceres::DYNAMIC, int(kHandTurns), kWristSize>(cost, cost->residuals()), nullptr, turns,
            frame.wrist.data());
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<WristPriorCost, kWristSize, kWristSize>(new WristPriorCost), nullptr,
                                 frame.wrist.data());
    }

    void addPrior(ceres::Problem& problem, double* turns, const HandTurns& mean) {
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<FingerPriorCost, FingerPriorCost::kResiduals, int(kHandTurns)>(new FingerPriorCost{mean}),
            nullptr, turns);
        for (size_t t = 0; t < kHandTurns; ++t) {
            problem.SetParameterLowerBound(turns, int(t), rig_.low[t]);
            problem.SetParameterUpperBound(turns, int(t), rig_.high[t]);
        }
    }

    HandTurns curled() const {
        HandTurns turns{};
        for (size_t f = 1; f < kHandFingers; ++f)
            for (const FingerTurn t : {kBaseBend, kMiddleBend, kEndBend})
                turns[f * kFingerTurns + t] = kCurledShare * rig_.high[f * kFingerTurns + t];
        return turns;
    }

    /** Solves fingers that `frames` share, from each start and with the fingers held at `mean`; `best` gets the best. Returns how much less
     *  twice the negative log likelihood is with them than at `mean`. */
    Result<double> shared(const std::vector<size_t>& frames, const HandTurns& mean, std::span<const HandTurns> starts, const char* what,
                          HandTurns& best) {
        std::vector<std::array<double, kWristSize>> wrists;
        double heldCost = 0, bestCost = 0;
        const auto attempt = [&](HandTurns turns, bool held) -> Status {
            for (const size_t f : frames) frames_[f].wrist = {};
            ceres::Problem problem;
            addPrior(problem, turns.data(), mean);
            for (const size_t f : frames) addView(problem, f, turns.data());
            if (held) problem.SetParameterBlockConstant(turns.data());
            double cost = 0;
            DPL_RETURN_IF_ERROR(solveBoth(problem, what, &cost));
            if (held) heldCost = cost;
            if (!held && !wrists.empty() && cost >= bestCost) return {};
            if (!held) bestCost = cost, best = turns;
            wrists.clear();
            for (const size_t f : frames) wrists.push_back(frames_[f].wrist);
            return {};
        };
        for (const HandTurns& start : starts) DPL_RETURN_IF_ERROR(attempt(start, false));
        const auto found = wrists;
        DPL_RETURN_IF_ERROR(attempt(mean, true));
        const double gain = 2 * (heldCost - bestCost);
        if (gain >= priors::kFingerGain)
            for (size_t i = 0; i < frames.size(); ++i) frames_[frames[i]].wrist = found[i];
        return gain;
    }

    Status fitStill() {
        std::vector<size_t> frames;
        for (size_t f = 0; f < frames_.size(); ++f)
            if (frames_[f].seen && isStill(f) && scan_.frames[f].split == Split::Train) frames.push_back(f);
        if (frames.size() < kMinStillFrames) return {};
        DPL_RETURN_IF_ERROR(taskAt(0, "fingers of still frames"));
        HandTurns turns{};
        const HandTurns starts[] = {HandTurns{}, curled()};
        DPL_TRY(const double gain, shared(frames, HandTurns{}, starts, "fingers of still frames", turns));
        if (gain < priors::kFingerGain) return {};
        size_t strange = 0;
        for (const size_t f : frames) strange += isStrange(f, turns);
        if (2 * strange > frames.size()) return {};
        still_ = turns, found_.turned = true;
        return {};
    }

    Status fitMoving(Split split) {
        std::vector<size_t> order;  // with the neighbours of earlier splits, in time
        for (size_t f = 0; f < frames_.size(); ++f)
            if (frames_[f].seen && !isStill(f) && scan_.frames[f].split <= split) order.push_back(f);
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan_.frames[a].timeS < scan_.frames[b].timeS; });
        HandTurns before = still_;
        for (const size_t f : order) {
            Frame& frame = frames_[f];
            if (scan_.frames[f].split == split) {
                DPL_RETURN_IF_ERROR(taskAt(0.5, "fingers of moving frames"));
                const HandTurns starts[] = {still_, curled(), before};
                frame.turns = still_;
                DPL_TRY(const double gain, shared({f}, still_, starts, "fingers of a moving frame", frame.turns));
                frame.posed = gain >= priors::kFingerGain && !isStrange(f, frame.turns);
                if (!frame.posed) frame.turns = still_;
            }
            before = frame.turns;
        }
        DPL_RETURN_IF_ERROR(together(order, split));
        for (const size_t f : order)
            if (frames_[f].posed && isStrange(f, frames_[f].turns)) frames_[f].posed = false, frames_[f].turns = still_;
        return {};
    }

    /** Solves the frames of a split that have turns of their own, joined by their motion. All others are held. */
    Status together(const std::vector<size_t>& order, Split split) {
        ceres::Problem problem;
        const auto free = [&](size_t f) { return frames_[f].posed && scan_.frames[f].split == split; };
        if (std::none_of(order.begin(), order.end(), free)) return {};
        for (const size_t f : order) {
            if (!free(f)) continue;
            addPrior(problem, frames_[f].turns.data(), still_);
            addView(problem, f, frames_[f].turns.data());
        }
        const auto linked = [&](size_t a, size_t b) {
            const double step = scan_.frames[b].timeS - scan_.frames[a].timeS;
            return step > 1e-4 && step <= kMaxGapS;
        };
        for (size_t i = 1; i + 1 < order.size(); ++i) {
            const size_t a = order[i - 1], b = order[i], c = order[i + 1];
            if (!linked(a, b) || !linked(b, c) || (!free(a) && !free(b) && !free(c))) continue;
            problem.AddResidualBlock(
                new ceres::AutoDiffCostFunction<FingerSmoothness, int(kHandTurns), int(kHandTurns), int(kHandTurns), int(kHandTurns)>(
                    new FingerSmoothness{scan_.frames[b].timeS - scan_.frames[a].timeS, scan_.frames[c].timeS - scan_.frames[b].timeS}),
                nullptr, frames_[a].turns.data(), frames_[b].turns.data(), frames_[c].turns.data());
        }
        for (const size_t f : order)
            if (!free(f) && problem.HasParameterBlock(frames_[f].turns.data())) problem.SetParameterBlockConstant(frames_[f].turns.data());
        return solve(problem, "fingers of moving frames together", priors::kKeypointOutlierSigmas);
    }

    /** Residuals of a frame's points without a robust loss: px, and in standard deviations. */
    std::vector<double> residuals(size_t f, const HandTurns& turns) const {
        constexpr double kNoOutliers = 1e9;
        const HandCost cost(rig_, frames_[f].view, kNoOutliers);
        std::vector<double> values(size_t(cost.residuals()));
        cost(turns.data(), frames_[f].wrist.data(), values.data());
        return values;
    }

    /** Whether the points are no hand of this person: they lie too far from its wrist, or are no hand. */
    bool isStrange(size_t f, const HandTurns& turns) const {
        const auto& wrist = frames_[f].wrist;
        if (std::hypot(wrist[3], wrist[4], wrist[5]) > priors::kKeypointOutlierSigmas * priors::kWristShiftM) return true;
        const std::vector<double> values = residuals(f, turns);
        size_t far = 0;
        for (size_t i = 0; i + 1 < values.size(); i += 2) far += std::hypot(values[i], values[i + 1]) > priors::kKeypointOutlierSigmas;
        return 2 * double(far) > priors::kStrangeHand * double(values.size());
    }

    void measure(size_t f, std::vector<double>& px) const {
        const std::vector<double> values = residuals(f, isStill(f) ? still_ : frames_[f].turns);
        size_t i = 0;
        for (const Keypoint& k : frames_[f].view.points)
            if (k.confidence > 0) px.push_back(std::hypot(values[i], values[i + 1]) * frames_[f].view.sigmaPx / k.confidence), i += 2;
    }

    void write() {
        const auto anyTurn = [](const HandTurns& turns) { return turns != HandTurns{}; };
        if (anyTurn(still_)) setFingers(rig_, still_, fit_.staticPose);
        for (size_t f = 0; f < frames_.size(); ++f) {
            const HandTurns& turns = frames_[f].posed ? frames_[f].turns : still_;
            if (anyTurn(turns)) setFingers(rig_, turns, fit_.poses[f]);
            found_.posedFrames += frames_[f].posed;
        }
    }

    /** Of the frames with fingers that the fit turned and that explain its points. */
    void rate() {
        found_.precisions.resize(frames_.size());
        for (size_t f = 0; f < frames_.size(); ++f) {
            const HandTurns& turns = frames_[f].posed ? frames_[f].turns : still_;
            if (!frames_[f].seen || !(frames_[f].posed || found_.turned) || isStrange(f, turns)) continue;
            HandTurns prior;
            for (size_t t = 0; t < kHandTurns; ++t) prior[t] = frames_[f].posed ? spreadOfTurn(t) : priors::kSameHandRad;
            found_.precisions[f] = jointPrecision(rig_, turns, turnPrecision(rig_, frames_[f].view, turns, frames_[f].wrist, prior));
        }
    }

    const HandRig& rig_;
    const Scan& scan_;
    BodyFit& fit_;
    std::vector<Frame> frames_;
    HandTurns still_{};
    HandFit found_;
    double outlierSigmas_ = priors::kKeypointOutlierSigmas;
};

}  // namespace

Result<std::vector<HandFit>> fitFingers(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> hands,
                                        BodyFit& fit) {
    if (hands.size() != scan.frames.size() || fit.poses.size() != scan.frames.size())
        return fail(Code::InvalidArgument, "{} lists of hand keypoints and {} poses for {} frames", hands.size(), fit.poses.size(),
                    scan.frames.size());
    bool any = false;
    for (size_t f = 0; f < hands.size(); ++f) {
        if (hands[f].empty()) continue;
        any = true;
        if (hands[f].size() != 2 * kHandPoints)
            return fail(Code::InvalidArgument, "frame '{}' has {} keypoints of hands, not {}", scan.frames[f].name, hands[f].size(),
                        2 * kHandPoints);
        for (const Keypoint& k : hands[f])
            if (!(k.confidence >= 0) || (k.confidence > 0 && (!std::isfinite(k.px.x) || !std::isfinite(k.px.y))))
                return fail(Code::CorruptData, "frame '{}' has a keypoint of a hand that is not finite", scan.frames[f].name);
    }
    std::vector<HandFit> found;
    if (!any) return found;
    const BodyModel shaped = shapedBody(body, fit.shape);
    const std::array<std::optional<HandRig>, 2> rigs{handRig(shaped, true), handRig(shaped, false)};
    std::array<std::vector<std::vector<Keypoint>>, 2> points;  // of the left and the right hand
    for (auto& hand : points) hand.resize(hands.size());
    for (size_t f = 0; f < hands.size(); ++f) {
        if (hands[f].empty()) continue;
        const bool exchanged = isExchanged(shaped, rigs, scan.frames[f], hands[f], fit, f);
        const auto middle = hands[f].begin() + kHandPoints;
        points[exchanged].at(f).assign(hands[f].begin(), middle);
        points[!exchanged].at(f).assign(middle, hands[f].end());
    }
    for (size_t side = 0; side < 2; ++side) {
        if (!rigs[side]) continue;
        const TaskPart part(0.5 * double(side), 0.5 * double(side) + 0.5);
        DPL_TRY(const HandFit hand, HandFitter(*rigs[side], side == 0, shaped, scan, points[side], fit).run());
        found.push_back(hand);
    }
    return found;
}

std::string describeHand(const HandFit& hand) {
    const char* side = hand.left ? "left" : "right";
    if (hand.stillFrames + hand.movingFrames == 0) return formatText("no frame shows the {} hand well enough for its fingers", side);
    return formatText("fingers of the {} hand: {} in {} still frames, of their own in {} of {} moving frames", side,
                      hand.turned ? "turned" : "as the body has them", hand.stillFrames, hand.posedFrames, hand.movingFrames);
}

Result<std::vector<HandFit>> fitFingers(const BodyModel& body, const Scan& scan, BodyFit& fit) {
    std::vector<std::vector<Keypoint>> hands;
    for (const ScanFrame& frame : scan.frames) {
        DPL_TRY(auto points, readHandKeypoints(scan, frame));
        hands.push_back(std::move(points));
    }
    return fitFingers(body, scan, hands, fit);
}

}  // namespace dpl
