// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/layout.h"

#include <algorithm>
#include <optional>

#include "reconstruction/base/program.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/neuman.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr size_t kFewestPhotos = 3;

bool isFile(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}
bool isFolder(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored);
}

/** A Polycam capture whose folder, keyframes or one of the folders in it is given. */
std::optional<CaptureLayout> polycamAt(const fs::path& folder) {
    const auto holdsKeyframes = [](const fs::path& root) {
        return isFolder(root / "keyframes/cameras") || isFolder(root / "keyframes/corrected_cameras");
    };
    if (holdsKeyframes(folder)) return CaptureLayout{CaptureKind::Polycam, folder};
    const fs::path above = folder.parent_path();
    if (folder.filename() == "keyframes" && holdsKeyframes(above)) return CaptureLayout{CaptureKind::Polycam, above};
    const std::string name = folder.filename().string();
    const bool part = name == "cameras" || name == "images" || name == "corrected_cameras" || name == "corrected_images";
    if (part && above.filename() == "keyframes" && holdsKeyframes(above.parent_path()))
        return CaptureLayout{.kind = CaptureKind::Polycam, .root = above.parent_path(), .part = folder};
    return std::nullopt;
}

fs::path calibrationIn(const fs::path& folder) {
    for (const fs::path& file : filesWith(folder, {".txt", ".toml"})) {
        const std::string name = lowerCase(file.filename().string());
        if (name.ends_with(".qca.txt") || (name.ends_with(".toml") && name.find("calib") != std::string::npos)) return file;
    }
    return {};
}

/** How to unpack an archive: a sentence that ends in the commands. Empty: the file is no archive that we know. */
std::string howToUnpack(const fs::path& file) {
    const std::string name = lowerCase(file.filename().string());
    const bool zip = name.ends_with(".zip");
    if (!zip && !name.ends_with(".tar") && !name.ends_with(".tgz") && !name.ends_with(".tar.gz")) return {};
    fs::path folder = file;
    while (folder.has_extension()) folder.replace_extension();
    if (zip) return formatText("unpack it and import the folder: unzip {} -d {}", shellWord(file), shellWord(folder));
    return formatText("unpack it and import the folder: mkdir {} && tar -xf {} -C {}", shellWord(folder), shellWord(file),
                      shellWord(folder));
}

/** What lies in a folder of no known layout, for the error. */
std::string describeFolder(const fs::path& folder) {
    if (const auto heic = heicIn(folder); !heic.empty())
        return formatText("it holds {} HEIC photos, which are not read ({}); {}", heic.size(), namesOf(heic), howToConvertHeic(folder));
    const size_t pictures = picturesIn(folder).size();
    if (const auto others = otherPicturesIn(folder); !others.empty())
        return formatText("it holds {} pictures like {}, and only JPEG and PNG are read; convert them to JPEG", others.size(),
                          others.front().filename().string());
    if (const auto videos = videosIn(folder); !videos.empty())
        return formatText(
            "it holds {} videos without a calibration; say what each one shows, for example 'doppel import --static {} -o scan'",
            videos.size(), shellWord(videos.front()));
    if (pictures > 0) return formatText("it holds {} pictures, at least {} are needed", pictures, kFewestPhotos);
    for (const char* inside : {"images", "rgb", "input"})
        if (const size_t count = picturesIn(folder / inside).size())
            return formatText("its folder {} holds {} pictures, at least {} are needed", inside, count, kFewestPhotos);
    for (const fs::path& file : filesWith(folder, {".zip", ".tar", ".tgz", ".gz"}))
        if (const std::string how = howToUnpack(file); !how.empty())
            return formatText("it holds the archive {}; {}", file.filename().string(), how);
    return "it holds neither pictures nor videos nor a file of cameras that we know; docs/formats/captures.md lists what is read";
}

std::string videoEndings() {
    std::string text;
    for (const VideoEnding& ending : kVideoEndings) text += (text.empty() ? "" : ", ") + std::string(ending.extension + 1);
    return text;
}

