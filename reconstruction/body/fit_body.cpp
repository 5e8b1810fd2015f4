#include "reconstruction/body/fit_body.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "reconstruction/body/body_tools.h"
#include "reconstruction/body/fit_limbs.h"
#include "reconstruction/body/fit_costs.h"
#include "reconstruction/body/fit_init.h"
#include "reconstruction/body/fit_silhouette.h"

namespace dpl {
namespace {

constexpr double kLooseOutliers = 40;           // Geman–McClure scale while poses are still coarse, σ
constexpr double kMaxGapS = 1.0;                // moving frames further apart than this are not smoothed over
constexpr size_t kMinKeypoints = 6;             // fewer seen keypoints in a frame: its pose is not fitted
constexpr size_t kMinStillFrames = 3;           // with fewer, shape is solved with the moving frames
constexpr double kSwayTurnRad = 0.01, kSwayM = 0.01;
constexpr size_t kMaxMasks = 18, kSkinSamples = 900, kMinOutline = 20;
constexpr uint32_t kMaskSidePx = 512;
constexpr int kMaskRounds = 2;
constexpr double kConfident = 0.7;              // keypoints counted in residual reports
constexpr double kFootSlideM = 0.0008, kFootSlideMS = 0.002;  // how far a standing foot moves between frames: at once, and a second
constexpr double kLooseFootScale = 5;
constexpr double kSameLimbM = 0.08;             // a depth choice nearer than this to the present arm or leg is the same one
constexpr int kUntangleRounds = 3;
constexpr double kTrackStepRad = 0.5, kTrackStepM = 0.3;  // spread of pose and root between moving frames, for the first guess only

/** The numbers of one frame. Still frames use only `sway`, on top of the shared still pose. */
struct FrameState {
    Mat3d rootReference{1};
    double root[kRootSize] = {};
    std::vector<double> pose, sway;
    bool fitted = false;
};

class Fitter {
public:
    Fitter(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints, const BodyFitSettings& settings)
        : body_(body), scan_(scan), keypoints_(keypoints), settings_(settings), priors_(posePriors(body)), chain_(body, scan.keypointNames, posed(priors_)) {
        context_.chain = &chain_;
        for (size_t s = 0; s < priors_.size(); ++s)
            if (priors_[s].swayRad > 0) context_.sway.slots.push_back(uint32_t(s));
        shape_.assign(chain_.shapeCount(), 0.0);
        frames_.resize(scan.frames.size());
        for (FrameState& f : frames_) f.pose.assign(3 * chain_.posedCount(), 0.0), f.sway.assign(size_t(context_.sway.size()), 0.0);
        still_.pose.assign(3 * chain_.posedCount(), 0.0);
    }

    Result<BodyFit> run();

private:
    static std::vector<uint32_t> posed(const std::vector<JointPrior>& priors) {
        std::vector<uint32_t> joints;
        for (const JointPrior& p : priors) joints.push_back(p.joint);
        return joints;
    }
    bool isStill(size_t f) const { return scan_.frames[f].kind != FrameKind::Dynamic; }
    bool isTrain(size_t f) const { return scan_.frames[f].split == Split::Train; }
    bool usable(size_t f) const;
    std::vector<size_t> select(FrameKind kind, Split split) const;
    std::vector<size_t> movingInTime(bool trainOnly) const;
    double sigmaPx(size_t f) const { return settings_.sigmaAtFullConfidence * std::hypot(double(scan_.frames[f].camera.widthPx), double(scan_.frames[f].camera.heightPx)); }

    Status start();
    Status solve(ceres::Problem& problem, const char* what, int maxSteps, double from, double to);
    void addFrame(ceres::Problem& problem, size_t f);
    void addSmoothness(ceres::Problem& problem, const std::vector<size_t>& order, const std::function<bool(size_t)>& involves);
    void addStillPriors(ceres::Problem& problem);
    void freezeGlobals(ceres::Problem& problem);
    Status fitStill(double from, double to);
    Status refineShape(double from, double to);
    void untangleLimbs(const std::vector<size_t>& order, const std::function<bool(size_t)>& mayChange);
    Status trackMoving(const std::vector<size_t>& order, double from, double to);
    Status fitMoving(double from, double to);
    Status fitTest(double from, double to);
    Status fitHeldOutMoving(double from, double to);
    FrameState effective(size_t f) const;
    Pose poseOf(const FrameState& s) const;
    void interpolate(size_t f, BodyFit& fit) const;
    std::optional<KindResidual> residual(FrameKind kind, Split split) const;
    BodyFit collect() const;

