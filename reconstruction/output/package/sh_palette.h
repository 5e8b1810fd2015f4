// SPDX-License-Identifier: Apache-2.0
// A palette of spherical harmonics: k-means over the SH rows without coefficient 0. A splat then needs a 16-bit index instead of 9, 24 or
// 45 bytes (docs/formats/avatar.md).
#pragma once

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct ShPaletteSettings {
    uint32_t maxEntries = 4096;  // 1 to kMaxShPalette
    double maxRmsLevels = 0;     // stop adding entries at this error, 8-bit levels; 0: use maxEntries
    uint32_t refinements = 4;    // Lloyd passes after splitting; fewer for inputs on which they would take more than some seconds
};

/** Of avatar files. An error of 0.5 of 255 levels is 54 dB. 4,096 entries of degree 1 cost 0.5 bytes a splat at 80,000 splats. */
inline constexpr ShPaletteSettings kAvatarPalette{.maxEntries = 4096, .maxRmsLevels = 0.5};

/** Colour error in 8-bit levels, root mean square over all directions and channels. */
struct ShPaletteReport {
    uint32_t entries = 0;
    double rmsLevels = 0;    // over splats, weighted by opacity · s1 · s2
    double worstLevels = 0;  // largest of one splat
};

/** Replaces the SH rows of `splats` by the nearest palette entries, as WriteOptions::shPalette expects. Entries are rounded to values that
 *  the codec keeps exactly. Clusters are made by splitting the one with the largest error at its mean along its longest axis, then refined
 *  by Lloyd passes. Nothing is random: same input, same result for any thread count. SH of degree 0 are left unchanged (0 entries).
 *  InvalidArgument: maxEntries out of range. */
Result<ShPaletteReport> paletteSh(SplatData& splats, const ShPaletteSettings& settings, Jobs& jobs);

}  // namespace dpl
