// SPDX-License-Identifier: Apache-2.0
// Runs COLMAP (https://colmap.github.io, 3.8 or later) as a program on pictures whose cameras are not known.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reconstruction/input/cameras/colmap_model.h"

namespace dpl {

inline constexpr const char* kColmapProgram = "colmap";  // in PATH
inline constexpr const char* kHowToGetColmap = "run doppel setup, or apt-get install colmap";

struct ColmapRun {
    std::filesystem::path folder;     // has images/, and masks/IMAGE.png where not the whole picture counts. For all other files
    std::vector<std::string> images;  // names in images/, without spaces, one size, one lens
    std::vector<std::pair<size_t, size_t>> pairs;  // of images, to match
    uint32_t widthPx = 0, heightPx = 0;            // of all images
    double focalPx = 0;                            // start of the search
    uint32_t threads = 2;
};

/** The sparse model with the most pictures, as readColmapModel returns it; empty when COLMAP finds none. Files of an earlier run in the
 *  folder are removed first. All output of COLMAP is in folder/colmap.log. NotFound with the remedy when COLMAP is not installed. Cancelled
 *  within a second. */
Result<std::vector<ColmapImage>> runColmap(const ColmapRun& run);

}  // namespace dpl
