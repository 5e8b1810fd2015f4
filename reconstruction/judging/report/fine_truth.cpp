// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/fine_truth.h"

#include "reconstruction/input/capture/frame_picture.h"
#include "reconstruction/judging/report/score.h"

namespace dpl {

std::optional<FineTruth> fineTruth(const std::filesystem::path& scan, const std::string& frame, const Camerad& camera) {
    for (const uint32_t times : {4u, 2u}) {
        ScanFrame file;
        const std::filesystem::path folder = scan / "hires" / ("x" + std::to_string(times));
        file.name = frame;
        file.imagePath = folder / (frame + ".jpg"), file.maskPath = folder / (frame + ".mask.png");
        file.camera = camera.scaled(times);
        std::error_code missing;
        if (!std::filesystem::exists(file.imagePath, missing) || !std::filesystem::exists(file.maskPath, missing)) continue;
        if (const auto picture = readFramePicture(file))
            return FineTruth{cutOut(picture->image, picture->mask), file.camera.widthPx, file.camera.heightPx};
    }
    return std::nullopt;
}

}  // namespace dpl
