// SPDX-License-Identifier: Apache-2.0
// Operations on a BodyModel: checks, shaping, lookups by name, and helpers that the importers share.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** Checks a body before the fit and the trainer use it. Unsupported when it has no skin weights. CorruptData for: no joints, indices out of
 *  range, parents after children, non-finite numbers, morphs or keypoints of the wrong size. The message names the body. */
Status checkBody(const BodyModel& body);

/** The body with joints and vertices moved to the morph values `shape`, one per morph. The morphs themselves stay unchanged. */
BodyModel shapedBody(const BodyModel& body, std::span<const double> shape);

/** Adds one morph for each left and right bone pair ("bone_upper_arm" ...); ±1 changes the bone's length by ±4 %. Use it for bodies whose
 *  own morphs do not vary limb proportions. A body that already has these morphs is returned unchanged. fitBody and shapedBody must be
 *  given the same body. */
BodyModel withBoneMorphs(BodyModel body);

/** Index of the joint with this humanoid bone name (VRM), or -1. */
int32_t findHumanoid(const BodyModel& body, std::string_view humanoidBone);

/** Index of a joint by its own name, or -1. */
int32_t findJoint(std::span<const JointData> joints, std::string_view name);

/** The 24 keypoint names of a scan, in the order of scan.json. */
std::span<const std::string_view> scanKeypointNames();

/** Keypoints of a humanoid body: body points at the joints of its humanoid bones, face points from the shape of the head, then those of
 *  deriveHandKeypoints(). A point that cannot be found is left out. */
std::vector<BodyKeypoint> deriveKeypoints(const BodyModel& body);

/** Weights (sum 1) on the vertices nearest to `point` whose weighted mean is `point`. It may lie off the surface, as a pupil does.
 *  Only the vertices in `candidates` are used. */
std::vector<std::pair<uint32_t, float>> anchorPoint(const MeshData& mesh, std::span<const uint32_t> candidates, const Vec3f& point);

}  // namespace dpl