Result<CaptureLayout> recogniseFile(const fs::path& path, const fs::path& given) {
    const std::string name = lowerCase(path.filename().string());
    if (name == "scan.json") return CaptureLayout{CaptureKind::ScanFolder, path.parent_path()};
    if (name == "transforms.json") return CaptureLayout{CaptureKind::Nerfstudio, path.parent_path()};
    if (name.starts_with("transforms_") && name.ends_with(".json")) return CaptureLayout{CaptureKind::NerfSynthetic, path.parent_path()};
    if (name.ends_with(".r3d")) return CaptureLayout{CaptureKind::Record3dFile, path};
    if (name.ends_with(".qca.txt") || name.ends_with(".toml"))
        return CaptureLayout{CaptureKind::CalibratedVideos, path.parent_path(), path};
    if (isVideo(path)) return CaptureLayout{CaptureKind::Video, path};
    if (const std::string how = howToUnpack(path); !how.empty())
        return fail(Code::Unsupported, "{} is an archive; {}", given.string(), how);
    if (isPicture(path) || isHeic(path))
        return fail(Code::Unsupported,
                    "{} is one picture, and a scan needs at least {} from all around; give the folder that holds them: {}", given.string(),
                    kFewestPhotos, path.parent_path().string());
    return fail(Code::Unsupported,
                "{} is not a capture that we know; give a folder, a video ({}), a Record3D file (.r3d) or a calibration (.qca.txt, .toml); "
                "docs/formats/captures.md lists what is read",
                given.string(), videoEndings());
}

std::optional<CaptureLayout> recogniseFolder(const fs::path& path) {
    if (isFile(path / "scan.json")) return CaptureLayout{CaptureKind::ScanFolder, path};
    if (auto polycam = polycamAt(path)) return polycam;
    if (isFile(path / "transforms.json")) return CaptureLayout{CaptureKind::Nerfstudio, path};
    if (isFile(path / "transforms_train.json")) return CaptureLayout{CaptureKind::NerfSynthetic, path};
    if ((isFile(path / "metadata.json") || isFile(path / "metadata")) && (isFolder(path / "rgb") || isFolder(path / "rgbd")))
        return CaptureLayout{CaptureKind::Record3dFolder, path};
    if (isNeuman(path)) return CaptureLayout{CaptureKind::Neuman, path};
    if (const auto project = findColmapProject(path))
        return CaptureLayout{.kind = CaptureKind::Colmap, .root = project->root, .part = path == project->root ? fs::path() : path};
    const std::vector<fs::path> videos = videosIn(path);
    if (const fs::path file = calibrationIn(path); !file.empty() && !videos.empty())
        return CaptureLayout{CaptureKind::CalibratedVideos, path, file};
    const size_t pictures = picturesIn(path).size();
    if (pictures >= kFewestPhotos) return CaptureLayout{CaptureKind::Photos, path, {}, leftBesidePhotos(path)};
    if (videos.size() != 1 || !heicIn(path).empty() || !otherPicturesIn(path).empty()) return std::nullopt;
    CaptureLayout video{
        CaptureKind::Video, videos.front(), {}, {"the only video of the folder is taken: " + videos.front().filename().string()}};
    if (pictures > 0)
        video.notes.push_back(
            formatText("{} pictures beside it are left out; a scan of photos needs at least {}", pictures, kFewestPhotos));
    return video;
}

