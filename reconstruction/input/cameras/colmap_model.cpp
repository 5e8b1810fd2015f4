// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/colmap_model.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <utility>

#include "reconstruction/input/cameras/camera_convention.h"
#include "sdk/core/numbers.h"
#include "sdk/core/reader.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kMaxModelBytes = 1ull << 30;
constexpr uint64_t kMaxEntries = 100000;
constexpr size_t kMaxNameBytes = 1024;

struct ColmapCamera {
    Camerad camera;
    LensDistortion lens;
};
/** Cameras by their numbers. One that cannot be read is an error only for the images that use it. */
struct Cameras {
    std::map<uint32_t, ColmapCamera> read;
    std::map<uint32_t, std::string> otherLens;  // name of the camera model
    std::map<uint32_t, Error> damaged;
    bool has(uint32_t id) const { return read.count(id) + otherLens.count(id) + damaged.count(id) > 0; }
};

/** Images that can be used, and others. */
struct Images {
    std::vector<ColmapImage> read;
    std::vector<UnreadColmapImage> unread;
};

struct ModelKind {
    int32_t id;
    const char* name;
    uint32_t parameterCount;
    bool read = true;
};
constexpr std::array kModels{ModelKind{0, "SIMPLE_PINHOLE", 3},
                             ModelKind{1, "PINHOLE", 4},
                             ModelKind{2, "SIMPLE_RADIAL", 4},
                             ModelKind{3, "RADIAL", 5},
                             ModelKind{4, "OPENCV", 8},
                             ModelKind{5, "OPENCV_FISHEYE", 8, false},
                             ModelKind{6, "FULL_OPENCV", 12, false},
                             ModelKind{7, "FOV", 5, false},
                             ModelKind{8, "SIMPLE_RADIAL_FISHEYE", 4, false},
                             ModelKind{9, "RADIAL_FISHEYE", 5, false},
                             ModelKind{10, "THIN_PRISM_FISHEYE", 12, false},
                             ModelKind{11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, false}};

Error unsupportedModel(const std::string& where, std::string_view model) {
    return fail(Code::Unsupported,
                "{}: camera model {} is not read; undistort the images with 'colmap image_undistorter', which writes PINHOLE cameras",
                where, model);
}

Result<std::string> readWhole(const fs::path& path) {
    std::error_code error;
    const auto bytes = fs::file_size(path, error);
    if (error || !fs::is_regular_file(path, error))
        return fail(Code::NotFound, "{}: not found; export the COLMAP model again", path.string());
    if (bytes > kMaxModelBytes)
        return fail(Code::Unsupported, "{}: {} bytes, at most 1 GiB is read; export a model without points", path.string(), bytes);
    std::ifstream in(path, std::ios::binary);
    std::string text(bytes, '\0');
    if (!in.read(text.data(), std::streamsize(bytes))) return fail(Code::Io, "{}: cannot be read; check its permissions", path.string());
    return text;
}

/** Camera from parameters in COLMAP's order. */
ColmapCamera makeCamera(int32_t model, uint64_t width, uint64_t height, std::span<const double> p) {
    ColmapCamera c;
    c.camera.widthPx = uint32_t(std::min<uint64_t>(width, UINT32_MAX));
    c.camera.heightPx = uint32_t(std::min<uint64_t>(height, UINT32_MAX));
    const bool single = model == 0 || model == 2 || model == 3;  // one focal length
    c.camera.fx = p[0];
    c.camera.fy = single ? p[0] : p[1];
    c.camera.cx = p[single ? 1 : 2];
    c.camera.cy = p[single ? 2 : 3];
    if (model == 2) c.lens.k1 = p[3];
    if (model == 3) c.lens.k1 = p[3], c.lens.k2 = p[4];
    if (model == 4) c.lens = {p[4], p[5], p[6], p[7]};
    return c;
}

Status addCamera(Cameras& cameras, uint32_t id, const ColmapCamera& camera, const std::string& file) {
    const std::string where = formatText("{} camera {}", file, id);
    if (cameras.has(id)) return fail(Code::CorruptData, "{} is listed twice; export the model again", where);
    Camerad probe = camera.camera;  // checks the intrinsics; the pose is still the identity
    Status sound = checkCamera(probe, where);
    if (sound) sound = checkDistortion(camera.lens, camera.camera, where);
    if (sound)
        cameras.read.emplace(id, camera);
    else
        cameras.damaged.emplace(id, sound.error());
    return {};
}

