// SPDX-License-Identifier: Apache-2.0
// The stage closeups: holds found masks of close-ups against the full-body pictures.
#include <algorithm>
#include <set>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/observe/closeup_masks.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stages.h"
#include "sdk/core/files.h"

namespace dpl {

using nlohmann::json;

namespace {

bool isInside(const std::filesystem::path& file, const std::filesystem::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

Result<Scan> runCloseups(const StageRun& run, Scan scan, const std::filesystem::path& found) {
    const auto isFound = [&](const ScanFrame& frame) { return isInside(frame.maskPath, found); };
    const json inputs = {{"scan", scanInputs(scan, hashFrames(scan))}};
    DPL_TRY(const StageOutput stage, run.chain.run("closeups", 1, inputs, [&](StageContext& context) -> Status {
        DPL_TRY(const std::vector<CloseupMask> checked, checkCloseupMasks(scan, isFound, run.jobs));
        json closeups = json::array();
        for (const CloseupMask& closeup : checked) {
            const ScanFrame& frame = scan.frames[closeup.frame];
            closeups.push_back({{"name", frame.name},
                                {"agreement", closeup.agreement},
                                {"certainty", closeup.certainty},
                                {"contradicted", closeup.contradicted},
                                {"replaced", !closeup.mask.pixels.empty()}});
            if (!closeup.contradicted) continue;
            std::vector<uint8_t> mask = closeup.mask.pixels;
            mask.resize(size_t(frame.camera.widthPx) * frame.camera.heightPx, 0);  // an empty mask leaves the picture out
            DPL_TRY(const auto bytes, encodePng(mask, frame.camera.widthPx, frame.camera.heightPx, 1));
            const std::filesystem::path path = context.folder / (frame.name + ".png");
            std::error_code ignored;
            std::filesystem::create_directories(path.parent_path(), ignored);
            DPL_CHECK_OK(writeFileAtomically(path, bytes));
        }
        return writeFileAtomically(context.folder / "closeups.json", closeups.dump(1));
    }));
    DPL_TRY(const auto bytes, readFile(stage.folder / "closeups.json", 64 << 20));
    const json closeups = json::parse(bytes, nullptr, false);
    std::set<std::string> contradicted;
    size_t replaced = 0;
    for (const json& closeup : closeups.is_array() ? closeups : json::array())
        if (closeup.value("contradicted", false))
            contradicted.insert(closeup.value("name", "")), replaced += closeup.value("replaced", false);
    for (ScanFrame& frame : scan.frames)
        if (contradicted.contains(frame.name)) frame.maskPath = stage.folder / (frame.name + ".png");
    if (!contradicted.empty())
        run.progress.note(formatText("{} masks of close-ups are empty or not the person's; the full-body pictures replace {} of them",
                                     contradicted.size(), replaced));
    return scan;
}

}  // namespace dpl
