// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage_closeups.h"

#include <algorithm>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/input/observe/closeup_masks.h"
#include "reconstruction/run/scan_inputs.h"
#include "reconstruction/run/stage_cameras.h"
#include "reconstruction/run/stage_observe.h"
#include "sdk/core/files.h"

namespace dpl {

using nlohmann::json;

namespace {

bool isInside(const std::filesystem::path& file, const std::filesystem::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

}  // namespace

Status StageOf<CloseupMasks>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const SeenScan* seen, in.part<SeenScan>());
    DPL_TRY(const PlacedScan* placed, in.part<PlacedScan>());
    in.value("scan", scanInputs(placed->scan, placed->hashes));
    return {};
}

Status StageOf<CloseupMasks>::make(StageInputs& in, StageContext& context) {
    DPL_TRY(const SeenScan* seen, in.of<SeenScan>());
    DPL_TRY(const PlacedScan* placed, in.of<PlacedScan>());
    const Scan& scan = placed->scan;
    const auto isFound = [&](const ScanFrame& frame) { return isInside(frame.maskPath, seen->found); };
    DPL_TRY(const std::vector<CloseupMask> checked, checkCloseupMasks(scan, isFound, in.jobs()));
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
        DPL_RETURN_IF_ERROR(writeFileAtomically(path, bytes));
    }
    return writeFileAtomically(context.folder / "closeups.json", closeups.dump(1));
}

Result<CloseupMasks> StageOf<CloseupMasks>::read(StageInputs&, const std::filesystem::path& folder) {
    DPL_TRY(const auto bytes, readFile(folder / "closeups.json", 64 << 20));
    const json closeups = json::parse(bytes, nullptr, false);
    CloseupMasks masks{folder, {}, 0};
    for (const json& closeup : closeups.is_array() ? closeups : json::array())
        if (closeup.value("contradicted", false))
            masks.contradicted.insert(closeup.value("name", "")), masks.replaced += closeup.value("replaced", false);
    return masks;
}

Status StageOf<CompleteScan>::inputs(StageInputs& in) {
    DPL_TRY(const SeenScan* seen, in.part<SeenScan>());
    DPL_TRY([[maybe_unused]] const PlacedScan* placed, in.part<PlacedScan>());
    return seen->found.empty() ? Status{} : in.use<CloseupMasks>();
}

Result<CompleteScan> StageOf<CompleteScan>::compute(StageInputs& in) {
    DPL_TRY(const PlacedScan* placed, in.of<PlacedScan>());
    CompleteScan complete{placed->scan, placed->hashes, placed->camerasFound};
    if (!in.has<CloseupMasks>()) return complete;
    DPL_TRY(const CloseupMasks* masks, in.of<CloseupMasks>());
    for (ScanFrame& frame : complete.scan.frames)
        if (masks->contradicted.contains(frame.name)) frame.maskPath = masks->folder / (frame.name + ".png");
    complete.hashes = hashFrames(complete.scan, placed->scan, placed->hashes);
    if (!masks->contradicted.empty())
        in.progress().note(formatText("{} masks of close-ups are empty or not the person's; the full-body pictures replace {} of them",
                                      masks->contradicted.size(), masks->replaced));
    return complete;
}

}  // namespace dpl
