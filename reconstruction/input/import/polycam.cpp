// SPDX-License-Identifier: Apache-2.0
// Polycam's raw data, as exported in developer mode. Follows github.com/PolyCam/polyform (README, "Raw data") and its reader
// polyform/core/capture_folder.py. Every keyframe has a JSON file with intrinsics in pixels and the first three rows of a camera-to-world
// matrix t_00 … t_23. The world is ARKit's: metres, +Y up. Camera axes are OpenGL's. The corrected_ folders hold what Polycam's own
// optimisation made of them; it may leave keyframes out, which are then taken uncorrected. Newer versions of the app write no width and
// height there.
#include <array>
#include <map>

#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/readers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

Result<Camerad> parsePolycamCamera(const json& object, const ImageHeader& picture, const std::string& where) {
    const JsonFields fields(object, where);
    Camerad camera;
    DPL_TRY(camera.fx, fields.number("fx"));
    DPL_TRY(camera.fy, fields.number("fy"));
    DPL_TRY(camera.cx, fields.number("cx"));
    DPL_TRY(camera.cy, fields.number("cy"));
    DPL_RETURN_IF_ERROR(takeSize(camera, fields, "width", "height", picture));
    std::array<double, 16> pose{};
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column) {
            const char key[] = {'t', '_', char('0' + row), char('0' + column), '\0'};
            DPL_TRY(pose[row * 4 + column], fields.number(key));
        }
    setOpenglPose(camera, pose);
    DPL_RETURN_IF_ERROR(checkCamera(camera, where));
    return camera;
}

namespace {

/** Picture and camera file of a keyframe, of which either may be missing. */
struct Keyframe {
    fs::path image, camera;
    bool corrected = false;
};

/** The keyframes of one pair of folders, by name in natural order. */
struct NaturalOrder {
    bool operator()(const std::string& a, const std::string& b) const { return naturallyBefore(a, b); }
};
using Keyframes = std::map<std::string, Keyframe, NaturalOrder>;

Keyframes keyframesIn(const fs::path& folder, bool corrected) {
    const std::string prefix = corrected ? "corrected_" : "";
    Keyframes found;
    for (const fs::path& image : picturesIn(folder / (prefix + "images"))) found[image.stem().string()].image = image;
    for (const fs::path& camera : filesWith(folder / (prefix + "cameras"), {".json"})) found[camera.stem().string()].camera = camera;
    for (auto& [name, keyframe] : found) keyframe.corrected = corrected;
    return found;
}

/** Reads one keyframe's camera for its picture. */
Result<Camerad> readKeyframe(const Keyframe& keyframe) {
    const std::string where = keyframe.camera.string();
    DPL_TRY(const json object, readJsonObject(keyframe.camera));
    DPL_TRY(const ImageHeader header, probeImage(keyframe.image));
    DPL_TRY(Camerad camera, parsePolycamCamera(object, header, where));
    DPL_RETURN_IF_ERROR(fitToPicture(camera, header, keyframe.image, where));
    return camera;
}

}  // namespace

Result<Capture> readPolycam(const fs::path& root, const std::string& part) {
    constexpr size_t kMaxNamed = 8;
    const fs::path folder = root / "keyframes";
    const bool onlyCorrected = part.starts_with("corrected_"), onlyRaw = !part.empty() && !onlyCorrected;
    Keyframes keyframes = onlyCorrected ? Keyframes() : keyframesIn(folder, false);
    if (!onlyRaw)
        for (const auto& [name, keyframe] : keyframesIn(folder, true))
            if (!keyframe.image.empty() && !keyframe.camera.empty()) keyframes[name] = keyframe;
    Capture capture;
    size_t corrected = 0, withoutCamera = 0, withoutPicture = 0;
    std::string raw;
    LeftOut left;
    for (const auto& [name, keyframe] : keyframes) {
        withoutCamera += keyframe.camera.empty(), withoutPicture += keyframe.image.empty();
        if (keyframe.camera.empty() || keyframe.image.empty()) continue;
        if (capture.pictures.size() >= kMaxFrames)
            return fail(Code::Unsupported, "{}: more than {} keyframes; remove some", folder.string(), kMaxFrames);
        auto camera = readKeyframe(keyframe);
        if (!camera) {
            left.add(keyframe.image.filename(), camera.error());
            continue;
        }
        CapturePicture picture;
        picture.name = frameName(picture.kind, capture.pictures.size());
        picture.image = keyframe.image;
        picture.camera = *camera;
        capture.pictures.push_back(std::move(picture));
        corrected += keyframe.corrected;
        const size_t uncorrected = capture.pictures.size() - corrected;
        if (!keyframe.corrected && uncorrected <= kMaxNamed + 1)
            raw += (raw.empty() ? "" : ", ") + (uncorrected > kMaxNamed ? "..." : keyframe.image.filename().string());
    }
    DPL_RETURN_IF_ERROR(left.check(capture.pictures.size()));
    if (capture.pictures.empty())
        return fail(Code::CorruptData, "{}: no picture has a camera; export the raw data again with Polycam's developer mode on",
                    folder.string());
    const size_t uncorrected = capture.pictures.size() - corrected;
    capture.what = uncorrected == 0 ? "Polycam raw data, corrected by Polycam"
                   : corrected == 0 ? "Polycam raw data, uncorrected"
                                    : "Polycam raw data, partly corrected by Polycam";
    if (corrected > 0 && uncorrected > 0)
        capture.notes.push_back(
            formatText("{} of {} keyframes are taken uncorrected, because Polycam did not correct them: {}. To take the "
                       "corrected ones alone, give {}",
                       uncorrected, capture.pictures.size(), raw, (folder / "corrected_cameras").string()));
    if (withoutCamera > 0) capture.notes.push_back(formatText("{} pictures without a camera file are left out", withoutCamera));
    if (withoutPicture > 0) capture.notes.push_back(formatText("{} camera files without a picture are left out", withoutPicture));
    if (!left.empty()) capture.notes.push_back(left.sentence(keyframes.size(), "keyframes"));
    return capture;
}

}  // namespace dpl
