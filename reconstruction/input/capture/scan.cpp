// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <span>

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "sdk/core/jobs.h"
#include "sdk/core/task.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr const char* kKindNames[] = {"static_full", "static_closeup", "dynamic"};
constexpr const char* kShortKindNames[] = {"static", "close-up", "dynamic"};
constexpr const char* kSplitNames[] = {"train", "validation", "test"};

template <class Enum>
std::optional<Enum> named(std::span<const char* const> names, std::string_view name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return Enum(found - names.begin());
}

Status checkSize(const fs::path& path, const Camerad& camera, const ScanFrame& frame) {
    DPL_TRY(const ImageHeader header, probeImage(path));
    if (header.widthPx != camera.widthPx || header.heightPx != camera.heightPx)
        return fail(Code::CorruptData, "frame '{}': {} is {} x {} pixels, its camera says {} x {}; resize it or correct the intrinsics",
                    frame.name, path.string(), header.widthPx, header.heightPx, camera.widthPx, camera.heightPx);
    return {};
}

/** Holds out every tenth static full-body frame, starting with the sixth, so that the first picture of an orbit stays in training. */
void holdOutFrames(Scan& scan) {
    std::vector<ScanFrame*> full;
    for (auto& frame : scan.frames)
        if (frame.kind == FrameKind::StaticFull) full.push_back(&frame);
    if (full.size() < 4) return;  // too few to hold one out
    for (size_t i = std::min<size_t>(5, full.size() / 2); i < full.size(); i += 10) full[i]->split = Split::Test;
}

}  // namespace

void LeftOut::add(const fs::path& picture, const Error& why) {
    names_.push_back(picture.generic_string());
    if (!first_) first_ = why;
}

std::string LeftOut::sentence(size_t all, const char* what) const {
    constexpr size_t kMaxNamed = 8;
    if (names_.empty()) return {};
    std::string text;
    for (size_t i = 0; i < std::min(names_.size(), kMaxNamed); ++i) text += (i > 0 ? ", " : "") + names_[i];
    return formatText("{} of {} {} are left out: {}{} ({}{})", names_.size(), all, what, text, names_.size() > kMaxNamed ? ", ..." : "",
                      names_.size() > 1 ? "the first: " : "", first_->message);
}

Status LeftOut::check(size_t kept) const {
    if (kept == 0 && first_) return *first_;
    return {};
}

std::string convertedName(const fs::path& root, const std::string& relative) {
    std::string extension = fs::path(relative).extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    std::error_code ignored;
    const bool heic = extension == ".heic" || extension == ".heif";
    return heic && fs::exists(root / (relative + ".jpg"), ignored) ? relative + ".jpg" : relative;
}

Status leaveOutDamaged(Scan& scan, const fs::path& pictures, LeftOut& left) {
    const auto checkFrame = [](const ScanFrame& frame) {
        Status sound = checkPicturePixels(frame.imagePath);
        if (sound && !frame.maskPath.empty()) sound = checkPicturePixels(frame.maskPath);
        return sound;
    };
    std::vector<Status> sound(scan.frames.size());
    Jobs jobs;
    for (size_t begin = 0; begin < sound.size(); begin += jobs.threadCount()) {
        DPL_RETURN_IF_ERROR(taskAt(double(begin) / double(sound.size())));
        jobs.forBlocks(std::min<size_t>(jobs.threadCount(), sound.size() - begin),
                       [&](size_t block, uint32_t) { sound[begin + block] = checkFrame(scan.frames[begin + block]); });
    }
    std::vector<ScanFrame> kept;
    for (size_t i = 0; i < sound.size(); ++i) {
        if (sound[i])
            kept.push_back(std::move(scan.frames[i]));
        else if (sound[i].error().code == Code::CorruptData)
            left.add(scan.frames[i].imagePath.lexically_relative(pictures), sound[i].error());
        else
            return sound[i];
    }
    scan.frames = std::move(kept);
    return {};
}

