// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/fit_body.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "reconstruction/input/capture/triangulate.h"
#include "reconstruction/subject/body/body_fitter.h"
#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/body/fit_init.h"
#include "reconstruction/subject/body/fit_silhouette.h"
#include "reconstruction/subject/body/keypoint_noise.h"
#include "reconstruction/subject/body/landmark_offsets.h"
#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/body/stated_height.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr size_t kMinKeypoints = 6;    // a frame with fewer seen keypoints is not fitted
constexpr size_t kMinStillFrames = 3;  // with fewer still frames, the shape is solved with the moving frames
constexpr size_t kMaxMasks = 18, kSkinSamples = 900, kMinOutline = 20;
constexpr uint32_t kMaskSidePx = 512;
constexpr int kMaskRounds = 2;
constexpr double kConfident = 0.7;  // minimum confidence of keypoints in KindResidual

/** Reports progress after each solver step and stops the solver when the caller cancels. */
class Watcher final : public ceres::IterationCallback {
public:
    Watcher(const char* what, int maxSteps, double from, double to) : what_(what), maxSteps_(maxSteps), from_(from), to_(to) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
        goesOn = taskAt(from_ + (to_ - from_) * std::min(1.0, double(s.iteration) / maxSteps_), what_);
        return goesOn ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
    }
    Status goesOn;

private:
    const char* what_;
    int maxSteps_;
    double from_, to_;
};

}  // namespace

bool BodyFitter::usable(size_t f) const {
    size_t seen = 0;
    for (size_t k = 0; k < keypoints_[f].size(); ++k) seen += keypoints_[f][k].confidence > 0 && chain_.hasKeypoint(k);
    return seen >= kMinKeypoints;
}

std::vector<size_t> BodyFitter::select(FrameKind kind, Split split) const {
    std::vector<size_t> chosen;
    for (size_t f = 0; f < frames_.size(); ++f)
        if (scan_.frames[f].kind == kind && scan_.frames[f].split == split && usable(f)) chosen.push_back(f);
    return chosen;
}

std::vector<size_t> BodyFitter::movingInTime(Split knownTo) const {
    std::vector<size_t> order;
    for (size_t f = 0; f < frames_.size(); ++f)
        if (!isStill(f) && usable(f) && isKnownTo(knownTo, f)) order.push_back(f);
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan_.frames[a].timeS < scan_.frames[b].timeS; });
    return order;
}

Status BodyFitter::solve(ceres::Problem& problem, const char* what, int maxSteps, double from, double to) {
    Watcher watcher(what, maxSteps, from, to);
    ceres::Solver::Options options = solverOptions(maxSteps);
    options.callbacks.push_back(&watcher);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    solves_.push_back({what, std::string(ceres::TerminationTypeToString(summary.termination_type)) + ": " + summary.message,
                       summary.IsSolutionUsable(), int(summary.iterations.size()), summary.initial_cost, summary.final_cost});
    DPL_RETURN_IF_ERROR(watcher.goesOn);
    if (!summary.IsSolutionUsable()) return fail(Code::Internal, "the body fit failed in '{}': {}", what, summary.message);
    return {};
}

std::vector<double> BodyFitter::swaySigmas() const {
    std::vector<double> sigma = {priors::kSwayTurnRad, priors::kSwayTurnRad, priors::kSwayTurnRad,
                                 priors::kSwayM,       priors::kSwayM,       priors::kSwayM};
    for (uint32_t slot : context_.sway.slots) sigma.insert(sigma.end(), 3, priors_[slot].swayRad);
    return sigma;
}

