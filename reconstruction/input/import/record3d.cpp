// SPDX-License-Identifier: Apache-2.0
// Recordings of the iPhone app Record3D: the folder of its export "EXR + JPG sequence" (metadata.json, rgb/0.jpg …) or the content of an
// .r3d file (metadata, rgbd/0.jpg …). Follows record3d.app/features and the project's own loader, github.com/marek-simonik/record3d: K is
// 3 × 3 in column-major order, in pixels of a picture w × h; a pose is qx qy qz qw px py pz, camera to world, with ARKit's world (metres,
// +Y up) and OpenGL camera axes; perFrameIntrinsicCoeffs, where present, holds fx fy cx cy for each frame.
#include <algorithm>
#include <cmath>

#include "reconstruction/base/zip_file.h"
#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/layout.h"
#include "reconstruction/input/import/readers.h"
#include "sdk/core/files.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/** `count` finite numbers of a JSON array into `out`. */
bool readNumbers(const json& list, size_t count, double* out) {
    if (!list.is_array() || list.size() != count) return false;
    for (size_t i = 0; i < count; ++i) {
        if (!list[i].is_number() || !std::isfinite(list[i].get<double>())) return false;
        out[i] = list[i].get<double>();
    }
    return true;
}

void setPose(Camerad& camera, const double (&p)[7]) {
    const Mat3d r = glm::mat3_cast(glm::normalize(Quatd(p[3], p[0], p[1], p[2])));  // GLM's constructor takes w x y z
    const std::array<double, 16> matrix = {r[0][0], r[1][0], r[2][0], p[4], r[0][1], r[1][1], r[2][1], p[5],
                                           r[0][2], r[1][2], r[2][2], p[6], 0,       0,       0,       1};
    setOpenglPose(camera, matrix);
}

constexpr uint64_t kMaxRecordingBytes = uint64_t(4) << 30;
constexpr size_t kMaxEntryBytes = 64 << 20;