void numberEqualNames(std::vector<ScanFrame>& frames) {
    std::set<std::string> taken;
    for (const ScanFrame& frame : frames) taken.insert(frame.name);
    std::map<std::string, fs::path> first;
    for (ScanFrame& frame : frames) {
        const auto [at, fresh] = first.emplace(frame.name, frame.imagePath);
        if (fresh || at->second == frame.imagePath) continue;  // finishScan() refuses one picture for two frames
        for (size_t number = 2;; ++number)
            if (std::string name = numberedName(frame.name, number); taken.insert(name).second) {
                frame.name = std::move(name);
                break;
            }
    }
}

const char* frameKindName(FrameKind kind) {
    return kKindNames[size_t(kind)];
}

const char* shortKindName(FrameKind kind) {
    return kShortKindNames[size_t(kind)];
}

const char* splitName(Split split) {
    return kSplitNames[size_t(split)];
}

std::optional<FrameKind> frameKindNamed(std::string_view name) {
    return named<FrameKind>(kKindNames, name);
}

std::optional<Split> splitNamed(std::string_view name) {
    return named<Split>(kSplitNames, name);
}

Status finishScan(Scan& scan) {
    const std::string root = scan.root.string();
    if (scan.frames.empty()) return fail(Code::CorruptData, "{}: the scan has no frame; add images", root);
    if (scan.frames.size() > kMaxFrames)
        return fail(Code::Unsupported, "{}: {} frames, at most {} are read; remove some frames from the scan", root, scan.frames.size(),
                    kMaxFrames);
    std::set<std::string> names;
    std::set<fs::path> images;
    for (auto& frame : scan.frames) {
        if (!isSafeName(frame.name))
            return fail(Code::CorruptData, "{}: '{}' cannot be a frame name; use letters, digits, '.', '_' and '-', at most 128", root,
                        frame.name.substr(0, 200));
        if (!names.insert(frame.name).second)
            return fail(Code::CorruptData, "{}: the frame name '{}' is used twice; rename one", root, frame.name);
        if (!images.insert(frame.imagePath).second)
            return fail(Code::CorruptData, "{}: {} belongs to two frames; remove one of them", root, frame.imagePath.string());
        DPL_RETURN_IF_ERROR(checkSize(frame.imagePath, frame.camera, frame));
        if (!frame.maskPath.empty()) DPL_RETURN_IF_ERROR(checkSize(frame.maskPath, frame.camera, frame));
        if (!frame.labelsPath.empty()) DPL_RETURN_IF_ERROR(checkSize(frame.labelsPath, frame.camera, frame));
    }
    if (!scan.splitStated) holdOutFrames(scan);
    return {};
}

namespace {

Result<Scan> readAny(const fs::path& given) {
    std::error_code error;
    fs::path root = given, manifest;
    if (fs::is_regular_file(given, error)) manifest = given, root = given.parent_path();  // `given` may be the manifest itself
    if (!fs::is_directory(root.empty() ? "." : root, error))
        return fail(Code::NotFound, "{}: no such folder; give the folder that holds scan.json, transforms.json or a COLMAP model",
                    given.string());
    root = fs::absolute(root, error).lexically_normal();
    if (!root.has_filename()) root = root.parent_path();
    const auto holds = [&](const char* name) { return manifest.empty() ? fs::exists(root / name, error) : manifest.filename() == name; };
    if (holds("scan.json")) return readScanFolder(root / "scan.json");
    if (holds("transforms.json")) return readNerfstudio(root / "transforms.json");
    if (manifest.empty())
        if (const auto project = findColmapProject(root)) return readColmapScan(*project);
    return fail(Code::NotFound,
                "{}: neither scan.json nor transforms.json nor a COLMAP model (sparse/0/cameras.bin) is there; see docs/formats/scan.md",
                given.string());
}

}  // namespace

Result<Scan> readScan(const fs::path& given, ScanCameras cameras) {
    DPL_TRY(Scan scan, readAny(given));
    if (!scan.camerasKnown && cameras == ScanCameras::Needed)
        return fail(Code::InvalidArgument, "{}: no frame has a camera; 'doppel cameras' and 'doppel reconstruct' find them",
                    given.string());
    return scan;
}

}  // namespace dpl