void BodyFitter::addFrame(ceres::Problem& problem, size_t f) {
    FrameState& s = frames_[f];
    FrameState& base = isStill(f) ? still_ : s;
    auto* cost = new ReprojectionCost(context_, scan_.frames[f].camera, base.rootReference, keypoints_[f], sigmaPx(f), isStill(f));
    std::vector<double*> blocks = {shape_.data(), &logUnit_, base.root};
    addPoseBlocks(blocks, base.pose.data(), priors_.size());
    if (isStill(f)) {
        blocks.push_back(s.sway.data());
        const std::vector<double> sigma = swaySigmas();
        problem.AddResidualBlock(cost, nullptr, blocks);
        problem.AddResidualBlock(new DiagonalPrior(std::vector<double>(sigma.size(), 0.0), sigma), nullptr, s.sway.data());
    } else {
        problem.AddResidualBlock(cost, nullptr, blocks);
        addPosePrior(problem, priors_, shapeFromMoving_ ? std::vector<double>(s.pose.size(), 0.0) : still_.pose, s.pose.data());
        if (!shapeFromMoving_) {
            const Mat3d still = rotationOf({still_.root[0], still_.root[1], still_.root[2]}) * still_.rootReference;
            const Vec3d up = still * Vec3d(0, 1, 0);
            problem.AddResidualBlock(makeRootUpright(s.rootReference, Vec3d(0, 1, 0), up), nullptr, s.root);
        }
    }
    s.fitted = true;
}

void BodyFitter::addShapePriors(ceres::Problem& problem) {
    if (shape_.empty()) return;
    problem.AddResidualBlock(new ShapePrior(body_.morphs), nullptr, shape_.data());
    if (metric_ || !(scan_.subjectHeightM > 0)) return;
    if (ceres::CostFunction* height = makeStatedHeight(body_, scan_.subjectHeightM))
        problem.AddResidualBlock(height, nullptr, shape_.data());
}

void BodyFitter::addStillPriors(ceres::Problem& problem) {
    addPosePrior(problem, priors_, std::vector<double>(still_.pose.size(), 0.0), still_.pose.data());
    addShapePriors(problem);
}

void BodyFitter::freezeGlobals(ceres::Problem& problem) {
    for (double* block : {shape_.data(), &logUnit_, still_.root})
        if (problem.HasParameterBlock(block)) problem.SetParameterBlockConstant(block);
    holdPose(problem, still_.pose);
}

Status BodyFitter::start() {
    std::vector<KeypointView> views;
    std::vector<size_t> chosen = select(FrameKind::StaticFull, Split::Train);
    shapeFromMoving_ = chosen.size() < kMinStillFrames;
    if (shapeFromMoving_) {  // too few still frames: triangulate from moving ones, where the torso moves little enough for a first guess
        const auto moving = movingInTime(Split::Train);
        chosen.insert(chosen.end(), moving.begin(), moving.end());
    }
    for (size_t f : chosen) views.push_back({scan_.frames[f].camera, &keypoints_[f]});
    const auto points = triangulateKeypoints(views, scan_.keypointNames.size());
    DPL_TRY(FitStart start, startFromPoints(body_, chain_, scan_.keypointNames, points, metric_));
    const bool guessed = !scan_.unitStated && !(scan_.subjectHeightM > 0);
    if (guessed && std::abs(std::log(start.metresPerUnit)) < std::log(priors::kHumanSize)) {
        metric_ = true;
        DPL_TRY(start, startFromPoints(body_, chain_, scan_.keypointNames, points, metric_));
    }
    logUnit_ = std::log(start.metresPerUnit);
    still_.rootReference = start.rootReference;
    std::copy(start.root, start.root + kRootSize, still_.root);
    still_.pose = start.pose;
    for (FrameState& f : frames_) {
        f.rootReference = still_.rootReference;
        std::copy(still_.root, still_.root + kRootSize, f.root);
        f.pose = still_.pose;
    }
    return {};
}

