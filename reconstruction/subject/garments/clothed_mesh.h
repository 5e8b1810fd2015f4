// SPDX-License-Identifier: Apache-2.0
// The clothed subject as layers: body, garments, shoes and hair, each a mesh of its own, from the fitted body and the still pictures.
//
// The masks' visual hull gives the outer surface, so its topology is that of the clothes and not of the legs. The label pictures vote on
// it, the labelled parts become open meshes, and the body goes on below them. All parts take skin weights from the body and are brought
// back to the rest pose. docs/reference/garments.md
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/garments/garment_pieces.h"
#include "reconstruction/subject/garments/parted_legs.h"
#include "reconstruction/subject/garments/still_views.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Rest pose, metres. Layers tile vertices and triangles, the body first. No two layers have a vertex at the same position. */
struct ClothedMesh {
    MeshData mesh;
    std::vector<uint8_t> triangleLabel;  // F: label values of the scan
};

/** Moves vertices of later layers by a hair's breadth where they share a position with another layer: consumers merge equal positions. */
void separateLayers(MeshData& mesh);

struct GarmentInput {
    const MeshData& body;  // of the fitted shape, at rest; 4 × unorm8 weights
    std::span<const JointData> joints;
    std::span<const Vec3f> bodyOffsets;   // one per vertex, rest pose, metres: from the body to the clothed surface of fitSurface()
    std::span<const GarmentView> views;   // still
    std::span<const GarmentView> moving;  // tell trousers from skirts where the legs touch in the still pose; may be empty
    std::span<const ScanLabel> labels;
};

/** What moving pictures say of a garment between the legs. */
struct LegDecision {
    std::string name;  // of the label
    BetweenLegs seen;  // parted(): the garment was given two legs
};

struct GarmentFit {
    ClothedMesh clothed;
    std::vector<GarmentDecision> decisions;  // one per label of the scan but background and body
    std::vector<LegDecision> legs;           // of the garments that go on between the legs, below the crotch
    std::string summary;                     // a sentence
    double hullIou = 0;                      // mean over the views: of the masks and the hull; 0 without a hull
    double insideBody = 0;                   // share of garment vertices that lie inside the body layer at rest
    float largestWeightStep = 0;             // of a joint's weight along a garment's edge
};

/** Makes the layers. Views without labels only shape the hull. When no label becomes a garment (no labels, a single view, empty masks), the
 *  result is one body layer with all of bodyOffsets, and `summary` says why. The result does not depend on the number of threads.
 * Errors: InvalidArgument for sizes, poses or weights that do not match; Cancelled. */
Result<GarmentFit> makeClothedMesh(const GarmentInput& input, Jobs& jobs);

}  // namespace dpl
