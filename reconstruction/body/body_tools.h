// SPDX-License-Identifier: Apache-2.0
// Small operations on a BodyModel: checks, shaping, named lookups, and the parts every importer shares.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "reconstruction/body/body_model.h"
#include "sdk/core/result.h"

namespace dpl {

/** Refuses a body that the fit or the trainer could not use: no joints, no skin weights, indices out of range, parents after children,
 *  non-finite numbers, morphs or keypoints of the wrong size. The sentence starts with the body's name. */
Status checkBody(const BodyModel& body);

/** The body at morph values `shape` (one per morph, metres at value 1): joints and vertices moved, morphs kept as they are. */
BodyModel shapedBody(const BodyModel& body, std::span<const double> shape);

/** The body with one more morph a bone pair ("bone_upper_arm" ...; ±1 is ±4 % of its length), for bodies whose own morphs fix proportions
 *  that people vary in. Left alone when it has them. Give it to fitBody and shapedBody alike. */
BodyModel withBoneMorphs(BodyModel body);

/** Index of the joint with this humanoid bone name (VRM), or -1. */
int32_t findHumanoid(const BodyModel& body, std::string_view humanoidBone);

/** Index of a joint by its own name, or -1. */
int32_t findJoint(std::span<const JointData> joints, std::string_view name);

/** The 24 keypoint names of a scan, in scan.json's order. */
std::span<const std::string_view> scanKeypointNames();

/** Keypoints for any humanoid body: joints by humanoid bone, face points from the shape of the head. Points that cannot be found are left
 * out. */
std::vector<BodyKeypoint> deriveKeypoints(const BodyModel& body);

/** Weights (sum 1) on the vertices nearest to `point` that reproduce it exactly, for points inside the surface such as an eye's pupil.
 *  Only vertices with index in `candidates` are used. */
std::vector<std::pair<uint32_t, float>> anchorPoint(const MeshData& mesh, std::span<const uint32_t> candidates, const Vec3f& point);

}  // namespace dpl