Status BodyFitter::fitStill(double from, double to) {
    const std::vector<size_t> frames = select(FrameKind::StaticFull, Split::Train);
    if (frames.empty()) return {};
    for (int round = 0; round < 3; ++round) {  // root only; then pose; then pose and shape
        context_.outlierSigmas = round < 2 ? kLooseOutliers : settings_.outlierSigmas;
        ceres::Problem problem;
        for (size_t f : frames) addFrame(problem, f);
        addStillPriors(problem);
        if (metric_ || round < 2) problem.SetParameterBlockConstant(&logUnit_);
        if (round < 2 && !shape_.empty()) problem.SetParameterBlockConstant(shape_.data());
        if (round == 0) holdPose(problem, still_.pose);
        if (round < 2)
            for (size_t f : frames) problem.SetParameterBlockConstant(frames_[f].sway.data());
        const char* const names[3] = {"still frames: root", "still frames: pose", "still frames: shape, pose and sway"};
        const double span = (to - from) / 3;
        DPL_RETURN_IF_ERROR(solve(problem, names[round], round == 2 ? 60 : 25, from + span * round, from + span * (round + 1)));
    }
    return {};
}

/** Effective number of parameters that a still frame's own sway takes from its residuals: tr((JᵀJ + P)⁻¹ JᵀJ), with J the Jacobian of the
 *  weighted residuals and P the precision of the sway's prior. */
double BodyFitter::swayFreedom(size_t f) {
    const ReprojectionCost cost(context_, scan_.frames[f].camera, still_.rootReference, keypoints_[f], sigmaPx(f), true);
    const std::vector<double> sigma = swaySigmas();
    std::vector<double> residuals(size_t(cost.num_residuals()));
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(cost.num_residuals(), Eigen::Index(sigma.size()));
    std::vector<double*> blocks = {shape_.data(), &logUnit_, still_.root};
    addPoseBlocks(blocks, still_.pose.data(), priors_.size());
    blocks.push_back(frames_[f].sway.data());
    std::vector<double*> jacobians(blocks.size(), nullptr);
    jacobians.back() = jacobian.data();
    if (!cost.Evaluate(blocks.data(), residuals.data(), jacobians.data())) return 0;
    const Eigen::MatrixXd information = jacobian.transpose() * jacobian;
    Eigen::MatrixXd posterior = information;
    for (size_t i = 0; i < sigma.size(); ++i) posterior(Eigen::Index(i), Eigen::Index(i)) += 1 / (sigma[i] * sigma[i]);
    return posterior.ldlt().solve(information).trace();
}

/** Estimates where the detector sees each keypoint, with shape and still poses fixed, and moves the keypoints of the chain there. */
void BodyFitter::findLandmarks() {
    std::vector<LandmarkView> views;
    for (size_t f : select(FrameKind::StaticFull, Split::Train)) {
        const FrameState s = effective(f);
        LandmarkView view{metricCamera(scan_.frames[f].camera, std::exp(logUnit_)), sigmaPx(f), keypoints_[f], {}};
        chain_.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, view.posed);
        views.push_back(std::move(view));
    }
    if (views.size() < kMinStillFrames) return;
    const std::vector<Vec3d> further = estimateLandmarkOffsets(chain_, views, settings_.outlierSigmas);
    for (size_t k = 0; k < further.size(); ++k) chain_.setOffset(k, chain_.offset(k) + further[k]);
}

/** The detector's noise from the residuals of the still training frames, whose pose is known best. */
std::optional<KeypointNoise> BodyFitter::detectorNoise() {
    context_.outlierSigmas = settings_.outlierSigmas;
    std::vector<Vec2d> residuals;
    double freedom = 0;
    for (size_t f : select(FrameKind::StaticFull, Split::Train)) {
        const FrameState s = effective(f);
        KeypointChain::Output out;
        chain_.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, out);
        const Camerad camera = metricCamera(scan_.frames[f].camera, std::exp(logUnit_));
        const double diagonalPx = std::hypot(double(camera.widthPx), double(camera.heightPx));
        for (size_t k = 0; k < keypoints_[f].size(); ++k) {
            const Keypoint& seen = keypoints_[f][k];
            const Vec3d view = camera.toView(out.points[k]);
            if (!(seen.confidence > 0) || !chain_.hasKeypoint(k) || !(view.z > 0)) continue;
            residuals.push_back(seen.confidence / diagonalPx * (camera.pixelOf(view) - seen.px));
        }
        freedom += swayFreedom(f);
    }
    return estimateKeypointNoise(residuals, freedom, settings_.outlierSigmas);
}