Status addOtherLens(Cameras& cameras, uint32_t id, std::string_view model, const std::string& file) {
    constexpr size_t kMaxNamed = 60;
    if (cameras.has(id)) return fail(Code::CorruptData, "{} camera {} is listed twice; export the model again", file, id);
    cameras.otherLens.emplace(id, model.substr(0, kMaxNamed));
    return {};
}

/** What an image line or entry states. */
struct ImageEntry {
    std::string name;
    uint32_t cameraId = 0;
    std::array<double, 4> q{};
    Vec3d t{0};
};

Result<ColmapImage> imageOf(const Cameras& cameras, const ImageEntry& entry, const fs::path& imagesFile, const fs::path& camerasFile) {
    const std::string where = formatText("{} image '{}'", imagesFile.string(), entry.name);
    if (const auto lens = cameras.otherLens.find(entry.cameraId); lens != cameras.otherLens.end())
        return unsupportedModel(formatText("{} camera {}", camerasFile.string(), entry.cameraId), lens->second);
    if (const auto damaged = cameras.damaged.find(entry.cameraId); damaged != cameras.damaged.end()) return damaged->second;
    const auto found = cameras.read.find(entry.cameraId);
    if (found == cameras.read.end())
        return fail(Code::CorruptData, "{} uses camera {}, which the model does not list; export it again", where, entry.cameraId);
    ColmapImage image{entry.name, found->second.camera, found->second.lens};
    setColmapPose(image.camera, entry.q, entry.t);
    DPL_RETURN_IF_ERROR(checkCamera(image.camera, where));
    return image;
}

Status addImage(Images& images, const Cameras& cameras, ImageEntry entry, const fs::path& file) {
    if (entry.name.empty() || entry.name.size() > kMaxNameBytes)
        return fail(Code::CorruptData, "{}: an image has no usable name; export the model again", file.string());
    auto image = imageOf(cameras, entry, file, file.parent_path() / ("cameras" + file.extension().string()));
    if (image)
        images.read.push_back(std::move(*image));
    else
        images.unread.push_back({std::move(entry.name), image.error()});
    if (images.read.size() + images.unread.size() > kMaxEntries)
        return fail(Code::Unsupported, "{}: more than {} images; split the model", file.string(), kMaxEntries);
    return {};
}

// ── text ────────────────────────────────────────────────────────────────────────────────────────────────────────────────────────

struct Lines {
    std::string_view rest;
    bool next(std::string_view& line) {
        if (rest.empty()) return false;
        const size_t end = rest.find('\n');
        line = rest.substr(0, end);
        rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return true;
    }
};

std::string_view nextWord(std::string_view& line) {
    const size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
    const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    const auto word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

template <class T>
bool parse(std::string_view& line, T& value) {
    return readNumber(nextWord(line), value);
}

Result<Cameras> readCamerasText(const fs::path& path, std::string_view text) {
    Cameras cameras;
    Lines lines{text};
    std::string_view line;
    for (size_t number = 1; lines.next(line); ++number) {
        if (line.find_first_not_of(" \t") == std::string_view::npos || line.front() == '#') continue;
        const std::string where = formatText("{} line {}", path.string(), number);
        uint32_t id = 0;
        uint64_t width = 0, height = 0;
        if (!parse(line, id)) return fail(Code::CorruptData, "{}: a camera number is expected; export the model again", where);
        const auto name = nextWord(line);
        const auto* kind = std::find_if(kModels.begin(), kModels.end(), [&](const ModelKind& k) { return name == k.name; });
        if (kind == kModels.end() || !kind->read) {
            DPL_RETURN_IF_ERROR(addOtherLens(cameras, id, name, path.string()));
            continue;
        }
        std::array<double, 8> p{};
        bool good = parse(line, width) && parse(line, height);
        for (uint32_t i = 0; i < kind->parameterCount; ++i) good = good && parse(line, p[i]);
        if (!good || !nextWord(line).empty())
            return fail(Code::CorruptData, "{}: {} wants width, height and {} numbers; export the model again", where, name,
                        kind->parameterCount);
        DPL_RETURN_IF_ERROR(addCamera(cameras, id, makeCamera(kind->id, width, height, p), path.string()));
    }
    return cameras;
}

/** Whether a line holds an image's 2D points: nothing, or triples of numbers. A line of an image has ten words. */
bool isPointsLine(std::string_view line) {
    size_t words = 0;
    for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line), ++words)
        if (double ignored = 0; !readNumber(word, ignored)) return false;
    return words % 3 == 0;
}

