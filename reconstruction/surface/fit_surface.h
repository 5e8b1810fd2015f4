// SPDX-License-Identifier: Apache-2.0
// The clothed surface, first version: static rest-pose offsets of a body mesh so that its silhouettes fill the masks of the still pictures.
//
// In every view the outline of the posed mesh and the outline of the mask are matched both ways (a mesh point goes to the nearest outline
// of the mask, a mask point pulls the nearest outline of the mesh: that is what reaches a helmet in a hand). The pulls are lifted into
// space at the depth of the mesh, turned back to the rest pose, and spread over the surface by
//     δ = M⁻²(Σ w d) / (M⁻²(Σ w) + ε),   M = I + λL  (LargeSteps, reconstruction/shape)
// a normalised convolution whose smoothing length shrinks from round to round. From the second half of the levels on each view also gets a
// small translation of its own, because the subject sways by a centimetre between pictures.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "reconstruction/capture/scan.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** One still picture. The camera is metric; the mask has its size, person ≥ 128. Give training views only. */
struct SurfaceView {
    Camerad camera;
    ImageGrey8 mask;
    Pose pose;  // of the rig, this frame's sway included
};

struct SurfaceFitSettings {
    double startSmoothingM = 0.12, endSmoothingM = 0.012;  // on scan-a ending at 30 mm gives a mean IoU of 0.940, at 12 mm 0.962
    uint32_t levels = 8, roundsPerLevel = 4;
    double maxOffsetM = 0.35;                       // length limit of an offset: a helmet in the hand, not a wall
    double maxStepM = 0.04;                         // length limit of one round's step
    double maxSwayM = 0.03;                         // length limit of a view's own translation; 0 switches it off
    std::function<bool(double fraction)> progress;  // false cancels; may be empty
};

struct SurfaceFit {
    std::vector<Vec3f> restOffsets;              // V, metres, rest pose: add to MeshData::restPositions
    double meanIouBefore = 0, meanIouAfter = 0;  // over the given views
    std::vector<double> iouBefore, iouAfter;     // per view; after: with offsets and viewTranslationsM
    // What is left of the subject's sway: add to Pose::rootTranslation of each view. Lies in the picture's plane; the mean over the views
    // is 0.
    std::vector<Vec3f> viewTranslationsM;
    uint32_t rounds = 0;
    double meanOffsetM = 0, largestOffsetM = 0;
};

/** InvalidArgument on sizes, poses or weights that do not fit; CorruptData when no view has a person; Cancelled. The same result for any
 * thread count. Memory: a few pictures a thread. Separate small parts (eyes, teeth) ride on the nearest vertex of the largest part. */
Result<SurfaceFit> fitSurface(const MeshData& mesh, std::span<const JointData> joints, std::span<const SurfaceView> views,
                              const SurfaceFitSettings& settings, Jobs& jobs);

/** Intersection over union of the posed mesh (offsets added; may be empty) with each view's mask. */
Result<std::vector<double>> surfaceIou(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> restOffsets,
                                       std::span<const SurfaceView> views, Jobs& jobs);

}  // namespace dpl
