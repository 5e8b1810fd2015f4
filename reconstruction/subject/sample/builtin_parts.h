// SPDX-License-Identifier: Apache-2.0
// The steps of makeBuiltinBody. Private to reconstruction/subject/sample.
#pragma once

#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/sample/body_field.h"
#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

/** The mesh of the body, metres. */
SurfaceMesh meshBody(const BodyField& field, Jobs& jobs);

/** Skin weights, V × jointCount, one row per vertex. Smooth; each row sums to 1. */
std::vector<float> bodyWeights(const BodyField& field, const SurfaceMesh& mesh, const std::vector<JointData>& joints, Jobs& jobs);

/** Keeps the four largest of each row of dense weights (V × jointCount), as unorm8 that sum to 255. Of equal weights the lower joint wins.
 */
void cutWeights(const std::vector<float>& dense, size_t jointCount, std::vector<glm::u16vec4>& indices, std::vector<glm::u8vec4>& weights);

std::vector<ShapeMorph> bodyMorphs(const SurfaceMesh& mesh, const std::vector<float>& dense, const std::vector<JointData>& joints);

std::vector<BodyKeypoint> bodyKeypoints(const SurfaceMesh& mesh);

/** The keypoints of both hands, in the order of handKeypointNames(). */
std::vector<BodyKeypoint> fingerKeypoints(const SurfaceMesh& mesh);

}  // namespace dpl
