// SPDX-License-Identifier: Apache-2.0
// Fits a body to 2D keypoints and masks with known cameras. Unknowns: one shape, one still pose, one pose per moving frame and, for a
// scan that is not metric, its scale. Solved with Ceres on one thread; deterministic. docs/reference/registration.md
//
//   min Σ_frames Σ_k ρ( (π(K_f(R_f X_k(β,θ) + μ t_f)) − x_fk) / σ_fk ) + priors(θ, β) + smoothness in time
//   ρ   Geman–McClure loss of each keypoint, σ = σ₀ / confidence
//   σ₀  noise of the detector, a prior
//   μ   metres per unit of the scan's world (1 when the scan is metric)
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/body/priors.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

/** Standard deviation that body fit and registration assume of a keypoint's coordinate at full confidence: share of the image diagonal. */
inline double keypointSigma(const Scan& scan) {
    return scan.keypointsFound ? priors::kFoundKeypointSigma : priors::kKeypointSigma;
}

struct BodyFitSettings {
    double outlierSigmas = priors::kKeypointOutlierSigmas;  // Geman–McClure scale, σ
    bool useMasks = true;                                   // refine the shape against the masks of still train frames
};

/** How one least-squares solve ended. */
struct SolveEnd {
    std::string what;
    std::string how;  // termination type and message of Ceres
    bool usable = false;
    int steps = 0;
    double costBefore = 0, costAfter = 0;
};

/** Reprojection error over the frames of one kind and split. */
struct KindResidual {
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    size_t frames = 0, keypoints = 0;
    double meanPx = 0, medianPx = 0, p95Px = 0;  // over keypoints with confidence ≥ 0.7
};

/** Where the detector sees a keypoint, relative to the body's own (landmark_offsets.h). */
struct LandmarkOffset {
    uint32_t joint = 0;  // carries the keypoint
    Vec3d offset{0};     // metres, rest frame of the joint; the keypoint lies at its body place + W_joint · offset
};

struct BodyFit {
    std::vector<double> shape;  // one value per morph
    double metresPerUnit = 1;   // μ; metricCamera() applies it to a camera
    // The detector's noise as the residuals of the still train frames show it (keypoint_noise.h); 0 when it could not be estimated.
    double keypointSigma = 0;               // standard deviation of a coordinate at full confidence, fraction of the image diagonal
    double outlierShare = 0;                // of these keypoints: farther off than outlierSigmas × keypointSigma
    std::vector<LandmarkOffset> landmarks;  // one per keypoint name of the scan; empty: all zero
    Pose staticPose;                        // shared by the still frames
    std::vector<Pose> poses;       // one per frame, for the rig of shapedBody(body, shape); a still frame: staticPose plus its sway
    std::vector<uint8_t> swapped;  // one per frame: whose left and right keypoints were exchanged before the fit (SwappedParts)
    std::vector<bool> fitted;      // one per frame; false: too few keypoints, the pose is inherited or interpolated
    std::vector<SolveEnd> solves;
    std::vector<KindResidual> residuals;
};

/** Fits `body` to `scan`. keypoints[f] holds the keypoints of scan.frames[f] in the order of scan.keypointNames; empty: none seen.
 *  Train frames alone determine shape, scale, still pose and the train poses. Validation frames are posed afterwards with these results
 * fixed, then test frames, so that held-out data cannot reach the avatar. threads: two track both directions of time at once; the result is
 * the same. Half a minute for 170 frames. Errors: InvalidArgument or CorruptData when the body lacks these keypoints or the frames show too
 * few; Cancelled. */
Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints,
                        const BodyFitSettings& settings = {}, uint32_t threads = 1);

/** Reads the keypoint file of every frame, then fits. */
Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, const BodyFitSettings& settings, uint32_t threads);

/** The camera with its translation scaled to metres. */
Camerad metricCamera(const Camerad& camera, double metresPerUnit);

}  // namespace dpl
