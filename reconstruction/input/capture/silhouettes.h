// SPDX-License-Identifier: Apache-2.0
// Visual hull: the part of space on which the silhouettes of all views agree.
#pragma once

#include <optional>
#include <span>

#include "reconstruction/input/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

struct SilhouetteView {
    Camerad camera;
    ImageGrey8 mask;  // person ≥ 128
};

/** A grid of cubic voxels. Voxel (x, y, z) has index (z·ny + y)·nx + x and its centre at origin + (index + ½)·voxelM. */
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
    std::vector<uint16_t> inside;  // views whose mask contains it
    /** True when at least a third of all views see the voxel and at least `share` of those have it inside. */
    bool isInside(size_t voxel, double share, size_t viewCount) const {
        return seen[voxel] * 3 >= viewCount && seen[voxel] > 0 && inside[voxel] >= share * seen[voxel];
    }
};

/** The point nearest to the rays through the centres of the masks' bounding boxes, robust to a few wrong masks. */
std::optional<Vec3d> subjectCentre(std::span<const SilhouetteView> views);

SilhouetteVotes voteSilhouettes(std::span<const SilhouetteView> views, const VoxelGrid& grid, Jobs& jobs);

/** The voxel grid that bounds the hull of `share` of the views, with a margin of two voxels. A coarse grid is searched first.
 *  voxelM ≤ 0: 64 voxels along the longest side. Empty when the hull is empty or the grid would exceed 2²⁸ voxels. */
std::optional<VoxelGrid> boundSilhouettes(std::span<const SilhouetteView> views, double voxelM, double share, Jobs& jobs);

/** Share of the views that must have a voxel inside: a tenth may err. */
inline constexpr double kHullShare = 0.9;

/** The voxels inside a hull. */
struct HullVoxels {
    double voxelM = 0;
    std::vector<Vec3d> centres;

    /** Depth of the nearest voxel in front of the camera that falls into its picture; infinite when none does. */
    double nearestDepthM(const Camerad& camera) const;
};

/** The voxels of `grid` that `share` of `viewCount` views have inside. */
HullVoxels hullVoxels(const SilhouetteVotes& votes, const VoxelGrid& grid, double share, size_t viewCount);

/** The hull in a picture: 255 where a square of a voxel's projected size covers the pixel. `grow` scales the squares. */
ImageGrey8 drawHull(const HullVoxels& hull, const Camerad& camera, double grow = 1);

/** Projects the hull into each view and returns the median share of the mask that it covers: near 1 when cameras and masks match, lower
 *  when they do not, 0 when the hull is empty. */
double silhouetteCoherence(std::span<const SilhouetteView> views, Jobs& jobs);

}  // namespace dpl