/** Refines the shape with the masks' outlines, because weight and build show there and not in the joints. */
Status BodyFitter::refineShape(double from, double to) {
    const std::vector<size_t> frames = select(FrameKind::StaticFull, Split::Train);
    if (!settings_.useMasks || frames.size() < kMinStillFrames || shape_.empty()) return {};
    std::vector<size_t> masked;
    std::vector<MaskDistance> masks;
    masks.reserve(kMaxMasks);  // costs keep references: the vector must not reallocate
    const size_t stride = (frames.size() + kMaxMasks - 1) / kMaxMasks;
    for (size_t i = 0; i < frames.size(); i += stride) {
        if (scan_.frames[frames[i]].maskPath.empty()) continue;
        const auto image = readFrameMask(scan_.frames[frames[i]]);
        if (!image) continue;  // a missing or empty mask is skipped; the ingest check reports it
        auto distance = maskDistance(*image, kMaskSidePx);
        if (!distance) continue;
        masked.push_back(frames[i]);
        masks.push_back(std::move(*distance));
    }
    if (masked.size() < kMinStillFrames) return {};
    const SkinSamples samples = sampleSkin(body_, kSkinSamples);
    const KeypointChain skin(samples.body, samples.names, jointsOf(priors_));
    context_.outlierSigmas = settings_.outlierSigmas;
    for (int round = 0; round < kMaskRounds; ++round) {
        ceres::Problem problem;
        for (size_t f : frames) addFrame(problem, f);
        addStillPriors(problem);
        if (metric_) problem.SetParameterBlockConstant(&logUnit_);
        for (size_t i = 0; i < masked.size(); ++i) {
            const ScanFrame& frame = scan_.frames[masked[i]];
            const FrameState s = effective(masked[i]);
            KeypointChain::Output now;
            skin.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, now);
            auto outline = outlineSamples(samples, now, metricCamera(frame.camera, std::exp(logUnit_)), masks[i]);
            if (outline.size() < kMinOutline) continue;
            std::vector<double*> blocks = {shape_.data(), &logUnit_, still_.root};
            addPoseBlocks(blocks, still_.pose.data(), priors_.size());
            blocks.push_back(frames_[masked[i]].sway.data());
            problem.AddResidualBlock(new SilhouetteCost(context_, skin, frame.camera, still_.rootReference, masks[i], std::move(outline)),
                                     nullptr, blocks);
        }
        const double span = (to - from) / kMaskRounds;
        DPL_RETURN_IF_ERROR(solve(problem, "still frames: shape against masks", 15, from + span * round, from + span * (round + 1)));
    }
    return {};
}

/** Fits the sway of still frames that were not part of the shape and pose solve, then the poses of moving frames outside training. Each
 *  split is solved apart, because even an independent frame in the same problem would change when the solver stops. */
Status BodyFitter::fitUntrained(double from, double to) {
    context_.outlierSigmas = settings_.outlierSigmas;
    context_.footSigmaScale = 1;
    constexpr std::pair<Split, const char*> kSplits[] = {
        {Split::Train, "close-ups"}, {Split::Validation, "validation still frames"}, {Split::Test, "held-out still frames"}};
    const double fifth = (to - from) / 5;
    for (const auto& [split, what] : kSplits) {
        std::vector<size_t> stills = select(FrameKind::StaticCloseup, split);
        if (split != Split::Train) {
            const auto full = select(FrameKind::StaticFull, split);
            stills.insert(stills.end(), full.begin(), full.end());
        }
        if (stills.empty()) continue;
        ceres::Problem problem;
        for (size_t f : stills) addFrame(problem, f);
        freezeGlobals(problem);
        DPL_RETURN_IF_ERROR(solve(problem, what, 40, from, from + fifth));
    }
    DPL_RETURN_IF_ERROR(fitHeldOutMoving(Split::Validation, from + fifth, from + 3 * fifth));
    return fitHeldOutMoving(Split::Test, from + 3 * fifth, to);
}

