// SPDX-License-Identifier: Apache-2.0
// The outer surface of the clothed subject, as far as outlines tell: the visual hull of the masks as a smooth distance field and a mesh.
//
// Each mask gives a signed distance to its outline, in pixels; times depth over focal length it is a distance in metres. The hull is where
// all views say "inside". To bear sway and errors of masks, the field at a point is not the largest of these distances but the one at rank
// `outvoted`. docs/reference/garments.md
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/garments/still_views.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/jobs.h"

namespace dpl {

class SilhouetteField {
public:
    /** cameras: one per view, without sway. Keeps four bytes per mask pixel. */
    SilhouetteField(std::span<const GarmentView> views, std::span<const Camerad> cameras, Jobs& jobs);

    /** Metres, negative inside. Positive where fewer than a third of the views look. Safe on several threads. */
    float operator()(const Vec3f& point) const;
    /** Whether any mask shows a person. */
    bool empty() const { return maps_.empty(); }

private:
    struct Map {
        Cameraf camera;
        std::vector<float> distancePx;  // at pixel centres, negative inside
    };
    std::vector<Map> maps_;
};

struct HullOptions {
    float cellM = 0.008f, edgeM = 0.011f;  // of the grid, and of the mesh
};

/** The largest piece of the field's zero surface within [low, high]. Empty when there is none. */
SurfaceMesh meshHull(const ScalarField& field, const Vec3f& low, const Vec3f& high, const HullOptions& options, Jobs& jobs);

}  // namespace dpl
