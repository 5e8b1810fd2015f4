// SPDX-License-Identifier: Apache-2.0
// Draws the garments of a posed avatar from four sides and counts what is drawn where no cloth should be, and not drawn where it is.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "reconstruction/subject/garments/grown_tubes.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** Pixels of one garment, over the four sides. */
struct GarmentPixels {
    size_t drawn = 0;      // alpha ≥ 128 when this garment alone is drawn
    size_t outside = 0;    // of these, more than 2 cm outside the outline of the grown tubes
    size_t outline = 0;    // that see the garment's posed mesh
    size_t uncovered = 0;  // of these, alpha < 128 when the whole avatar is drawn
};

class GarmentPictures {
public:
    /** The avatar must outlive this. garments: its layers to count. */
    GarmentPictures(const AvatarData& avatar, std::span<const LayerData* const> garments, Jobs& jobs);
    ~GarmentPictures();

    /** One entry a garment. All are 0 for an avatar without splats or without a body layer. Deterministic. */
    std::vector<GarmentPixels> count(const PosedMesh& posed);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dpl
