// SPDX-License-Identifier: Apache-2.0
// The unknown poses with every term that needs no picture: keypoints; for moving frames pose priors, smoothness in time and resting feet;
// for still frames the spread of their sway.
// Private to reconstruction/subject/registration.
#pragma once

#include <ceres/problem.h>

#include <cmath>

#include "reconstruction/subject/body/fit_costs.h"
#include "reconstruction/subject/body/limb_depths.h"
#include "reconstruction/subject/registration/register_frames.h"

namespace dpl {

class FramePoses {
public:
    /** `input` must outlive it. */
    explicit FramePoses(const RegisterInput& input);
    FramePoses(const FramePoses&) = delete;

    /** Moving frames of a split in time, as indices of RegisterInput::frames. */
    std::vector<size_t> movingInTime(Split split) const;
    bool hasMoving(Split split) const { return !movingInTime(split).empty(); }
    const KeypointChain& chain() const { return chain_; }
    const Mat3d& reference(size_t frame) const { return states_[frame].reference; }
    /** Local rotations of the joints that registration does not turn, fingers above all, as a frame came with them; empty: at rest. */
    std::span<const Mat3d> held(size_t frame) const { return states_[frame].held; }
    Pose pose(size_t frame) const;
    /** Runs of neighbouring moving frames of a split whose keypoints of a limb lie more than kLimbDoubtSigmas from the current pose. */
    std::vector<std::vector<size_t>> doubtedRuns(size_t limb, Split split) const;
    /** Sets a limb of frames that doubtedRuns() gave to candidate 0 … 3 of its keypoints (fit_limbs.h). */
    void bendLimb(size_t limb, std::span<const size_t> frames, size_t candidate);
    /** Parameters of all frames. */
    std::vector<double> parameters() const;
    void setParameters(std::span<const double> values);

    /** The terms of the moving frames of a split, and for Split::Train of still frames with a picture. Frames of earlier splits are
     * constant neighbours; those of later splits do not take part. */
    void addTerms(ceres::Problem& problem, Split split);
    /** Holds all frames but these, moving or still. */
    void holdAllBut(ceres::Problem& problem, std::span<const size_t> frames);
    /** Adds a cost of the blocks of root and pose. The problem owns it. */
    void addPicture(ceres::Problem& problem, size_t frame, ceres::CostFunction* cost);
    /** Precision of a frame's pose, by the Gauss–Newton matrix of its own residuals in `problem`. Without any there: of
     *  the priors of the frame alone. */
    PosePrecision precision(ceres::Problem& problem, size_t frame);
    Result<SolveEnd> solve(ceres::Problem& problem, const std::string& what, int steps) const;

private:
    struct State {
        Mat3d reference{1};
        double root[kRootSize] = {};
        std::vector<double> pose;
        std::vector<Mat3d> held;
    };
    double sigmaPx(const RegisterFrame& frame) const {
        return input_.keypointSigma * std::hypot(double(frame.camera.widthPx), double(frame.camera.heightPx));
    }
    std::vector<double> parametersOf(const Pose& pose) const;
    std::vector<Mat3d> heldOf(const Pose& pose) const;
    LimbModel limbModel() const { return {body_, chain_, priors_, input_.keypointNames, &noShape_, stillPose_}; }
    LimbFrame limbFrame(size_t frame);
    void hold(ceres::Problem& problem, size_t frame);
    void addKeypoints(ceres::Problem& problem, size_t frame);
    void addSway(ceres::Problem& problem, size_t frame);
    void addStandingPriors(ceres::Problem& problem, size_t frame);

    const RegisterInput& input_;
    BodyModel body_;  // without morphs, so that the chain has no shape
    std::vector<JointPrior> priors_;
    KeypointChain chain_;
    FitContext context_;
    std::vector<double> stillPose_;
    Mat3d still_{1};
    double noShape_ = 0, logUnit_ = 0;
    std::vector<State> states_;  // of RegisterInput::frames
    std::vector<size_t> order_;  // all moving frames in time
};

}  // namespace dpl