/** The one capture in a folder of `path`. An error where there are several; nothing where there is none. */
Result<std::optional<CaptureLayout>> recogniseBelow(const fs::path& path, const fs::path& given) {
    constexpr size_t kMaxNamed = 5;
    std::optional<CaptureLayout> first;
    std::string names;
    size_t count = 0;
    for (const fs::path& folder : foldersIn(path)) {
        auto found = recogniseFolder(folder);
        if (!found) continue;
        if (++count <= kMaxNamed)
            names += formatText("{}{} ({})", count == 1 ? "" : ", ", folder.filename().string(), captureName(found->kind));
        if (count > 1) continue;
        first = std::move(found);
        first->foundIn = folder;
    }
    if (count > 1)
        return fail(Code::InvalidArgument, "{} holds {} captures: {}{}; name one of them, for example {}", given.string(), count, names,
                    count > kMaxNamed ? ", ..." : "", first->foundIn.string());
    if (first) first->notes.insert(first->notes.begin(), "the capture lies in " + first->foundIn.string());
    return first;
}

/** Adds the regular files below a folder. */
void addBelow(const fs::path& folder, std::vector<fs::path>& files) {
    constexpr size_t kMaxFiles = 100000;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end && files.size() < kMaxFiles; at.increment(error))
        if (isFile(at->path())) files.push_back(at->path());
}

}  // namespace

const char* captureName(CaptureKind kind) {
    switch (kind) {
        case CaptureKind::ScanFolder:
            return "a scan folder";
        case CaptureKind::Nerfstudio:
            return "a nerfstudio or NeRFCapture folder";
        case CaptureKind::NerfSynthetic:
            return "a NeRF-synthetic folder";
        case CaptureKind::Colmap:
            return "a COLMAP model";
        case CaptureKind::Neuman:
            return "a NeuMan subject";
        case CaptureKind::Polycam:
            return "Polycam raw data";
        case CaptureKind::Record3dFolder:
            return "a Record3D export";
        case CaptureKind::Record3dFile:
            return "a Record3D file";
        case CaptureKind::CalibratedVideos:
            return "calibrated, synchronised videos";
        case CaptureKind::Video:
            return "a video";
        case CaptureKind::Photos:
            return "a folder of photos";
    }
    return "unknown";
}

bool isReadableScan(const CaptureLayout& layout) {
    return layout.kind == CaptureKind::ScanFolder || layout.kind == CaptureKind::Nerfstudio || layout.kind == CaptureKind::Colmap;
}

std::vector<fs::path> filesOf(const CaptureLayout& layout) {
    std::vector<fs::path> files;
    switch (layout.kind) {
        case CaptureKind::Video:
        case CaptureKind::Record3dFile:
            return {layout.root};
        case CaptureKind::Photos:
            return picturesIn(layout.root);
        case CaptureKind::CalibratedVideos:
            files = videosIn(layout.root);
            files.push_back(layout.calibration);
            return files;
        case CaptureKind::Polycam:
            addBelow(layout.root / "keyframes", files);
            return files;
        case CaptureKind::Record3dFolder:
            for (const char* name : {"metadata.json", "metadata"})
                if (isFile(layout.root / name)) files.push_back(layout.root / name);
            for (const char* name : {"rgb", "rgbd"}) addBelow(layout.root / name, files);
            return files;
        default:
            addBelow(layout.root, files);
            return files;
    }
}

Result<CaptureLayout> recogniseCapture(const fs::path& given) {
    std::error_code error;
    fs::path path = fs::absolute(given, error).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    if (isFile(path)) return recogniseFile(path, given);
    const auto unreadable = [&] { return fail(Code::Io, "{} cannot be read: {}; check the permissions", given.string(), error.message()); };
    if (!fs::is_directory(path, error)) {
        if (error == std::errc::permission_denied) return unreadable();
        return fail(Code::NotFound, "{}: no such file or folder", given.string());
    }
    if (fs::directory_iterator(path, error); error) return unreadable();
    if (auto layout = recogniseFolder(path)) return std::move(*layout);
    if (picturesIn(path).empty() && videosIn(path).empty() && heicIn(path).empty() && otherPicturesIn(path).empty()) {
        DPL_TRY(auto below, recogniseBelow(path, given));
        if (below) return std::move(*below);
    }
    return fail(Code::Unsupported, "{} has no layout that we know: {}", given.string(), describeFolder(path));
}

}  // namespace dpl