Result<Images> readImagesText(const fs::path& path, std::string_view text, const Cameras& cameras) {
    Images images;
    Lines lines{text};
    std::string_view line;
    bool pointsMayFollow = false;
    for (size_t number = 1; lines.next(line); ++number) {
        if (!line.empty() && line.front() == '#') continue;
        if (std::exchange(pointsMayFollow, false) && isPointsLine(line)) continue;
        if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
        uint32_t id = 0;
        ImageEntry entry;
        auto& [name, cameraId, q, t] = entry;
        bool good = parse(line, id) && parse(line, q[0]) && parse(line, q[1]) && parse(line, q[2]) && parse(line, q[3]);
        good = good && parse(line, t.x) && parse(line, t.y) && parse(line, t.z) && parse(line, cameraId);
        const size_t begin = line.find_first_not_of(" \t");
        if (!good || begin == std::string_view::npos)
            return fail(Code::CorruptData, "{} line {}: 'id qw qx qy qz tx ty tz camera name' is expected; export the model again",
                        path.string(), number);
        name = std::string(line.substr(begin));
        DPL_RETURN_IF_ERROR(addImage(images, cameras, std::move(entry), path));
        pointsMayFollow = true;
    }
    return images;
}

// ── binary ──────────────────────────────────────────────────────────────────────────────────────────────────────────────────────

std::span<const uint8_t> bytesOf(std::string_view text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

Result<uint64_t> readCount(Reader& in, size_t entryBytes, const fs::path& path) {
    DPL_TRY(const uint64_t count, in.value<uint64_t>());
    if (count > kMaxEntries || count > in.remaining() / entryBytes)
        return fail(Code::CorruptData, "{}: says {} entries, {} bytes are left; the file is cut or damaged, export the model again",
                    path.string(), count, in.remaining());
    return count;
}

Result<Cameras> readCamerasBinary(const fs::path& path, std::span<const uint8_t> bytes) {
    Reader in(bytes);
    Cameras cameras;
    DPL_TRY(const uint64_t count, readCount(in, 24 + 3 * 8, path));
    for (uint64_t i = 0; i < count; ++i) {
        DPL_TRY(const uint32_t id, in.u32());
        DPL_TRY(const int32_t model, in.value<int32_t>());
        DPL_TRY(const uint64_t width, in.value<uint64_t>());
        DPL_TRY(const uint64_t height, in.value<uint64_t>());
        const auto* kind = std::find_if(kModels.begin(), kModels.end(), [&](const ModelKind& k) { return model == k.id; });
        if (kind == kModels.end())  // how many numbers follow is unknown, so what comes behind it cannot be read
            return unsupportedModel(formatText("{} camera {}", path.string(), id), formatText("number {}", model));
        std::array<double, 16> p{};
        for (uint32_t k = 0; k < kind->parameterCount; ++k) {
            DPL_TRY(p[k], in.value<double>());
        }
        DPL_RETURN_IF_ERROR(kind->read ? addCamera(cameras, id, makeCamera(model, width, height, p), path.string())
                                       : addOtherLens(cameras, id, kind->name, path.string()));
    }
    return cameras;
}

Result<std::string> readName(Reader& in) {
    std::string name;
    for (;;) {
        DPL_TRY(const char c, in.value<char>());
        if (c == '\0') return name;
        name.push_back(c);
        if (name.size() > kMaxNameBytes) return fail(Code::CorruptData, "an image name is longer than {} bytes", kMaxNameBytes);
    }
}

Result<Images> readImagesBinary(const fs::path& path, std::span<const uint8_t> bytes, const Cameras& cameras) {
    Reader in(bytes);
    Images images;
    DPL_TRY(const uint64_t count, readCount(in, 4 + 7 * 8 + 4 + 1 + 8, path));
    for (uint64_t i = 0; i < count; ++i) {
        DPL_RETURN_IF_ERROR(in.skip(4));  // image id
        std::array<double, 7> pose{};
        for (double& v : pose) {
            DPL_TRY(v, in.value<double>());
        }
        DPL_TRY(const uint32_t cameraId, in.u32());
        DPL_TRY(std::string name, readName(in));
        DPL_TRY(const uint64_t points, in.value<uint64_t>());
        if (points > in.remaining() / 24)
            return fail(Code::CorruptData, "image '{}' says {} points, {} bytes are left", name, points, in.remaining());
        DPL_RETURN_IF_ERROR(in.skip(size_t(points) * 24));
        DPL_RETURN_IF_ERROR(addImage(images, cameras,
                                     {std::move(name), cameraId, {pose[0], pose[1], pose[2], pose[3]}, {pose[4], pose[5], pose[6]}}, path));
    }
    return images;
}

/** Adds file and remedy to an error of Reader, which only states offsets. */
Error namingFile(const Error& error, const fs::path& path) {
    if (error.message.find(path.string()) != std::string::npos) return error;
    return fail(error.code, "{}: {}; the file is cut or damaged, export the model again", path.string(), error.message);
}

/** Folders of a folder: 0, 1, … 10 by their number, then the others by name. At most 1000. */
std::vector<fs::path> numberedFoldersFirst(const fs::path& folder) {
    constexpr size_t kMaxFolders = 1000;
    std::vector<std::pair<uint64_t, fs::path>> found;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end && found.size() < kMaxFolders; at.increment(error)) {
        std::error_code ignored;
        uint64_t number = UINT64_MAX;
        if (!at->is_directory(ignored)) continue;
        (void)readNumber(at->path().filename().string(), number);
        found.emplace_back(number, at->path());
    }
    std::sort(found.begin(), found.end());
    std::vector<fs::path> folders;
    for (auto& [number, path] : found) folders.push_back(std::move(path));
    return folders;
}

}  // namespace