/** Whether an entry of the zip is needed: "metadata" or "rgbd/12.jpg". So no entry can name a path outside the folder. */
bool isWanted(const std::string& name) {
    if (name == "metadata") return true;
    if (!name.starts_with("rgbd/") || !name.ends_with(".jpg")) return false;
    const std::string number = name.substr(5, name.size() - 9);
    return !number.empty() && number.size() <= 9 && std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Result<Capture> readRecord3dFile(const fs::path& file, const fs::path& unpacked) {
    DPL_TRY(const auto bytes, readFile(file, kMaxRecordingBytes));
    const auto named = [&](const Error& error) {
        return fail(error.code, "{}: {}; export the recording again", file.string(), error.message);
    };
    auto zip = ZipFile::open(bytes);
    if (!zip) return named(zip.error());
    if (!zip->has("metadata"))
        return fail(Code::CorruptData, "{}: it has no entry 'metadata', so Record3D did not write it; export the recording again",
                    file.string());
    std::error_code error;
    fs::create_directories(unpacked / "rgbd", error);
    if (error) return fail(Code::Io, "cannot create {}: {}", unpacked.string(), error.message());
    LeftOut damaged;
    size_t wanted = 0;
    for (const std::string& name : zip->names()) {
        if (!isWanted(name)) continue;
        ++wanted;
        auto plain = zip->read(name, kMaxEntryBytes);
        if (!plain && name == "metadata") return named(plain.error());
        if (!plain) {
            damaged.add(name, named(plain.error()));
            continue;
        }
        DPL_RETURN_IF_ERROR(writeFileAtomically(unpacked / name, *plain));
    }
    DPL_TRY(Capture capture, readRecord3d(unpacked));
    if (!damaged.empty()) capture.notes.push_back(damaged.sentence(wanted - 1));
    return capture;
}

Result<Record3dFrames> parseRecord3d(const json& metadata, const ImageHeader& firstPicture, const std::string& where) {
    const JsonFields fields(metadata, where);
    Camerad shared;
    DPL_TRY(const auto k, fields.numbers("K", 9));
    shared.fx = k[0], shared.fy = k[4], shared.cx = k[6], shared.cy = k[7];  // column-major
    DPL_RETURN_IF_ERROR(takeSize(shared, fields, "w", "h", firstPicture));
    DPL_TRY(const json* poses, fields.array("poses"));
    if (poses->size() > kMaxFrames)
        return fail(Code::Unsupported, "{}: {} frames, at most {} are read; cut the recording", where, poses->size(), kMaxFrames);
    Record3dFrames frames;
    DPL_TRY(frames.framesPerSecond, fields.number("fps", 0));
    const json* perFrame = nullptr;
    if (fields.has("perFrameIntrinsicCoeffs")) {
        DPL_TRY(perFrame, fields.array("perFrameIntrinsicCoeffs"));
        if (perFrame->size() != poses->size())
            return fail(Code::CorruptData, "{}: {} intrinsics for {} poses; export the recording again", where, perFrame->size(),
                        poses->size());
    }
    for (size_t i = 0; i < poses->size(); ++i) {
        const std::string here = formatText("{} frame {}", where, i);
        Camerad camera = shared;
        double pose[7], f[4];
        const auto isTurn = [&] { return pose[0] * pose[0] + pose[1] * pose[1] + pose[2] * pose[2] + pose[3] * pose[3] > 1e-12; };
        if (!readNumbers((*poses)[i], 7, pose) || !isTurn())
            return fail(Code::CorruptData, "{}: its pose is not 7 numbers qx qy qz qw px py pz; export the recording again", here);
        if (perFrame) {
            if (!readNumbers((*perFrame)[i], 4, f))
                return fail(Code::CorruptData, "{}: its intrinsics are not 4 numbers fx fy cx cy; export the recording again", here);
            camera.fx = f[0], camera.fy = f[1], camera.cx = f[2], camera.cy = f[3];
        }
        setPose(camera, pose);
        DPL_RETURN_IF_ERROR(checkCamera(camera, here));
        frames.cameras.push_back(camera);
    }
    return frames;
}

Result<Capture> readRecord3d(const fs::path& root) {
    std::error_code ignored;
    const fs::path file = root / (fs::exists(root / "metadata.json", ignored) ? "metadata.json" : "metadata");
    const fs::path pictures = root / (fs::is_directory(root / "rgb", ignored) ? "rgb" : "rgbd");
    DPL_TRY(const json metadata, readJsonObject(file));
    const auto all = picturesIn(pictures);
    ImageHeader first;
    if (!metadata.contains("w") || !metadata.contains("h")) {
        if (all.empty())
            return fail(Code::CorruptData, "{} holds no picture; export the recording again as 'EXR + JPG sequence'", pictures.string());
        Result<ImageHeader> header = probeImage(all.front());
        for (size_t i = 1; i < all.size() && !header; ++i) header = probeImage(all[i]);
        if (!header) return header.error();
        first = *header;
    }
    DPL_TRY(const Record3dFrames frames, parseRecord3d(metadata, first, file.string()));
    Capture capture;
    capture.what = "Record3D recording";
    size_t missing = 0;
    LeftOut left;
    for (size_t i = 0; i < frames.cameras.size(); ++i) {
        CapturePicture picture;
        for (const char* extension : {".jpg", ".png"})
            if (picture.image.empty() && fs::is_regular_file(pictures / (std::to_string(i) + extension), ignored))
                picture.image = pictures / (std::to_string(i) + extension);
        if (picture.image.empty()) {
            ++missing;
            continue;
        }
        picture.name = frameName(picture.kind, capture.pictures.size());
        picture.camera = frames.cameras[i];
        if (frames.framesPerSecond > 0) picture.timeS = double(i) / frames.framesPerSecond;
        if (const auto fitted = fitToPictureFile(*picture.camera, picture.image, formatText("{} frame {}", file.string(), i)); !fitted)
            left.add(picture.image.filename(), fitted.error());
        else
            capture.pictures.push_back(std::move(picture));
    }
    DPL_RETURN_IF_ERROR(left.check(capture.pictures.size()));
    if (capture.pictures.empty())
        return fail(Code::CorruptData, "{}: none of the {} frames has a picture in {}; export the recording again as 'EXR + JPG sequence'",
                    file.string(), frames.cameras.size(), pictures.string());
    if (missing > 0) capture.notes.push_back(formatText("{} frames without a picture are left out", missing));
    const size_t posed = frames.cameras.size() - missing;
    if (all.size() > posed) capture.notes.push_back(formatText("{} pictures without a pose are left out", all.size() - posed));
    if (!left.empty()) capture.notes.push_back(left.sentence(frames.cameras.size()));
    return capture;
}

}  // namespace dpl
