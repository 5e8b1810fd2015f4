// SPDX-License-Identifier: Apache-2.0
// Reads a COLMAP sparse model with its image folder. Optional masks are masks/NAME.png or, as COLMAP names them, masks/NAME.EXT.png. Frames
// named close… are close-ups and frames named dyn… are dynamic, as in avatar-scan folders.
#include "reconstruction/input/cameras/colmap_model.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

/** Where the pictures of a project lie: in images, in input (as scripts around COLMAP have it), or in the project's folder itself. */
fs::path picturesOf(const fs::path& root) {
    std::error_code ignored;
    for (const char* inside : {"images", "input"})
        if (fs::is_directory(root / inside, ignored)) return root / inside;
    return root;
}

}  // namespace

fs::path colmapRoot(const fs::path& folder) {
    if (findColmapModel(folder).empty() && findColmapModel(folder / "0").empty()) return {};
    fs::path root = folder;
    for (int levels = 0; levels < 3; ++levels, root = root.parent_path())
        if (picturesOf(root) != root && !findColmapModel(root).empty()) return root;
    return folder;
}

Result<Scan> readColmapScan(const fs::path& root, const fs::path& model) {
    DPL_TRY(auto images, readColmapModel(model));
    Scan scan;
    scan.source = ScanSource::Colmap;
    scan.root = root;
    scan.name = root.filename().string();
    scan.metricWorld = false;
    scan.splitStated = false;
    std::error_code ignored;
    const fs::path pictures = picturesOf(root);
    size_t scaled = 0;
    for (auto& image : images) {
        ScanFrame frame;
        frame.name = nameFromPath(image.name);
        const std::string where = formatText("{} image '{}'", model.string(), image.name.substr(0, 200));
        DPL_TRY(frame.imagePath, fileInside(pictures, image.name, where));
        const fs::path stem = fs::path(image.name).replace_extension();
        for (const std::string& mask : {stem.string() + ".png", image.name + ".png"}) {
            if (!frame.maskPath.empty() || !fs::exists(root / "masks" / mask, ignored)) continue;
            DPL_TRY(frame.maskPath, fileInside(root / "masks", mask, where + " mask"));
        }
        if (frame.name.starts_with("close"))
            frame.kind = FrameKind::StaticCloseup;
        else if (frame.name.starts_with("dyn"))
            frame.kind = FrameKind::Dynamic;
        frame.camera = image.camera;
        frame.lens = image.lens;
        DPL_TRY(const ImageHeader header, probeImage(frame.imagePath));
        DPL_TRY(const bool fitted, fitToPicture(frame.camera, header, frame.imagePath, where));
        scaled += fitted;
        scan.frames.push_back(std::move(frame));
    }
    noteScaledCameras(scan, scaled);
    DPL_RETURN_IF_ERROR(finishScan(scan));
    return scan;
}

}  // namespace dpl
