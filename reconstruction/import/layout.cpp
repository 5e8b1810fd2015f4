// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/import/layout.h"

#include <algorithm>
#include <cctype>

#include "reconstruction/capture/scan_paths.h"
#include "reconstruction/import/neuman.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMaxListed = 100000;
constexpr size_t kFewestPhotos = 3;

bool isFile(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}
bool isFolder(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored);
}

std::string lowerCase(std::string text) {
    for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/** The folder that holds keyframes/, or nothing. */
fs::path polycamRoot(const fs::path& folder) {
    for (const fs::path& root : {folder, folder.parent_path()})
        if (isFolder(root / "keyframes/cameras") || isFolder(root / "keyframes/corrected_cameras"))
            if (root == folder || folder.filename() == "keyframes") return root;
    return {};
}

fs::path calibrationIn(const fs::path& folder) {
    for (const fs::path& file : filesWith(folder, {".txt", ".toml"})) {
        const std::string name = lowerCase(file.filename().string());
        if (name.ends_with(".qca.txt") || (name.ends_with(".toml") && name.find("calib") != std::string::npos)) return file;
    }
    return {};
}

/** What lies in a folder of no known layout, for the error. */
std::string describeFolder(const fs::path& folder) {
    const size_t pictures = picturesIn(folder).size(), videos = videosIn(folder).size();
    const size_t heic = filesWith(folder, {".heic", ".heif"}).size();
    if (heic > 0)
        return formatText(
            "it holds {} HEIC photos, which are not read; export them as JPEG (on an iPhone: Settings, Camera, Formats, Most "
            "Compatible) and run the same command on that folder",
            heic);
    if (videos > 0)
        return formatText(
            "it holds {} videos without a calibration; say what each one shows, for example 'doppel import --static {} -o scan'", videos,
            videosIn(folder).front().string());
    if (pictures > 0) return formatText("it holds {} pictures, at least {} are needed", pictures, kFewestPhotos);
    for (const char* inside : {"images", "rgb", "input"})
        if (const size_t count = picturesIn(folder / inside).size())
            return formatText("its folder {} holds {} pictures; 'doppel import {} -o scan' reads them as photos without cameras", inside,
                              count, (folder / inside).string());
    return "it holds neither pictures nor videos nor a file of cameras that we know; docs/formats/captures.md lists what is read";
}

}  // namespace

bool naturallyBefore(std::string_view a, std::string_view b) {
    const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
    size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (isDigit(a[i]) && isDigit(b[j])) {
            while (i < a.size() && a[i] == '0') ++i;
            while (j < b.size() && b[j] == '0') ++j;
            size_t endA = i, endB = j;
            while (endA < a.size() && isDigit(a[endA])) ++endA;
            while (endB < b.size() && isDigit(b[endB])) ++endB;
            if (endA - i != endB - j) return endA - i < endB - j;
            if (const int order = a.substr(i, endA - i).compare(b.substr(j, endB - j)); order != 0) return order < 0;
            i = endA, j = endB;
            continue;
        }
        if (a[i] != b[j]) return a[i] < b[j];
        ++i, ++j;
    }
    if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
    return a < b;  // "01" and "1"
}

std::vector<fs::path> filesWith(const fs::path& folder, std::initializer_list<const char*> extensions) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end && files.size() < kMaxListed; at.increment(error)) {
        const fs::path& path = at->path();
        const std::string extension = lowerCase(path.extension().string());
        const bool wanted = std::any_of(extensions.begin(), extensions.end(), [&](const char* e) { return extension == e; });
        if (wanted && path.filename().string().front() != '.' && isFile(path)) files.push_back(path);
    }
    std::sort(files.begin(), files.end(),
              [](const fs::path& a, const fs::path& b) { return naturallyBefore(a.filename().string(), b.filename().string()); });
    return files;
}

std::vector<fs::path> picturesIn(const fs::path& folder) {
    return filesWith(folder, {".jpg", ".jpeg", ".png"});
}

std::vector<fs::path> videosIn(const fs::path& folder) {
    return filesWith(folder, {".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi"});
}

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

Result<CaptureLayout> recogniseCapture(const fs::path& given) {
    std::error_code error;
    fs::path path = fs::absolute(given, error).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    if (isFile(path)) {
        const std::string name = lowerCase(path.filename().string());
        if (name == "scan.json") return CaptureLayout{CaptureKind::ScanFolder, path.parent_path(), {}};
        if (name == "transforms.json") return CaptureLayout{CaptureKind::Nerfstudio, path.parent_path(), {}};
        if (name.starts_with("transforms_") && name.ends_with(".json"))
            return CaptureLayout{CaptureKind::NerfSynthetic, path.parent_path(), {}};
        if (name.ends_with(".r3d")) return CaptureLayout{CaptureKind::Record3dFile, path, {}};
        if (name.ends_with(".qca.txt") || name.ends_with(".toml"))
            return CaptureLayout{CaptureKind::CalibratedVideos, path.parent_path(), path};
        const auto videos = videosIn(path.parent_path());
        if (std::find(videos.begin(), videos.end(), path) != videos.end()) return CaptureLayout{CaptureKind::Video, path, {}};
        return fail(Code::Unsupported,
                    "{} is not a capture that we know; give a folder, a video (mp4, mov, mkv, webm), a Record3D file (.r3d) or a "
                    "calibration (.qca.txt, .toml); docs/formats/captures.md lists what is read",
                    given.string());
    }
    if (!isFolder(path)) return fail(Code::NotFound, "{}: no such file or folder", given.string());
    if (isFile(path / "scan.json")) return CaptureLayout{CaptureKind::ScanFolder, path, {}};
    if (const fs::path root = polycamRoot(path); !root.empty()) return CaptureLayout{CaptureKind::Polycam, root, {}};
    if (isFile(path / "transforms.json")) return CaptureLayout{CaptureKind::Nerfstudio, path, {}};
    if (isFile(path / "transforms_train.json")) return CaptureLayout{CaptureKind::NerfSynthetic, path, {}};
    if ((isFile(path / "metadata.json") || isFile(path / "metadata")) && (isFolder(path / "rgb") || isFolder(path / "rgbd")))
        return CaptureLayout{CaptureKind::Record3dFolder, path, {}};
    if (isNeuman(path)) return CaptureLayout{CaptureKind::Neuman, path, {}};
    if (const fs::path root = colmapRoot(path); !root.empty()) return CaptureLayout{CaptureKind::Colmap, root, {}};
    if (const fs::path file = calibrationIn(path); !file.empty() && !videosIn(path).empty())
        return CaptureLayout{CaptureKind::CalibratedVideos, path, file};
    if (picturesIn(path).size() >= kFewestPhotos) return CaptureLayout{CaptureKind::Photos, path, {}};
    return fail(Code::Unsupported, "{} has no layout that we know: {}", given.string(), describeFolder(path));
}

}  // namespace dpl