bool isColmapModel(const fs::path& folder) {
    std::error_code ignored;
    for (const char* extension : {".bin", ".txt"})
        if (fs::is_regular_file(folder / (std::string("cameras") + extension), ignored) &&
            fs::is_regular_file(folder / (std::string("images") + extension), ignored))
            return true;
    return false;
}

std::vector<ColmapModelFolder> findColmapModels(const fs::path& root) {
    std::vector<ColmapModelFolder> models;
    for (const char* inside : {"sparse", "colmap/sparse"}) {
        for (const fs::path& folder : numberedFoldersFirst(root / inside))
            if (isColmapModel(folder)) models.push_back({folder, 0});
        if (isColmapModel(root / inside)) models.push_back({root / inside, 0});
        if (!models.empty()) break;
    }
    if (models.empty() && isColmapModel(root)) models.push_back({root, 0});
    if (models.size() < 2) return models;
    for (ColmapModelFolder& model : models) {
        std::vector<UnreadColmapImage> unread;
        const auto images = readColmapModel(model.folder, &unread);
        model.images = images ? images->size() : 0;
    }
    std::stable_sort(models.begin(), models.end(), [](const auto& a, const auto& b) { return a.images > b.images; });
    return models;
}

fs::path findColmapModel(const fs::path& root) {
    const auto models = findColmapModels(root);
    return models.empty() ? fs::path() : models.front().folder;
}

Result<std::vector<ColmapImage>> decodeColmapModel(const ColmapBytes& bytes, const fs::path& folder,
                                                   std::vector<UnreadColmapImage>* unread) {
    Images images;
    if (bytes.binary) {
        const fs::path camerasPath = folder / "cameras.bin", imagesPath = folder / "images.bin";
        auto cameras = readCamerasBinary(camerasPath, bytesOf(bytes.cameras));
        if (!cameras) return namingFile(cameras.error(), camerasPath);
        auto read = readImagesBinary(imagesPath, bytesOf(bytes.images), *cameras);
        if (!read) return namingFile(read.error(), imagesPath);
        images = std::move(*read);
    } else {
        DPL_TRY(const Cameras cameras, readCamerasText(folder / "cameras.txt", bytes.cameras));
        DPL_TRY(images, readImagesText(folder / "images.txt", bytes.images, cameras));
    }
    if (images.read.empty() && images.unread.empty())
        return fail(Code::CorruptData, "{}: the model has no registered image; run COLMAP's mapper on more pictures", folder.string());
    const auto byName = [](const auto& a, const auto& b) { return a.name < b.name; };
    std::sort(images.read.begin(), images.read.end(), byName);
    std::sort(images.unread.begin(), images.unread.end(), byName);
    if (!images.unread.empty() && (!unread || images.read.empty())) return images.unread.front().why;
    if (unread) *unread = std::move(images.unread);
    return std::move(images.read);
}

Result<std::vector<ColmapImage>> readColmapModel(const fs::path& folder, std::vector<UnreadColmapImage>* unread) {
    std::error_code ignored;
    ColmapBytes bytes;
    bytes.binary = fs::exists(folder / "images.bin", ignored);
    DPL_TRY(const std::string cameras, readWhole(folder / (bytes.binary ? "cameras.bin" : "cameras.txt")));
    DPL_TRY(const std::string images, readWhole(folder / (bytes.binary ? "images.bin" : "images.txt")));
    bytes.cameras = cameras, bytes.images = images;
    return decodeColmapModel(bytes, folder, unread);
}

}  // namespace dpl
