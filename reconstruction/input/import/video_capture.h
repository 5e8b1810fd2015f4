// SPDX-License-Identifier: Apache-2.0
// Captures from videos: of an unknown camera that is carried round a subject, or of calibrated cameras that stand.
#pragma once

#include "reconstruction/input/import/capture.h"
#include "reconstruction/input/import/video.h"

namespace dpl {

/** Most frames that a scan takes of each kind. */
struct FrameCounts {
    size_t still = 72, closeup = 24, moving = 96;
};

struct VideoSources {
    std::vector<std::filesystem::path> still, closeup, moving;
    std::filesystem::path undivided;  // one video of both: where the subject stands still and where it moves is found
};

/** Chooses frames and writes them as JPEG files into folders of their own under work.folder. Moving frames keep their time stamps; a second
 *  video goes on a second after the first one ends. */
Result<Capture> readVideos(const VideoSources& sources, const FrameCounts& counts, uint32_t longSidePx, const VideoWork& work);

/** Videos of fixed, synchronised cameras beside a calibration. A video belongs to the camera whose name its own name contains. */
Result<Capture> readCalibratedVideos(const std::filesystem::path& folder, const std::filesystem::path& calibration,
                                     const FrameCounts& counts, const VideoWork& work);

}  // namespace dpl