    const BodyModel& body_;
    const Scan& scan_;
    std::span<const std::vector<Keypoint>> keypoints_;
    const BodyFitSettings& settings_;
    std::vector<JointPrior> priors_;
    KeypointChain chain_;
    FitContext context_;
    std::vector<double> shape_;
    double logUnit_ = 0;
    FrameState still_;
    std::vector<FrameState> frames_;
    std::vector<SolveEnd> solves_;
    bool shapeFromMoving_ = false;
};

/** Reports steps and stops the solver when the caller says so. */
class Watcher final : public ceres::IterationCallback {
public:
    Watcher(const BodyFitSettings& settings, const char* what, int maxSteps, double from, double to) : settings_(settings), what_(what), maxSteps_(maxSteps), from_(from), to_(to) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
        if (settings_.progress && !settings_.progress(from_ + (to_ - from_) * std::min(1.0, double(s.iteration) / maxSteps_), what_)) cancelled = true;
        return cancelled ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
    }
    bool cancelled = false;

private:
    const BodyFitSettings& settings_;
    const char* what_;
    int maxSteps_;
    double from_, to_;
};

bool Fitter::usable(size_t f) const {
    size_t seen = 0;
    for (size_t k = 0; k < keypoints_[f].size(); ++k) seen += keypoints_[f][k].confidence > 0 && chain_.hasKeypoint(k);
    return seen >= kMinKeypoints;
}

std::vector<size_t> Fitter::select(FrameKind kind, Split split) const {
    std::vector<size_t> chosen;
    for (size_t f = 0; f < frames_.size(); ++f)
        if (scan_.frames[f].kind == kind && scan_.frames[f].split == split && usable(f)) chosen.push_back(f);
    return chosen;
}

std::vector<size_t> Fitter::movingInTime(bool trainOnly) const {
    std::vector<size_t> order;
    for (size_t f = 0; f < frames_.size(); ++f)
        if (!isStill(f) && usable(f) && (!trainOnly || isTrain(f))) order.push_back(f);
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return scan_.frames[a].timeS < scan_.frames[b].timeS; });
    return order;
}

Status Fitter::solve(ceres::Problem& problem, const char* what, int maxSteps, double from, double to) {
    Watcher watcher(settings_, what, maxSteps, from, to);
    ceres::Solver::Options options;
    options.num_threads = 1;                      // results feed on: the same bytes on every machine
    options.max_num_iterations = maxSteps;
    options.function_tolerance = 1e-6;            // of the cost; keypoint noise is far above what later steps gain
    options.logging_type = ceres::SILENT;
    options.callbacks.push_back(&watcher);
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    if (ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::EIGEN_SPARSE)) options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // no BLAS threads
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    solves_.push_back({what, std::string(ceres::TerminationTypeToString(summary.termination_type)) + ": " + summary.message, summary.IsSolutionUsable(), int(summary.iterations.size()), summary.initial_cost, summary.final_cost});
    if (watcher.cancelled) return fail(Code::Cancelled, "the body fit was cancelled");
    if (!summary.IsSolutionUsable()) return fail(Code::Internal, "the body fit failed in '{}': {}", what, summary.message);
    return {};
}

