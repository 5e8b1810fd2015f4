// SPDX-License-Identifier: Apache-2.0
// Fits the clothed surface: static rest-pose offsets of a body mesh, with which its silhouettes fill the masks of the still pictures.
//
// In every view the outlines of the posed mesh and of the mask are matched in both directions: each mesh point is pulled to the nearest
// mask point, and each mask point pulls the nearest mesh point. The second direction reaches things such as a bag in a hand. Each pull
// is placed in space at the mesh's depth, transformed back to the rest pose, and spread over the surface by
//     δ = M⁻²(Σ w d) / (M⁻²(Σ w) + ε),   M = I + λL  (LargeSteps, reconstruction/subject/shape)
// Marks such as the eyes pull likewise, each as hard as a stretch of outline. This normalised convolution has a smoothing length that
// shrinks from level to level. In the second half of the levels each view also gets a small translation of its own, because the subject
// sways by a centimetre between pictures. docs/reference/registration.md
#pragma once

#include <span>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/subject/surface/priors.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** A point of the surface that a picture shows: an eye, the tip of the nose. Outlines alone would let the surface slide along beneath it.
 */
struct SurfaceMark {
    std::vector<std::pair<uint32_t, float>> vertices;  // their weighted mean is the point; weights sum to 1
    Vec3f seenAtM{0};                                  // from there to where the picture's point lies, at rest
    Vec2d px{0};                                       // the picture's point
    float confidence = 1;                              // 0 to 1
};

/** One still picture of the training split. The camera is metric; the mask has the camera's size, person ≥ 128. */
struct SurfaceView {
    Camerad camera;
    ImageGrey8 mask;
    Pose pose;  // for the rig, including this frame's sway
    std::vector<SurfaceMark> marks = {};
};

struct SurfaceFitSettings {
    double startSmoothingM = priors::kStartSmoothingM, endSmoothingM = priors::kEndSmoothingM;  // of the first and the last level
    uint32_t levels = 8, roundsPerLevel = 4;
    double maxOffsetM = priors::kMaxOffsetM;  // length limit of an offset
    double maxStepM = 0.04;                   // length limit of one round's step
    double maxSwayM = priors::kMaxViewSwayM;  // length limit of a view's own translation; 0 switches it off
};

struct SurfaceFit {
    std::vector<Vec3f> restOffsets;              // one per vertex, metres; add to MeshData::restPositions
    double meanIouBefore = 0, meanIouAfter = 0;  // over the given views
    std::vector<double> iouBefore, iouAfter;     // per view; after: with offsets and viewTranslationsM
    // Remaining sway of the subject, one per view: add to Pose::rootTranslation. Parallel to the picture's plane; the mean over the views
    // is 0.
    std::vector<Vec3f> viewTranslationsM;
    uint32_t rounds = 0;
    double meanOffsetM = 0, largestOffsetM = 0;
};

/** Fits the offsets. A small separate part (eyes, teeth) takes the offset of the nearest vertex of the largest part. The result does not
 *  depend on the thread count. Memory: a few pictures per thread. Errors: InvalidArgument for sizes, poses or weights that do not match;
 *  CorruptData when no view shows a person; Cancelled. */
Result<SurfaceFit> fitSurface(const MeshData& mesh, std::span<const JointData> joints, std::span<const SurfaceView> views,
                              const SurfaceFitSettings& settings, Jobs& jobs);

/** Intersection over union of the posed mesh with each view's mask. `restOffsets` are added first; may be empty. */
Result<std::vector<double>> surfaceIou(const MeshData& mesh, std::span<const JointData> joints, std::span<const Vec3f> restOffsets,
                                       std::span<const SurfaceView> views, Jobs& jobs);

}  // namespace dpl
