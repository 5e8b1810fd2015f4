// SPDX-License-Identifier: Apache-2.0
// Body fit: one shape, one still pose, one pose a moving frame, from 2D keypoints (and masks) with known cameras; Ceres, one thread,
// deterministic.
//
//   min Σ_frames Σ_k ρ( (π(K_f(R_f X_k(β,θ) + μ t_f)) − x_fk) / σ_fk ) + priors(θ, β) + smoothness in time
//   ρ Geman–McClure on each keypoint, σ = σ₀ / confidence, μ metres per unit of the scan's world (1 when the scan is metric)
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/body/body_model.h"
#include "reconstruction/capture/scan.h"
#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

struct BodyFitSettings {
    double sigmaAtFullConfidence = 0.0024;  // keypoint noise, fraction of the image diagonal (1.5 px at 378 × 504)
    double outlierSigmas = 4;               // Geman–McClure scale
    bool useMasks = true;                   // shape refinement against the masks of still train frames
    /** Called between and inside solves with the part done, 0…1, and what is running; false cancels (Code::Cancelled). */
    std::function<bool(double fraction, std::string_view what)> progress;
};

/** How one least-squares solve ended. */
struct SolveEnd {
    std::string what;
    std::string how;  // Ceres' termination and message
    bool usable = false;
    int steps = 0;
    double costBefore = 0, costAfter = 0;
};

struct KindResidual {
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    size_t frames = 0, keypoints = 0;
    double meanPx = 0, medianPx = 0, p95Px = 0;  // of confident keypoints (≥ 0.7)
};

struct BodyFit {
    std::vector<double> shape;  // one value per morph
    double metresPerUnit = 1;   // scale of the scan's world; multiply camera translations by it (metricCamera)
    Pose staticPose;            // of the still frames
    std::vector<Pose> poses;    // one per Scan::frames, rig of shapedBody(body, shape); still frames: the still pose and a small sway
    std::vector<bool> fitted;   // one per frame: false where the frame had too few keypoints and the pose was inherited or interpolated
    std::vector<SolveEnd> solves;
    std::vector<KindResidual> residuals;
};

/** Fits `body` to `scan`. keypoints[f] belongs to scan.frames[f], order of scan.keypointNames; empty: none seen.
 *  Train frames decide shape, scale, still pose and each other's poses; test frames are posed afterwards against frozen train results,
 *  so their data cannot reach anything that ships. Deterministic for equal input. InvalidArgument / CorruptData when the body has no
 *  keypoints of these names or the frames show too few; Cancelled. About a minute for 170 frames on one core. */
Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, std::span<const std::vector<Keypoint>> keypoints,
                        const BodyFitSettings& settings = {});

/** Reads every frame's keypoint file and fits. */
Result<BodyFit> fitBody(const BodyModel& body, const Scan& scan, const BodyFitSettings& settings = {});

/** The camera in the metric world of the fit. */
Camerad metricCamera(const Camerad& camera, double metresPerUnit);

}  // namespace dpl