void Fitter::addFrame(ceres::Problem& problem, size_t f) {
    FrameState& s = frames_[f];
    FrameState& base = isStill(f) ? still_ : s;
    auto* cost = new ReprojectionCost(context_, scan_.frames[f].camera, base.rootReference, keypoints_[f], sigmaPx(f), isStill(f));
    std::vector<double*> blocks = {shape_.data(), &logUnit_, base.root, base.pose.data()};
    if (isStill(f)) {
        blocks.push_back(s.sway.data());
        std::vector<double> sigma = {kSwayTurnRad, kSwayTurnRad, kSwayTurnRad, kSwayM, kSwayM, kSwayM};
        for (uint32_t slot : context_.sway.slots) sigma.insert(sigma.end(), 3, priors_[slot].swayRad);
        problem.AddResidualBlock(cost, nullptr, blocks);
        problem.AddResidualBlock(new DiagonalPrior(std::vector<double>(sigma.size(), 0.0), sigma), nullptr, s.sway.data());
    } else {
        problem.AddResidualBlock(cost, nullptr, blocks);
        problem.AddResidualBlock(new PosePriorCost(priors_, shapeFromMoving_ ? std::vector<double>(s.pose.size(), 0.0) : still_.pose), nullptr, s.pose.data());
        if (!shapeFromMoving_) {
            const Mat3d still = rotationOf({still_.root[0], still_.root[1], still_.root[2]}) * still_.rootReference;
            const Vec3d up = still * Vec3d(0, 1, 0);
            problem.AddResidualBlock(makeRootUpright(s.rootReference, Vec3d(0, 1, 0), up), nullptr, s.root);
        }
    }
    s.fitted = true;
}

void Fitter::addSmoothness(ceres::Problem& problem, const std::vector<size_t>& order, const std::function<bool(size_t)>& involves) {
    const Vec3d up = rotationOf({still_.root[0], still_.root[1], still_.root[2]}) * still_.rootReference * Vec3d(0, 1, 0);
    std::vector<size_t> feet;
    for (size_t k = 0; k < scan_.keypointNames.size(); ++k)
        for (const char* name : {"ankle_l", "ankle_r", "toe_l", "toe_r"})
            if (scan_.keypointNames[k] == name && chain_.hasKeypoint(k)) feet.push_back(k);
    for (size_t i = 0; i + 1 < order.size() && !feet.empty(); ++i) {
        FrameState &a = frames_[order[i]], &b = frames_[order[i + 1]];
        const double step = scan_.frames[order[i + 1]].timeS - scan_.frames[order[i]].timeS;
        if (!(step > 1e-4) || step > kMaxGapS || (!involves(order[i]) && !involves(order[i + 1]))) continue;
        problem.AddResidualBlock(new FootRest(context_, feet, a.rootReference, b.rootReference, kFootSlideM + kFootSlideMS * step), nullptr, shape_.data(), a.root, a.pose.data(), b.root, b.pose.data());
    }
    for (size_t i = 1; i + 1 < order.size(); ++i) {
        const size_t f[3] = {order[i - 1], order[i], order[i + 1]};
        const double t[3] = {scan_.frames[f[0]].timeS, scan_.frames[f[1]].timeS, scan_.frames[f[2]].timeS};
        if (!(t[1] - t[0] > 1e-4) || !(t[2] - t[1] > 1e-4) || t[1] - t[0] > kMaxGapS || t[2] - t[1] > kMaxGapS) continue;
        if (!involves(f[0]) && !involves(f[1]) && !involves(f[2])) continue;
        FrameState &a = frames_[f[0]], &b = frames_[f[1]], &c = frames_[f[2]];
        problem.AddResidualBlock(new PoseSmoothness(priors_, t[0], t[1], t[2]), nullptr, a.pose.data(), b.pose.data(), c.pose.data());
        problem.AddResidualBlock(makeRootSmoothness({a.rootReference, b.rootReference, c.rootReference}, up, t[0], t[1], t[2]), nullptr, a.root, b.root, c.root);
    }
}

void Fitter::addStillPriors(ceres::Problem& problem) {
    problem.AddResidualBlock(new PosePriorCost(priors_, std::vector<double>(still_.pose.size(), 0.0)), nullptr, still_.pose.data());
    if (!shape_.empty()) problem.AddResidualBlock(new ShapePrior(body_.morphs), nullptr, shape_.data());
}

void Fitter::freezeGlobals(ceres::Problem& problem) {
    for (double* block : {shape_.data(), &logUnit_, still_.root, still_.pose.data()})
        if (problem.HasParameterBlock(block)) problem.SetParameterBlockConstant(block);
}

