// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/frame_poses.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "reconstruction/subject/body/motion_terms.h"
#include "reconstruction/subject/body/priors.h"
#include "reconstruction/subject/registration/priors.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr double kNoSwayRad = 1e-4;  // of joints that do not sway
constexpr float kAtRest = 1e-6f;     // sine of half an angle that is nothing but rounding

Mat3d matrixOf(const Quatf& q) {
    return glm::mat3_cast(glm::normalize(Quatd(q)));
}

BodyModel withoutMorphs(BodyModel body) {
    body.morphs.clear();
    return body;
}

}  // namespace

FramePoses::FramePoses(const RegisterInput& input)
    : input_(input), body_(withoutMorphs(*input.body)), priors_(posePriors(body_)), chain_(body_, input.keypointNames, jointsOf(priors_)) {
    context_.chain = &chain_;
    context_.outlierSigmas = priors::kKeypointOutlierSigmas;
    for (size_t k = 0; k < input.landmarks.size(); ++k) chain_.setOffset(k, input.landmarks[k].offset);
    stillPose_ = parametersOf(input.stillPose);
    still_ = matrixOf(input.stillPose.localRotations[0]);
    states_.resize(input.frames.size());
    for (size_t f = 0; f < input.frames.size(); ++f) {
        const Pose& pose = input.frames[f].pose;
        states_[f].reference = matrixOf(pose.localRotations[0]);
        for (int a = 0; a < 3; ++a) states_[f].root[3 + a] = pose.rootTranslation[a];
        states_[f].pose = parametersOf(pose);
        states_[f].held = heldOf(pose);
        if (input.frames[f].kind == FrameKind::Dynamic) order_.push_back(f);
    }
    std::stable_sort(order_.begin(), order_.end(), [&](size_t a, size_t b) { return input.frames[a].timeS < input.frames[b].timeS; });
}

std::vector<size_t> FramePoses::movingInTime(Split split) const {
    std::vector<size_t> frames;
    std::copy_if(order_.begin(), order_.end(), std::back_inserter(frames), [&](size_t f) { return input_.frames[f].split == split; });
    return frames;
}

std::vector<Mat3d> FramePoses::heldOf(const Pose& pose) const {
    std::vector<Mat3d> held;
    for (size_t j = 1; j < pose.localRotations.size(); ++j) {
        const Quatf& turn = pose.localRotations[j];
        if (chain_.columnOf(j) >= 0 || glm::length(Vec3f(turn.x, turn.y, turn.z)) < kAtRest) continue;
        held.resize(pose.localRotations.size(), Mat3d(1));
        held[j] = matrixOf(pose.localRotations[j]);
    }
    return held;
}

std::vector<double> FramePoses::parametersOf(const Pose& pose) const {
    std::vector<double> values;
    for (const JointPrior& p : priors_) {
        const Vec3d w = rotationVector(matrixOf(pose.localRotations[p.joint]));
        values.insert(values.end(), {w.x, w.y, w.z});
    }
    return values;
}

Pose FramePoses::pose(size_t frame) const {
    const State& s = states_[frame];
    const auto quaternion = [](const Mat3d& r) { return Quatf(glm::normalize(glm::quat_cast(r))); };
    Pose pose = input_.frames[frame].pose;
    pose.localRotations[0] = quaternion(rotationOf({s.root[0], s.root[1], s.root[2]}) * s.reference);
    pose.rootTranslation = Vec3f(s.root[3], s.root[4], s.root[5]);
    for (size_t k = 0; k < priors_.size(); ++k)
        pose.localRotations[priors_[k].joint] = quaternion(rotationOf({s.pose[3 * k], s.pose[3 * k + 1], s.pose[3 * k + 2]}));
    return pose;
}

std::vector<std::vector<size_t>> FramePoses::doubtedRuns(size_t index, Split split) const {
    std::vector<std::vector<size_t>> runs(1);
    const auto limb = knownLimb(limbModel(), index);
    if (!limb) return {};
    KeypointChain::Output posed;
    double lastS = 0;
    for (const size_t f : order_) {
        const RegisterFrame& frame = input_.frames[f];
        if (frame.split != split) continue;
        bool doubted = showsLimb(*limb, frame.keypoints);
        if (doubted) {
            const State& s = states_[f];
            chain_.evaluate(s.reference, s.root, s.pose.data(), &noShape_, false, posed);
            double most = 0;
            for (const size_t k : {limb->middleKeypoint, limb->endKeypoint}) {
                const Vec3d view = frame.camera.toView(posed.points[k]);
                const Keypoint& keypoint = frame.keypoints[k];
                if (view.z > kNearM)
                    most = std::max(most, keypoint.confidence * glm::length(frame.camera.pixelOf(view) - keypoint.px) / sigmaPx(frame));
            }
            doubted = most > priors::kLimbDoubtSigmas;
        }
        if (!runs.back().empty() && (!doubted || frame.timeS - lastS > kMaxGapS)) runs.emplace_back();
        if (doubted) runs.back().push_back(f);
        lastS = frame.timeS;
    }
    if (runs.back().empty()) runs.pop_back();
    return runs;
}

