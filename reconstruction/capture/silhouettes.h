// SPDX-License-Identifier: Apache-2.0
// Masks seen together: which part of space all silhouettes agree on.
#pragma once

#include <optional>
#include <span>

#include "reconstruction/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

struct SilhouetteView {
    Camerad camera;
    ImageGrey8 mask;  // person ≥ 128
};

/** A box of cubes: voxel (x, y, z) has index (z·ny + y)·nx + x and its centre at origin + (index + ½)·voxelM. */
struct VoxelGrid {
    Vec3d origin{0};
    double voxelM = 0;
    uint32_t nx = 0, ny = 0, nz = 0;

    size_t count() const { return size_t(nx) * ny * nz; }
    size_t index(uint32_t x, uint32_t y, uint32_t z) const { return (size_t(z) * ny + y) * nx + x; }
    Vec3d centre(uint32_t x, uint32_t y, uint32_t z) const { return origin + voxelM * Vec3d(x + 0.5, y + 0.5, z + 0.5); }
};

struct SilhouetteVotes {
    std::vector<uint16_t> seen;    // views whose picture contains the voxel's centre
    std::vector<uint16_t> inside;  // ... and whose mask does
    /** Inside when at least `share` of the views that see it agree, and at least a third of all views see it. */
    bool isInside(size_t voxel, double share, size_t viewCount) const {
        return seen[voxel] * 3 >= viewCount && seen[voxel] > 0 && inside[voxel] >= share * seen[voxel];
    }
};

/** Where most views look at the subject: the point nearest to the rays through the middles of the masks' boxes. */
std::optional<Vec3d> subjectCentre(std::span<const SilhouetteView> views);

SilhouetteVotes voteSilhouettes(std::span<const SilhouetteView> views, const VoxelGrid& grid, Jobs& jobs);

/** A grid of cubes of voxelM around the space that `share` of the views agree on, with two cubes of margin; found on a coarse grid first.
 *  voxelM ≤ 0: as fine as 64 cubes along the longest side. Nothing when the silhouettes do not meet or the grid would exceed 2²⁸ cubes. */
std::optional<VoxelGrid> boundSilhouettes(std::span<const SilhouetteView> views, double voxelM, double share, Jobs& jobs);

/** Median over the views of the share of the mask that the common space covers when projected back: near 1 when cameras and masks belong
 *  together, near 0 when they do not. 0 when the silhouettes do not meet. */
double silhouetteCoherence(std::span<const SilhouetteView> views, Jobs& jobs);

}  // namespace dpl