Status Fitter::start() {
    std::vector<KeypointView> views;
    std::vector<size_t> chosen = select(FrameKind::StaticFull, Split::Train);
    shapeFromMoving_ = chosen.size() < kMinStillFrames;
    if (shapeFromMoving_) {  // no still orbit: the torso moves little enough between moving frames for a first guess
        const auto moving = movingInTime(true);
        chosen.insert(chosen.end(), moving.begin(), moving.end());
    }
    for (size_t f : chosen) views.push_back({scan_.frames[f].camera, &keypoints_[f]});
    DPL_TRY(FitStart start, startFromPoints(body_, chain_, scan_.keypointNames, triangulateKeypoints(views, scan_.keypointNames.size()), scan_.metricWorld));
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

Status Fitter::fitStill(double from, double to) {
    const std::vector<size_t> frames = select(FrameKind::StaticFull, Split::Train);
    if (frames.empty()) return {};
    for (int round = 0; round < 3; ++round) {  // root alone, then the mean body's pose, then everything
        context_.outlierSigmas = round < 2 ? kLooseOutliers : settings_.outlierSigmas;
        ceres::Problem problem;
        for (size_t f : frames) addFrame(problem, f);
        addStillPriors(problem);
        if (scan_.metricWorld || round < 2) problem.SetParameterBlockConstant(&logUnit_);
        if (round < 2 && !shape_.empty()) problem.SetParameterBlockConstant(shape_.data());
        if (round == 0) problem.SetParameterBlockConstant(still_.pose.data());
        if (round < 2)
            for (size_t f : frames) problem.SetParameterBlockConstant(frames_[f].sway.data());
        const char* const names[3] = {"still frames: root", "still frames: pose", "still frames: shape, pose and sway"};
        const double span = (to - from) / 3;
        DPL_CHECK_OK(solve(problem, names[round], round == 2 ? 60 : 25, from + span * round, from + span * (round + 1)));
    }
    return {};
}

/** Shape again, now with the outline in the masks: weight and build show there, not in joints. */
Status Fitter::refineShape(double from, double to) {
    const std::vector<size_t> frames = select(FrameKind::StaticFull, Split::Train);
    if (!settings_.useMasks || frames.size() < kMinStillFrames || shape_.empty()) return {};
    std::vector<size_t> masked;
    std::vector<MaskDistance> masks;
    masks.reserve(kMaxMasks);  // costs keep references
    const size_t stride = (frames.size() + kMaxMasks - 1) / kMaxMasks;
    for (size_t i = 0; i < frames.size(); i += stride) {
        if (scan_.frames[frames[i]].maskPath.empty()) continue;
        const auto image = readFrameMask(scan_.frames[frames[i]]);
        if (!image) continue;  // a missing or empty mask costs evidence, not the fit; the scan check has named it
        auto distance = maskDistance(*image, kMaskSidePx);
        if (!distance) continue;
        masked.push_back(frames[i]);
        masks.push_back(std::move(*distance));
    }
    if (masked.size() < kMinStillFrames) return {};
    const SkinSamples samples = sampleSkin(body_, kSkinSamples);
    const KeypointChain skin(samples.body, samples.names, posed(priors_));
    context_.outlierSigmas = settings_.outlierSigmas;
    for (int round = 0; round < kMaskRounds; ++round) {
        ceres::Problem problem;
        for (size_t f : frames) addFrame(problem, f);
        addStillPriors(problem);
        if (scan_.metricWorld) problem.SetParameterBlockConstant(&logUnit_);
        for (size_t i = 0; i < masked.size(); ++i) {
            const ScanFrame& frame = scan_.frames[masked[i]];
            const FrameState s = effective(masked[i]);
            KeypointChain::Output now;
            skin.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, now);
            auto outline = outlineSamples(samples, now, metricCamera(frame.camera, std::exp(logUnit_)), masks[i]);
            if (outline.size() < kMinOutline) continue;
            problem.AddResidualBlock(new SilhouetteCost(context_, skin, frame.camera, still_.rootReference, masks[i], std::move(outline)), nullptr, shape_.data(), &logUnit_, still_.root, still_.pose.data(),
                                     frames_[masked[i]].sway.data());
        }
        const double span = (to - from) / kMaskRounds;
        DPL_CHECK_OK(solve(problem, "still frames: shape against masks", 15, from + span * round, from + span * (round + 1)));
    }
    return {};
}

