// SPDX-License-Identifier: Apache-2.0
// Runs the MSL kernels of a whole frame on the CPU. order: 0 to 2, the order of the lanes.
#pragma once

#include <span>
#include <vector>

#include "sdk/math/camera.h"
#include "sdk/render/avatar_upload.h"
#include "shaders/shared/frame.h"

namespace dpl {

/** Results of a frame's kernels. */
struct MslFrame {
    std::vector<gpu::ProjectedSplat> projected;
    std::vector<gpu::SortPair> compacted;
    std::vector<uint32_t> sorted;
    gpu::FrameCounts counts{};
};

/** Sets the counts that compact.args writes for passes over runs of kRun survivors. */
void setRuns(gpu::FrameCounts& counts);

/** Sorts (key, splat) pairs with the sort kernels and returns the splats in order. */
std::vector<uint32_t> sortPairs(std::vector<gpu::SortPair> pairs, gpu::FrameCounts& counts, int order, uint32_t rounds = gpu::kSortRounds);
/** The same by std::stable_sort. */
std::vector<uint32_t> stablySorted(std::vector<gpu::SortPair> pairs);

/** Runs the passes of two views of one size up to the sorted list. samples: coverage samples of a pixel. */
MslFrame runGeneralFrame(const StaticSplatData& splats, std::span<const Cameraf> views, int order, const GeneralDetail& detail = {});
MslFrame runFrame(const AvatarData& avatar, const Pose& pose, std::span<const Cameraf> views, int order, const SplatDetail& detail = {},
                  uint32_t samples = 1);

/** Runs the tile passes on a sorted frame. Returns 8-bit colour of all views, then the depth sums. farthestSeenM: depth limits from the
 * app's scene for all views, or empty without a scene. */
std::vector<uint32_t> fillTiles(MslFrame& f, std::span<const Cameraf> views, int order, std::span<const float> farthestSeenM = {},
                                uint32_t samples = 1);

/** Colour of one view, RGB in [0,1], from the pixels of fillTiles. */
std::vector<double> rgbOfView(std::span<const uint32_t> pixels, const Cameraf& camera, size_t view);

}  // namespace dpl
