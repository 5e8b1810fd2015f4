// SPDX-License-Identifier: Apache-2.0
// Reads a COLMAP sparse model with its image folder. Optional masks are masks/NAME.png or, as COLMAP names them, masks/NAME.EXT.png. Frames
// named close… are close-ups and frames named dyn… are dynamic, as in avatar-scan folders.
#include <algorithm>

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

bool holdsPictures(const fs::path& root) {
    return picturesOf(root) != root;
}

bool liesIn(const fs::path& path, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/** A project with its largest model. */
ColmapProject projectOf(const fs::path& root, const std::vector<ColmapModelFolder>& models) {
    constexpr size_t kMaxNamed = 5;
    ColmapProject project{root, models.front().folder, {}};
    if (models.size() == 1) return project;
    const auto nameOf = [&](const ColmapModelFolder& m) {
        return formatText("{} ({} images)", m.folder.lexically_relative(root).generic_string(), m.images);
    };
    std::string left;
    for (size_t i = 1; i < std::min(models.size(), kMaxNamed + 1); ++i) left += (i > 1 ? ", " : "") + nameOf(models[i]);
    project.note =
        formatText("of {} COLMAP models {} is taken, which has the most images; left: {}{}. To take another, give its folder: {}",
                   models.size(), nameOf(models[0]), left, models.size() > kMaxNamed + 1 ? ", ..." : "", models[1].folder.string());
    return project;
}

/** The undistorted project of COLMAP's dense folder, which is dense/0 in an automatic reconstruction: the one with the most images. */
std::optional<ColmapProject> denseProject(const fs::path& folder) {
    constexpr int kMaxDense = 100;
    std::vector<ColmapModelFolder> found;
    for (const fs::path& dense : {folder, folder / "dense"}) {
        for (int i = -1; i < kMaxDense; ++i) {
            const fs::path root = i < 0 ? dense : dense / std::to_string(i);
            if (root == folder || !holdsPictures(root)) continue;
            if (const auto models = findColmapModels(root); !models.empty()) found.push_back(models.front());
        }
    }
    if (found.empty()) return std::nullopt;
    if (found.size() > 1)
        for (ColmapModelFolder& model : found) {
            std::vector<UnreadColmapImage> unread;
            const auto images = readColmapModel(model.folder, &unread);
            model.images = images ? images->size() : 0;
        }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.images > b.images; });
    ColmapProject project = projectOf(folder, found);
    project.root = project.model;
    while (!holdsPictures(project.root)) project.root = project.root.parent_path();
    return project;
}

/** Sets the picture and gives the camera its size; the mask must have it too. Whether the camera was scaled. */
Result<bool> fitToFiles(ScanFrame& frame, const fs::path& picture, const std::string& where) {
    frame.imagePath = picture;
    DPL_TRY(const ImageHeader header, probeCompleteImage(picture));
    if (!frame.maskPath.empty()) {
        DPL_TRY(const ImageHeader mask, probeCompleteImage(frame.maskPath));
        DPL_RETURN_IF_ERROR(checkMaskSize(mask, header, frame.maskPath));
    }
    return fitToPicture(frame.camera, header, picture, where);
}

}  // namespace

std::optional<ColmapProject> findColmapProject(const fs::path& folder) {
    constexpr int kMostAbove = 3;  // colmap/sparse/0
    const bool named = isColmapModel(folder) && !holdsPictures(folder);
    fs::path root = folder;
    for (int above = 0; above <= kMostAbove; ++above, root = root.parent_path()) {
        if (!holdsPictures(root)) continue;
        std::vector<ColmapModelFolder> models = findColmapModels(root);
        std::erase_if(models, [&](const auto& m) { return named ? m.folder != folder : !liesIn(m.folder, folder); });
        if (!models.empty()) return projectOf(root, models);
    }
    if (auto dense = denseProject(folder)) return dense;
    const auto models = findColmapModels(folder);
    if (models.empty()) return std::nullopt;
    return projectOf(folder, models);
}

Result<Scan> readColmapScan(const ColmapProject& project) {
    const fs::path &root = project.root, &model = project.model;
    std::vector<UnreadColmapImage> unread;
    DPL_TRY(auto images, readColmapModel(model, &unread));
    Scan scan;
    scan.source = ScanSource::Colmap;
    scan.root = root;
    scan.name = root.filename().string();
    scan.metricWorld = false;
    scan.splitStated = false;
    std::error_code ignored;
    const fs::path pictures = picturesOf(root);
    size_t scaled = 0;
    LeftOut left;
    for (const UnreadColmapImage& image : unread) left.add(withSlashes(image.name), image.why);
    for (auto& image : images) {
        ScanFrame frame;
        frame.name = nameFromPath(image.name);
        const std::string relative = withSlashes(image.name);
        const std::string where = formatText("{} image '{}'", model.string(), image.name.substr(0, 200));
        const auto picture = fileInside(pictures, convertedName(pictures, relative), where);
        if (!picture && picture.error().code != Code::NotFound) return picture.error();
        const fs::path stem = fs::path(relative).replace_extension();
        for (const std::string& mask : {stem.string() + ".png", relative + ".png"}) {
            if (!frame.maskPath.empty() || !fs::exists(root / "masks" / mask, ignored)) continue;
            DPL_TRY(frame.maskPath, fileInside(root / "masks", mask, where + " mask"));
        }
        frame.camera = image.camera;
        frame.lens = image.lens;
        const auto fitted = picture ? fitToFiles(frame, *picture, where) : picture.error();
        if (!fitted) {
            left.add(relative, fitted.error());
            continue;
        }
        scaled += *fitted;
        if (frame.name.starts_with("close"))
            frame.kind = FrameKind::StaticCloseup;
        else if (frame.name.starts_with("dyn"))
            frame.kind = FrameKind::Dynamic;
        scan.frames.push_back(std::move(frame));
    }
    DPL_RETURN_IF_ERROR(leaveOutDamaged(scan, pictures, left));
    DPL_RETURN_IF_ERROR(left.check(scan.frames.size()));
    addAssumption(scan, project.note);
    addAssumption(scan, left.sentence(images.size() + unread.size()));
    noteScaledCameras(scan, scaled);
    numberEqualNames(scan.frames);
    DPL_RETURN_IF_ERROR(finishScan(scan));
    return scan;
}

}  // namespace dpl