Status Fitter::trackMoving(const std::vector<size_t>& order, double from, double to) {
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
        problem.AddResidualBlock(new DiagonalPrior(std::vector<double>(s.root, s.root + kRootSize), {kTrackStepRad, kTrackStepRad, kTrackStepRad, kTrackStepM, kTrackStepM, kTrackStepM}), nullptr, s.root);
        DPL_CHECK_OK(solve(problem, "moving frames: first guess", 25, from + (to - from) * double(i) / double(order.size()), from + (to - from) * double(i + 1) / double(order.size())));
        if (solves_.size() > 1 && solves_[solves_.size() - 2].what == solves_.back().what) {  // one line for the whole track
            SolveEnd& total = solves_[solves_.size() - 2];
            total.steps += solves_.back().steps, total.costBefore += solves_.back().costBefore, total.costAfter += solves_.back().costAfter, total.how = solves_.back().how;
            solves_.pop_back();
        }
        previous = &s;
    }
    return {};
}

/** Moves arms and legs of the moving frames to the best chain of depth choices, where that is somewhere else. */
void Fitter::untangleLimbs(const std::vector<size_t>& order, const std::function<bool(size_t)>& mayChange) {
    struct Limb {
        const char *upper, *lower, *end, *middleKeypoint, *endKeypoint;
        double maxBackward;
    };
    constexpr Limb kLimbs[] = {{"leftUpperArm", "leftLowerArm", "leftHand", "elbow_l", "wrist_l", 0.25},
                               {"rightUpperArm", "rightLowerArm", "rightHand", "elbow_r", "wrist_r", 0.25},
                               {"leftUpperLeg", "leftLowerLeg", "leftFoot", "knee_l", "ankle_l", 0.7},
                               {"rightUpperLeg", "rightLowerLeg", "rightFoot", "knee_r", "ankle_r", 0.7}};
    const auto keypoint = [&](const char* name) { return size_t(std::find(scan_.keypointNames.begin(), scan_.keypointNames.end(), name) - scan_.keypointNames.begin()); };
    const auto slotOf = [&](int32_t joint) { return size_t(std::find(chain_.posedJoints().begin(), chain_.posedJoints().end(), uint32_t(joint)) - chain_.posedJoints().begin()); };
    for (const Limb& limb : kLimbs) {
        const int32_t upper = findHumanoid(body_, limb.upper), lower = findHumanoid(body_, limb.lower), end = findHumanoid(body_, limb.end);
        const size_t middleKeypoint = keypoint(limb.middleKeypoint), endKeypoint = keypoint(limb.endKeypoint), names = scan_.keypointNames.size();
        if (upper <= 0 || lower <= 0 || end <= 0 || middleKeypoint == names || endKeypoint == names) continue;
        const size_t upperSlot = slotOf(upper), lowerSlot = slotOf(lower);
        if (upperSlot == priors_.size() || lowerSlot == priors_.size()) continue;
        const auto rest = [&](int32_t joint) { return chain_.restPlace(size_t(joint), shape_.data()); };
        LimbRig rig;
        rig.upperM = glm::length(rest(lower) - rest(upper));
        rig.lowerM = glm::length(rest(end) - rest(lower));
        if (!(rig.upperM > 1e-3) || !(rig.lowerM > 1e-3)) continue;
        rig.upperDirection = (rest(lower) - rest(upper)) / rig.upperM;
        const Vec3d lowerDirection = (rest(end) - rest(lower)) / rig.lowerM, hinge = priors_[lowerSlot].axes[0];
        rig.hingeAxis = glm::normalize(hinge - glm::dot(hinge, rig.upperDirection) * rig.upperDirection);
        rig.restBendRad = std::atan2(glm::dot(glm::cross(rig.upperDirection, lowerDirection), rig.hingeAxis), glm::dot(rig.upperDirection, lowerDirection));
        rig.shoulderAxes = priors_[upperSlot].axes;
        rig.shoulderSigma = priors_[upperSlot].sigmaRad;
        rig.maxBackward = limb.maxBackward;
        rig.shoulderTail = priors_[upperSlot].tailSigmas;
        rig.bendSigma = priors_[lowerSlot].sigmaRad[0];
        rig.bendTail = priors_[lowerSlot].tailSigmas[0];
        if (!shapeFromMoving_) {
            rig.shoulderMean = glm::transpose(rig.shoulderAxes) * Vec3d(still_.pose[3 * upperSlot], still_.pose[3 * upperSlot + 1], still_.pose[3 * upperSlot + 2]);
            rig.bendMean = glm::dot(hinge, Vec3d(still_.pose[3 * lowerSlot], still_.pose[3 * lowerSlot + 1], still_.pose[3 * lowerSlot + 2]));
        }
        rig.shoulderLow = priors_[upperSlot].lowRad;
        rig.shoulderHigh = priors_[upperSlot].highRad;
        std::vector<LimbView> views;
        std::vector<KeypointChain::Output> now(order.size());
        for (size_t i = 0; i < order.size(); ++i) {
            const size_t f = order[i];
            const FrameState& s = frames_[f];
            chain_.evaluate(s.rootReference, s.root, s.pose.data(), shape_.data(), false, now[i]);
            views.push_back({scan_.frames[f].timeS, metricCamera(scan_.frames[f].camera, std::exp(logUnit_)), keypoints_[f][middleKeypoint], keypoints_[f][endKeypoint],
                             now[i].places[size_t(upper)], now[i].rotations[size_t(body_.joints[size_t(upper)].parent)]});
        }
        const auto guesses = untangleLimb(rig, views);
        for (size_t i = 0; i < order.size(); ++i) {
            if (!guesses[i] || !mayChange(order[i])) continue;
            const double moved = std::max(glm::length(guesses[i]->elbow - now[i].places[size_t(lower)]), glm::length(guesses[i]->wrist - now[i].places[size_t(end)]));
            if (moved < kSameLimbM) continue;
            std::vector<double>& pose = frames_[order[i]].pose;
            const Vec3d bend = guesses[i]->bendRad * hinge;
            for (int a = 0; a < 3; ++a) pose[3 * upperSlot + size_t(a)] = guesses[i]->shoulder[a], pose[3 * lowerSlot + size_t(a)] = bend[a];
        }
    }
}