LimbFrame FramePoses::limbFrame(size_t f) {
    const RegisterFrame& frame = input_.frames[f];
    State& s = states_[f];
    return {frame.timeS, frame.camera, frame.keypoints, &s.reference, s.root, &s.pose};
}

void FramePoses::bendLimb(size_t index, std::span<const size_t> frames, size_t candidate) {
    const auto limb = knownLimb(limbModel(), index);
    for (const size_t f : frames) {
        const LimbFrame frame = limbFrame(f);
        setLimb(*limb, limbCandidates(limbModel(), *limb, frame)[candidate], *frame.pose);
    }
}

std::vector<double> FramePoses::parameters() const {
    std::vector<double> values;
    for (const State& s : states_) {
        values.insert(values.end(), s.root, s.root + kRootSize);
        values.insert(values.end(), s.pose.begin(), s.pose.end());
    }
    return values;
}

void FramePoses::setParameters(std::span<const double> values) {
    for (State& s : states_) {
        std::copy_n(values.begin(), kRootSize, s.root);
        std::copy_n(values.begin() + kRootSize, s.pose.size(), s.pose.begin());
        values = values.subspan(kRootSize + s.pose.size());
    }
}

void FramePoses::addKeypoints(ceres::Problem& problem, size_t f) {
    const RegisterFrame& frame = input_.frames[f];
    State& s = states_[f];
    if (std::none_of(frame.keypoints.begin(), frame.keypoints.end(), [](const Keypoint& k) { return k.confidence > 0; })) return;
    const std::vector<Keypoint> keypoints(frame.keypoints.begin(), frame.keypoints.end());
    std::vector<double*> blocks = {&noShape_, &logUnit_, s.root};
    addPoseBlocks(blocks, s.pose.data(), priors_.size());
    problem.AddResidualBlock(new ReprojectionCost(context_, frame.camera, s.reference, keypoints, sigmaPx(frame), false), nullptr, blocks);
}

/** The prior of a still frame: its pose sways about the shared still pose. */
void FramePoses::addSway(ceres::Problem& problem, size_t f) {
    State& s = states_[f];
    const Vec3d turn = rotationVector(still_ * glm::transpose(s.reference)), at(input_.stillPose.rootTranslation);
    std::vector<double> poseSigma;
    for (const JointPrior& p : priors_) poseSigma.insert(poseSigma.end(), 3, std::max(p.swayRad, kNoSwayRad));
    problem.AddResidualBlock(
        new DiagonalPrior({turn.x, turn.y, turn.z, at.x, at.y, at.z}, {priors::kSwayTurnRad, priors::kSwayTurnRad, priors::kSwayTurnRad,
                                                                       priors::kSwayM, priors::kSwayM, priors::kSwayM}),
        nullptr, s.root);
    addDiagonalPosePrior(problem, stillPose_, poseSigma, s.pose.data());
}

/** The priors of a moving frame by itself. */
void FramePoses::addStandingPriors(ceres::Problem& problem, size_t f) {
    State& s = states_[f];
    addPosePrior(problem, priors_, stillPose_, s.pose.data());
    problem.AddResidualBlock(makeRootUpright(s.reference, Vec3d(0, 1, 0), still_ * Vec3d(0, 1, 0)), nullptr, s.root);
}

void FramePoses::addTerms(ceres::Problem& problem, Split split) {
    std::vector<size_t> order;  // with the neighbours of earlier splits
    for (const size_t f : order_)
        if (input_.frames[f].split <= split) order.push_back(f);
    const auto free = [&](size_t f) { return input_.frames[f].split == split; };
    const Vec3d up = still_ * Vec3d(0, 1, 0);
    for (const size_t f : order) {
        if (!free(f)) continue;
        const RegisterFrame& frame = input_.frames[f];
        addKeypoints(problem, f);
        const bool seen = problem.HasParameterBlock(states_[f].root);
        if (!seen && !frame.picture) continue;  // its neighbours alone place it
        addStandingPriors(problem, f);
    }
    for (size_t f = 0; f < states_.size() && split == Split::Train; ++f)
        if (input_.frames[f].kind != FrameKind::Dynamic && input_.frames[f].picture) addKeypoints(problem, f), addSway(problem, f);
    std::vector<MovingFrame> inTime;
    for (const size_t f : order) {
        State& s = states_[f];
        inTime.push_back({input_.frames[f].timeS, &s.reference, s.root, s.pose.data(), free(f)});
    }
    addMotionTerms(problem, {context_, priors_, input_.keypointNames, up, &noShape_, {true, priors::kAccelerationTailShare}}, inTime);
    for (double* constant : {&noShape_, &logUnit_})
        if (problem.HasParameterBlock(constant)) problem.SetParameterBlockConstant(constant);
    for (const size_t f : order)
        if (!free(f)) hold(problem, f);
}

