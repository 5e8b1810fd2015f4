// SPDX-License-Identifier: Apache-2.0
// Which skin of an avatar its pictures saw, told from the avatar alone: by what shows at rest, by the capture map, and by the colours of
// clothes (docs/reference/dress.md).
#pragma once

#include <span>

#include "reconstruction/output/dress/layer_part.h"
#include "reconstruction/output/dress/splat_fill.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** 1 for each triangle of the mesh that shows from some side at rest. A triangle of the body, the mesh's first ones, may be smaller than a
 *  pixel of the views: it shows where its middle is not hidden, unless clothes lie on it (`covered`: one per triangle of the body). The
 *  views depend on the body alone. */
Marks shownTriangles(const SurfaceMesh& mesh, const MeshData& body, const Marks& covered, Jobs& jobs);

/** 1 for each triangle of the body on a side of its joint that the scan's pictures show (the capture map); all of them without a map. */
Marks capturedTriangles(const CaptureMapData& map, const MeshData& body);

/** 1 for eyes, brows, nose and mouth: what faces front within a box around the eye joints. Without eye joints the front of head and
 *  neck. */
Marks faceTriangles(std::span<const JointData> joints, const MeshData& body);

/** 1 for triangles among `edge` whose splats have taken on some of the colour of the closest of `clothes`: pictures showed cloth or hair
 *  there. skin: colours of the skin around, one per triangle. */
Marks clothColoured(const LayerPart& body, const Marks& edge, std::span<const Vec3f> skin, std::span<const LayerPart> clothes);

}  // namespace dpl