Status Fitter::fitMoving(double from, double to) {
    const std::vector<size_t> order = movingInTime(true);
    if (order.empty()) return {};
    const double part = (to - from) / (2 + 2 * kUntangleRounds);
    double done = from;
    const auto together = [&](const char* what, bool loose, int maxSteps) -> Status {
        context_.outlierSigmas = loose ? kLooseOutliers : settings_.outlierSigmas;
        context_.footSigmaScale = loose ? kLooseFootScale : 1;
        ceres::Problem problem;
        for (size_t f : order) addFrame(problem, f);
        addSmoothness(problem, order, [](size_t) { return true; });
        if (shapeFromMoving_ && !shape_.empty()) problem.AddResidualBlock(new ShapePrior(body_.morphs), nullptr, shape_.data());
        if (!shapeFromMoving_) freezeGlobals(problem);
        else if (scan_.metricWorld) problem.SetParameterBlockConstant(&logUnit_);
        done += part;
        return solve(problem, what, maxSteps, done - part, done);
    };
    DPL_CHECK_OK(trackMoving(order, from, from + part));
    done = from + part;
    DPL_CHECK_OK(together("moving frames: together, loose", true, 12));
    // Better shoulders and hips make better depth choices: untangle again while that lowers the final cost, and keep the best.
    struct Best {
        std::vector<FrameState> frames;
        std::vector<double> shape;
        double logUnit = 0, cost = 0;
    };
    std::optional<Best> best;
    for (int round = 0; round < kUntangleRounds; ++round) {
        untangleLimbs(order, [](size_t) { return true; });
        DPL_CHECK_OK(together("moving frames: limbs untangled", true, 50));
        DPL_CHECK_OK(together("moving frames: together", false, 50));
        const double cost = solves_.back().costAfter;
        if (best && cost >= best->cost * (1 - 1e-4)) break;
        best = Best{frames_, shape_, logUnit_, cost};
    }
    std::copy(best->shape.begin(), best->shape.end(), shape_.begin());
    logUnit_ = best->logUnit;
    frames_ = std::move(best->frames);
    return {};
}

