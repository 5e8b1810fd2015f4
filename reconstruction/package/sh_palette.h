// SPDX-License-Identifier: Apache-2.0
// A palette of spherical harmonics: k-means over the rows beyond coefficient 0, so that a splat needs an index of 16 bits instead of
// 9, 24 or 45 bytes (docs/formats/avatar.md).
#pragma once

#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct ShPaletteSettings {
    uint32_t maxEntries = 4096;  // 1 to kMaxShPalette
    double maxRmsLevels = 0;     // fewer entries when this error is reached sooner; 0: all of them
    uint32_t refinements = 4;    // passes of Lloyd after the splitting; fewer where they would take more than some seconds
};

/** Errors of colour in 8-bit levels, root mean square over all directions and channels. */
struct ShPaletteReport {
    uint32_t entries = 0;
    double rmsLevels = 0;    // over splats, weighted by what they cover: opacity · s1 · s2
    double worstLevels = 0;  // of one splat
};

/** Replaces the SH rows of `splats` by their palette entries, for WriteOptions::shPalette. The entries are values that the codec keeps
 *  exactly, and every splat has the nearest. Clusters come from splitting the worst one at its mean along its longest axis (no random
 * start: same input, same bytes, on any number of threads), then Lloyd's passes. Splats of SH degree 0 are left alone: 0 entries.
 *  InvalidArgument: maxEntries out of range. */
Result<ShPaletteReport> paletteSh(SplatData& splats, const ShPaletteSettings& settings, Jobs& jobs);

}  // namespace dpl