void FramePoses::holdAllBut(ceres::Problem& problem, std::span<const size_t> frames) {
    for (size_t f = 0; f < states_.size(); ++f)
        if (std::find(frames.begin(), frames.end(), f) == frames.end()) hold(problem, f);
}

void FramePoses::hold(ceres::Problem& problem, size_t f) {
    if (problem.HasParameterBlock(states_[f].root)) problem.SetParameterBlockConstant(states_[f].root);
    holdPose(problem, states_[f].pose);
}

void FramePoses::addPicture(ceres::Problem& problem, size_t frame, ceres::CostFunction* cost) {
    std::vector<double*> blocks = {states_[frame].root};
    addPoseBlocks(blocks, states_[frame].pose.data(), priors_.size());
    problem.AddResidualBlock(cost, nullptr, blocks);
}

PosePrecision FramePoses::precision(ceres::Problem& problem, size_t frame) {
    State& s = states_[frame];
    ceres::Problem priorsAlone;
    const bool solved = problem.HasParameterBlock(s.root);
    if (!solved) {
        if (input_.frames[frame].kind == FrameKind::Dynamic)
            addStandingPriors(priorsAlone, frame);
        else
            addSway(priorsAlone, frame);
    }
    ceres::Problem& own = solved ? problem : priorsAlone;
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = {s.root};
    addPoseBlocks(options.parameter_blocks, s.pose.data(), priors_.size());
    std::set<ceres::ResidualBlockId> known;
    for (double* block : options.parameter_blocks) {
        std::vector<ceres::ResidualBlockId> terms;
        own.GetResidualBlocksForParameterBlock(block, &terms);  // in the order in which they were added
        for (const ceres::ResidualBlockId term : terms)
            if (known.insert(term).second) options.residual_blocks.push_back(term);
    }
    ceres::CRSMatrix jacobian;
    own.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);

    PosePrecision out;
    out.joints.push_back(0);
    for (const JointPrior& p : priors_) out.joints.push_back(p.joint);
    const Eigen::Index n = Eigen::Index(out.size()), last = n - 3;
    // Column of d for each parameter. Parameters: root turn, root translation, turn of each joint; d has the translation last.
    const auto column = [&](Eigen::Index parameter) {
        return parameter < 3 ? parameter : parameter < 6 ? last + parameter - 3 : parameter - 3;
    };
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Matrix rows = Matrix::Zero(jacobian.num_rows, n);
    for (int r = 0; r < jacobian.num_rows; ++r)
        for (int i = jacobian.rows[size_t(r)]; i < jacobian.rows[size_t(r) + 1]; ++i)
            rows(r, column(jacobian.cols[size_t(i)])) = jacobian.values[size_t(i)];
    // A parameter w turns by exp(w + dw) = exp(J dw)·exp(w), so its column counts J⁻¹ turns.
    for (size_t k = 0; k < out.joints.size(); ++k) {
        const double* w = k == 0 ? s.root : &s.pose[3 * (k - 1)];
        const Mat3d inverse = glm::inverse(leftJacobian({w[0], w[1], w[2]}));
        Eigen::Matrix3d perTurn;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) perTurn(r, c) = inverse[c][r];
        rows.middleCols(Eigen::Index(3 * k), 3) = (rows.middleCols(Eigen::Index(3 * k), 3) * perTurn).eval();
    }
    out.matrix.resize(size_t(n * n));
    Matrix lower = Matrix::Zero(n, n);
    lower.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
    Eigen::Map<Matrix>(out.matrix.data(), n, n) = lower.selfadjointView<Eigen::Lower>();
    return out;
}

Result<SolveEnd> FramePoses::solve(ceres::Problem& problem, const std::string& what, int steps) const {
    ceres::Solver::Summary summary;
    ceres::Solve(solverOptions(steps), &problem, &summary);
    if (!summary.IsSolutionUsable()) return fail(Code::Internal, "registration failed in '{}': {}", what, summary.message);
    return SolveEnd{what,
                    std::string(ceres::TerminationTypeToString(summary.termination_type)) + ": " + summary.message,
                    true,
                    int(summary.iterations.size()),
                    summary.initial_cost,
                    summary.final_cost};
}

}  // namespace dpl