/** Still frames that had no say in shape and pose add their own sway. Held-out frames are solved apart from train close-ups: even an
 *  independent frame in the same problem would change when the solver stops. */
Status Fitter::fitTest(double from, double to) {
    context_.outlierSigmas = settings_.outlierSigmas;
    context_.footSigmaScale = 1;
    const double third = (to - from) / 3;
    for (const Split split : {Split::Train, Split::Test}) {
        std::vector<size_t> stills = select(FrameKind::StaticCloseup, split);
        if (split == Split::Test) {
            const auto full = select(FrameKind::StaticFull, split);
            stills.insert(stills.end(), full.begin(), full.end());
        }
        if (stills.empty()) continue;
        ceres::Problem problem;
        for (size_t f : stills) addFrame(problem, f);
        freezeGlobals(problem);
        const bool train = split == Split::Train;
        DPL_CHECK_OK(solve(problem, train ? "close-ups" : "held-out still frames", 40, train ? from : from + third, train ? from + third : from + 2 * third));
    }
    return fitHeldOutMoving(from + 2 * third, to);
}

/** Poses of held-out moving frames, each from its own keypoints between frozen train neighbours. */
Status Fitter::fitHeldOutMoving(double from, double to) {
    const std::vector<size_t> order = movingInTime(false);
    const auto isTest = [&](size_t f) { return !isTrain(f); };
    if (std::none_of(order.begin(), order.end(), isTest)) return {};
    for (size_t f : order) {  // start from the nearest train neighbour in time
        if (!isTest(f)) continue;
        const FrameState* nearest = nullptr;
        double distance = 0;
        for (size_t g : order)
            if (const double d = std::abs(scan_.frames[g].timeS - scan_.frames[f].timeS); isTrain(g) && (!nearest || d < distance)) nearest = &frames_[g], distance = d;
        if (!nearest) continue;
        FrameState& s = frames_[f];
        s.rootReference = nearest->rootReference;
        std::copy(nearest->root, nearest->root + kRootSize, s.root);
        s.pose = nearest->pose;
    }
    for (int round = 0; round < 2; ++round) {
        context_.outlierSigmas = round == 0 ? kLooseOutliers : settings_.outlierSigmas;
        context_.footSigmaScale = round == 0 ? kLooseFootScale : 1;
        if (round == 1) untangleLimbs(order, isTest);
        ceres::Problem problem;
        for (size_t f : order)
            if (isTest(f)) addFrame(problem, f);
        addSmoothness(problem, order, isTest);
        freezeGlobals(problem);
        for (size_t g : order)
            if (isTrain(g))
                for (double* block : {frames_[g].root, frames_[g].pose.data()})
                    if (problem.HasParameterBlock(block)) problem.SetParameterBlockConstant(block);
        const double half = 0.5 * (to - from);
        DPL_CHECK_OK(solve(problem, round == 0 ? "held-out moving frames, loose" : "held-out moving frames", 40, from + half * round, from + half * (round + 1)));
    }
    return {};
}

FrameState Fitter::effective(size_t f) const {
    if (!isStill(f)) return frames_[f];
    FrameState s = still_;
    const std::vector<double>& sway = frames_[f].sway;
    for (size_t i = 0; i < kRootSize; ++i) s.root[i] += sway[i];
    for (size_t k = 0; k < context_.sway.slots.size(); ++k)
        for (size_t i = 0; i < 3; ++i) s.pose[3 * context_.sway.slots[k] + i] += sway[kRootSize + 3 * k + i];
    return s;
}

Pose Fitter::poseOf(const FrameState& s) const {
    const auto quaternion = [](const Mat3d& r) { return Quatf(glm::normalize(glm::quat_cast(r))); };
    Pose pose = Pose::rest(body_.joints.size());
    pose.localRotations[0] = quaternion(rotationOf({s.root[0], s.root[1], s.root[2]}) * s.rootReference);
    pose.rootTranslation = Vec3f(s.root[3], s.root[4], s.root[5]);
    for (size_t k = 0; k < priors_.size(); ++k) pose.localRotations[priors_[k].joint] = quaternion(rotationOf({s.pose[3 * k], s.pose[3 * k + 1], s.pose[3 * k + 2]}));
    return pose;
}