FrameState BodyFitter::effective(size_t f) const {
    if (!isStill(f)) return frames_[f];
    FrameState s = still_;
    const std::vector<double>& sway = frames_[f].sway;
    for (size_t i = 0; i < kRootSize; ++i) s.root[i] += sway[i];
    for (size_t k = 0; k < context_.sway.slots.size(); ++k)
        for (size_t i = 0; i < 3; ++i) s.pose[3 * context_.sway.slots[k] + i] += sway[kRootSize + 3 * k + i];
    return s;
}

Pose BodyFitter::poseOf(const FrameState& s) const {
    const auto quaternion = [](const Mat3d& r) { return Quatf(glm::normalize(glm::quat_cast(r))); };
    Pose pose = Pose::rest(body_.joints.size());
    pose.localRotations[0] = quaternion(rotationOf({s.root[0], s.root[1], s.root[2]}) * s.rootReference);
    pose.rootTranslation = Vec3f(s.root[3], s.root[4], s.root[5]);
    for (size_t k = 0; k < priors_.size(); ++k)
        pose.localRotations[priors_[k].joint] = quaternion(rotationOf({s.pose[3 * k], s.pose[3 * k + 1], s.pose[3 * k + 2]}));
    return pose;
}

/** Interpolates a moving frame without keypoints between its neighbours in time, of the frames that it may know. */
void BodyFitter::interpolate(size_t f, BodyFit& fit) const {
    const double t = scan_.frames[f].timeS;
    std::optional<size_t> before, after;
    for (size_t g : movingInTime(scan_.frames[f].split)) {
        if (scan_.frames[g].timeS <= t)
            before = g;
        else if (!after)
            after = g;
    }
    if (!before && !after) return;
    if (!before) before = after;
    if (!after) after = before;
    const double t0 = scan_.frames[*before].timeS, t1 = scan_.frames[*after].timeS;
    const float u = float(t1 > t0 ? (t - t0) / (t1 - t0) : 0.0);
    for (size_t j = 0; j < body_.joints.size(); ++j)
        fit.poses[f].localRotations[j] = glm::slerp(fit.poses[*before].localRotations[j], fit.poses[*after].localRotations[j], u);
    fit.poses[f].rootTranslation = glm::mix(fit.poses[*before].rootTranslation, fit.poses[*after].rootTranslation, u);
}

std::optional<KindResidual> BodyFitter::residual(FrameKind kind, Split split) const {
    KindResidual r{kind, split};
    std::vector<double> px;
    for (size_t f : select(kind, split)) {
        if (!frames_[f].fitted) continue;
        ++r.frames;
        const FrameState s = effective(f);
        KeypointChain::Output out;
        chain_.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, out);
        const Camerad camera = metricCamera(scan_.frames[f].camera, std::exp(logUnit_));
        for (size_t k = 0; k < keypoints_[f].size(); ++k)
            if (keypoints_[f][k].confidence >= kConfident && chain_.hasKeypoint(k))
                px.push_back(glm::length(camera.pixelOf(camera.toView(out.points[k])) - keypoints_[f][k].px));
    }
    if (px.empty()) return std::nullopt;
    std::sort(px.begin(), px.end());
    r.keypoints = px.size();
    for (double p : px) r.meanPx += p / double(px.size());
    r.medianPx = px[px.size() / 2];
    r.p95Px = px[std::min(px.size() - 1, px.size() * 95 / 100)];
    return r;
}

