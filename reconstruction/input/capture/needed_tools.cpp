// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/needed_tools.h"

#include <algorithm>

#include "reconstruction/base/models_folder.h"
#include "reconstruction/base/program.h"
#include "reconstruction/input/cameras/colmap_run.h"

namespace dpl {

ToolNeeds toolNeeds(const Scan& scan) {
    const auto noFrameHas = [&](auto path) {
        return std::all_of(scan.frames.begin(), scan.frames.end(), [path](const ScanFrame& frame) { return (frame.*path).empty(); });
    };
    return {.keypoints = noFrameHas(&ScanFrame::keypointsPath), .masks = noFrameHas(&ScanFrame::maskPath), .cameras = !scan.camerasKnown};
}

std::vector<std::string> missingTools(const ToolNeeds& needs, const std::filesystem::path& models) {
    std::vector<std::string> missing;
    if (needs.videos && !(findProgram("ffmpeg") && findProgram("ffprobe")))
        missing.emplace_back("ffmpeg, which reads videos: apt-get install ffmpeg");
    if ((needs.keypoints || needs.masks) && models.empty() && installedModels().empty())
        missing.push_back(formatText("networks, which find the person's {}: {}",
                                     !needs.masks       ? "keypoints"
                                     : !needs.keypoints ? "masks"
                                                        : "keypoints and masks",
                                     howToGetNetworks()));
    if (needs.cameras && !findProgram(kColmapProgram))
        missing.push_back(formatText("COLMAP, which finds the cameras: {}", kHowToGetColmap));
    return missing;
}

std::string namesOf(const std::vector<std::string>& missing) {
    std::string names;
    for (size_t i = 0; i < missing.size(); ++i)
        names += (i == 0 ? "" : i + 1 == missing.size() ? " and " : ", ") + missing[i].substr(0, missing[i].find(','));
    return names;
}

std::string describeMissing(const std::string& subject, const std::vector<std::string>& missing) {
    std::string text = subject + " needs what is missing on this machine. Get it once, in this order:\n";
    for (size_t i = 0; i < missing.size(); ++i) text += formatText("  {}. {}\n", i + 1, missing[i]);
    return text;
}

}  // namespace dpl
