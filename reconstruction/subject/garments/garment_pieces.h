// SPDX-License-Identifier: Apache-2.0
// Takes garments out of the labelled hull as open meshes: borders cut along the label's edge and smoothed, with a strip that runs on below
// neighbouring garments.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/garments/label_field.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

/** One garment in the pose of the hull. */
struct GarmentPiece {
    uint32_t column = 0;  // of LabelField
    SurfaceMesh mesh;
};

/** Whether a label of the scan became a garment, and why. */
struct GarmentDecision {
    ScanLabel label;
    bool kept = false;
    std::string reason;  // a sentence
    uint32_t triangles = 0;
    double areaM2 = 0;
};

struct GarmentPieces {
    std::vector<GarmentPiece> pieces;        // in the order of the labels
    std::vector<GarmentDecision> decisions;  // one per column but the body's
};

struct PieceOptions {
    double minPieceShare = 0.01;   // of the hull's area, below which a piece of a garment belongs to its surroundings
    double holeM = 0.03;           // holes below this diameter are closed
    double overlapM = 0.012;       // how far a garment runs on below its neighbours
    double tuckM = 0.004;          // how deep it lies there
    double hemSmoothingM = 0.035;  // length along which borders are smoothed
};

/** How sure it is that hull vertices lie on the closed underside of an open hem, where the hull spans from a skirt's hem to the legs: 1 and
 *  above is sure. Such a patch faces down, above it the hull holds air for 42 cm and not the body, and it borders on one garment only. The
 *  undersides of shorter skirts stay closed, because those between the legs of shorts look the same. field: the votes on the hull.
 *  hullField: negative inside the hull. bodySurface: the body in the pose of the hull. */
std::vector<float> hemUndersides(const SurfaceMesh& hull, const LabelField& field, const ScalarField& hullField,
                                 const ClosestSurface& bodySurface);

/** `field` holds the votes on `hull`. Where `underside` is above the scores, the surface belongs to no garment. */
GarmentPieces takeGarments(const SurfaceMesh& hull, LabelField field, std::span<const float> underside, const PieceOptions& options);

}  // namespace dpl