BodyFit BodyFitter::collect() const {
    BodyFit fit;
    fit.shape = shape_;
    fit.metresPerUnit = std::exp(logUnit_);
    if (detectorNoise_) fit.keypointSigma = detectorNoise_->sigma, fit.outlierShare = detectorNoise_->outlierShare;
    for (size_t k = 0; k < chain_.keypointCount(); ++k)
        fit.landmarks.push_back({chain_.hasKeypoint(k) ? chain_.carrier(k) : 0, chain_.offset(k)});
    fit.staticPose = poseOf(still_);
    for (size_t f = 0; f < frames_.size(); ++f) {
        fit.poses.push_back(poseOf(effective(f)));
        fit.fitted.push_back(frames_[f].fitted);
    }
    for (size_t f = 0; f < frames_.size(); ++f)
        if (!isStill(f) && !frames_[f].fitted) interpolate(f, fit);
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic})
        for (const Split split : {Split::Train, Split::Validation, Split::Test})
            if (const auto r = residual(kind, split)) fit.residuals.push_back(*r);
    fit.solves = solves_;
    return fit;
}

Result<BodyFit> BodyFitter::run() {
    size_t known = 0;
    for (size_t k = 0; k < chain_.keypointCount(); ++k) known += chain_.hasKeypoint(k);
    if (known < kMinKeypoints)
        return fail(Code::InvalidArgument, "body '{}' has {} of the scan's keypoints; name its joints so that a humanoid can be recognised",
                    body_.name, known);
    DPL_RETURN_IF_ERROR(start());
    DPL_RETURN_IF_ERROR(fitStill(0.0, 0.3));
    DPL_RETURN_IF_ERROR(refineShape(0.3, 0.4));
    findLandmarks();
    detectorNoise_ = detectorNoise();
    DPL_RETURN_IF_ERROR(fitMoving(0.4, 0.88));
    DPL_RETURN_IF_ERROR(freeShakenHeads(0.88, 0.92));
    DPL_RETURN_IF_ERROR(fitUntrained(0.92, 1.0));
    return collect();
}

Camerad metricCamera(const Camerad& camera, double metresPerUnit) {
    Camerad c = camera;
    c.viewFromWorldTranslation *= metresPerUnit;
    return c;
}

Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints,
                        const BodyFitSettings& settings, uint32_t threads) {
    DPL_RETURN_IF_ERROR(checkBody(body));
    if (keypoints.size() != scan.frames.size())
        return fail(Code::InvalidArgument, "{} keypoint lists for {} frames", keypoints.size(), scan.frames.size());
    for (size_t f = 0; f < keypoints.size(); ++f) {
        if (!keypoints[f].empty() && keypoints[f].size() != scan.keypointNames.size())
            return fail(Code::InvalidArgument, "frame '{}' has {} keypoints, the scan names {}", scan.frames[f].name, keypoints[f].size(),
                        scan.keypointNames.size());
        for (const Keypoint& k : keypoints[f])
            if (!(k.confidence >= 0) || (k.confidence > 0 && (!std::isfinite(k.px.x) || !std::isfinite(k.px.y))))
                return fail(Code::CorruptData, "frame '{}' has a keypoint that is not finite", scan.frames[f].name);
    }
    const std::vector<uint8_t> swapped = swappedSides(scan, keypoints);
    std::vector<std::vector<Keypoint>> righted(keypoints.begin(), keypoints.end());
    for (size_t f = 0; f < righted.size(); ++f)
        if (swapped[f]) righted[f] = withSidesSwapped(righted[f], scan.keypointNames, swapped[f]);
    DPL_TRY(BodyFit fit, BodyFitter(body, scan, righted, settings, threads).run());
    fit.swapped = swapped;
    return fit;
}

Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, const BodyFitSettings& settings, uint32_t threads) {
    std::vector<std::vector<Keypoint>> keypoints;
    for (const ScanFrame& frame : scan.frames) {
        DPL_TRY(auto points, readKeypoints(scan, frame));
        keypoints.push_back(std::move(points));
    }
    return fitBody(body, scan, keypoints, settings, threads);
}

}  // namespace dpl