/** A moving frame without keypoints of its own lies between its neighbours in time; a train frame only between train frames. */
void Fitter::interpolate(size_t f, BodyFit& fit) const {
    const double t = scan_.frames[f].timeS;
    std::optional<size_t> before, after;
    for (size_t g : movingInTime(isTrain(f))) {
        if (scan_.frames[g].timeS <= t) before = g;
        else if (!after) after = g;
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

std::optional<KindResidual> Fitter::residual(FrameKind kind, Split split) const {
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
            if (keypoints_[f][k].confidence >= kConfident && chain_.hasKeypoint(k)) px.push_back(glm::length(camera.pixelOf(camera.toView(out.points[k])) - keypoints_[f][k].px));
    }
    if (px.empty()) return std::nullopt;
    std::sort(px.begin(), px.end());
    r.keypoints = px.size();
    for (double p : px) r.meanPx += p / double(px.size());
    r.medianPx = px[px.size() / 2];
    r.p95Px = px[std::min(px.size() - 1, px.size() * 95 / 100)];
    return r;
}

BodyFit Fitter::collect() const {
    BodyFit fit;
    fit.shape = shape_;
    fit.metresPerUnit = std::exp(logUnit_);
    fit.staticPose = poseOf(still_);
    for (size_t f = 0; f < frames_.size(); ++f) {
        fit.poses.push_back(poseOf(effective(f)));
        fit.fitted.push_back(frames_[f].fitted);
    }
    for (size_t f = 0; f < frames_.size(); ++f)
        if (!isStill(f) && !frames_[f].fitted) interpolate(f, fit);
    for (const FrameKind kind : {FrameKind::StaticFull, FrameKind::StaticCloseup, FrameKind::Dynamic})
        for (const Split split : {Split::Train, Split::Test})
            if (const auto r = residual(kind, split)) fit.residuals.push_back(*r);
    fit.solves = solves_;
    return fit;
}

Result<BodyFit> Fitter::run() {
    size_t known = 0;
    for (size_t k = 0; k < chain_.keypointCount(); ++k) known += chain_.hasKeypoint(k);
    if (known < kMinKeypoints) return fail(Code::InvalidArgument, "body '{}' has {} of the scan's keypoints; name its joints so that a humanoid can be recognised", body_.name, known);
    DPL_CHECK_OK(start());
    DPL_CHECK_OK(fitStill(0.0, 0.3));
    DPL_CHECK_OK(refineShape(0.3, 0.4));
    DPL_CHECK_OK(fitMoving(0.4, 0.9));
    DPL_CHECK_OK(fitTest(0.9, 1.0));
    return collect();
}

}  // namespace

Camerad metricCamera(const Camerad& camera, double metresPerUnit) {
    Camerad c = camera;
    c.viewFromWorldTranslation *= metresPerUnit;
    return c;
}

Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints, const BodyFitSettings& settings) {
    DPL_CHECK_OK(checkBody(body));
    if (keypoints.size() != scan.frames.size()) return fail(Code::InvalidArgument, "{} keypoint lists for {} frames", keypoints.size(), scan.frames.size());
    for (size_t f = 0; f < keypoints.size(); ++f) {
        if (!keypoints[f].empty() && keypoints[f].size() != scan.keypointNames.size())
            return fail(Code::InvalidArgument, "frame '{}' has {} keypoints, the scan names {}", scan.frames[f].name, keypoints[f].size(), scan.keypointNames.size());
        for (const Keypoint& k : keypoints[f])
            if (!(k.confidence >= 0) || (k.confidence > 0 && (!std::isfinite(k.px.x) || !std::isfinite(k.px.y)))) return fail(Code::CorruptData, "frame '{}' has a keypoint that is not finite", scan.frames[f].name);
    }
    return Fitter(body, scan, keypoints, settings).run();
}

Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, const BodyFitSettings& settings) {
    std::vector<std::vector<Keypoint>> keypoints;
    for (const ScanFrame& frame : scan.frames) {
        DPL_TRY(auto points, readKeypoints(scan, frame));
        keypoints.push_back(std::move(points));
    }
    return fitBody(body, scan, keypoints, settings);
}

}  // namespace dpl
